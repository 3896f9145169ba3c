"""What a run would meet beside its PWM: the room, the channels, bins of one width."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.bins import Binned
from gen.identification.network.fitting.inputs import Inputs, Levels
from gen.model.network_parts import PWM
from gen.refinement.network.changing.columns import POWERS
from gen.refinement.network.fitting.data import DEGREE, Data


@dataclass(frozen=True, eq=False)
class Stage:
    """Runs from cold, all parts as warm as the room.

    Attributes
    ----------
    data
        The runs that there are: what channels do at each speed.
    full_scale
        The count that is 100 %.
    ambient
        degC.
    bin_s
        Width of the bins.
    noise_K
        Of a single reading, shape (S,), for the record.
    """

    data: Data
    full_scale: int
    ambient: float
    bin_s: float
    noise_K: FloatArray

    def inputs(self, pwm: IntArray) -> Inputs:
        """Put runs side by side.

        Parameters
        ----------
        pwm
            In each bin of each run, shape (K, T), counts.
        """
        runs, bins = pwm.shape
        distinct, level = np.unique(pwm.T, return_inverse=True)
        size, sensors = runs * bins, self.noise_K.size
        begins = np.repeat(self.bin_s * np.arange(bins), runs)
        return Inputs(
            runs=(self._record(bins),) * runs,
            order=np.arange(runs),
            first=runs * np.arange(bins + 1),
            run=np.tile(np.arange(runs), bins),
            level=np.ravel(level),
            begins=begins,
            levels=self._levels(distinct),
            ambient=np.full(size, self.ambient),
            room=np.zeros((size, 0)),
            target=np.zeros((size, sensors)),
            share=np.full((size, sensors), 0.5),
            weight=np.zeros((size, sensors)),
            covered=np.full((size, sensors), self.bin_s),
            begin=np.full((runs, sensors + 1), self.ambient),
            loose=np.zeros((runs, 2)),
            warm=np.zeros(runs),
        )

    def _record(self, bins: int) -> Binned:
        """A run of which only the length counts."""
        none, sensors = np.zeros(bins), self.noise_K.size
        empty = np.zeros((bins, sensors))
        return Binned(
            name="planned",
            edges=np.asarray(self.bin_s * np.arange(bins + 1), dtype=np.float64),
            rest=none,
            speed=none,
            square=none,
            ambient=none,
            reading=empty,
            share=empty,
            covered=empty,
            begin=np.zeros(sensors),
            first=np.zeros(sensors),
            noise_K=self.noise_K,
            sample_s=np.ones(sensors),
            ambient_known=True,
            further=np.zeros((bins, 0)),
        )

    def _levels(self, pwm: IntArray) -> Levels:
        """Distinct PWM as inputs, shape (L,)."""
        speed = np.abs(pwm) / self.full_scale
        rest = (pwm == 0).astype(np.float64)
        channels = np.clip(_by_speed(rest, speed) @ self._usual, *self._range)
        further = np.column_stack([np.ones(pwm.size), (pwm < 0).astype(np.float64), channels])
        if PWM in self.data.columns.channels:
            first = 2 + len(POWERS) * self.data.columns.channels.index(PWM)
            signed = pwm.astype(np.float64)
            further[:, first : first + len(POWERS)] = np.column_stack([signed, signed**2, np.sqrt(np.abs(signed))])
        return Levels(np.full(pwm.size, self.bin_s), rest, speed, speed**2, further)

    @cached_property
    def _usual(self) -> FloatArray:
        """What channels go like with speed, least squares over the runs that there are, shape (DEGREE + 2, E)."""
        levels, width = self._seen
        weight = np.sqrt(width)[:, None]
        known = _by_speed(levels.rest, levels.speed)
        return np.asarray(np.linalg.lstsq(known * weight, levels.further[:, 2:] * weight, rcond=None)[0])

    @cached_property
    def _range(self) -> tuple[FloatArray, FloatArray]:
        further = self._seen[0].further[:, 2:]
        return further.min(axis=0), further.max(axis=0)

    @property
    def _seen(self) -> tuple[Levels, FloatArray]:
        """Inputs of the later runs' bins, and the bins' widths."""
        inputs = self.data.inputs
        at = inputs.level[self.data.is_later]
        every = inputs.levels
        parts = (every.width, every.rest, every.speed, every.square, every.further)
        own = Levels(*(part[at] for part in parts))
        return own, own.width


def _by_speed(rest: FloatArray, speed: FloatArray) -> FloatArray:
    """A polynomial of the speed with a value of its own at rest, shape (L, DEGREE + 2)."""
    turning = 1.0 - rest
    return np.column_stack([rest, *(turning * speed**power for power in range(DEGREE + 1))])
