"""What else drives a motor, as columns of the fit: whether the run is later than the model, the sense of rotation,
each channel with what a polynomial in it needs, and what laws carry beyond a conductance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels

POWERS = (1, 2, 0.5)
"""Of a channel: their means are exact, however much it moves within a bin. The root is that of its size."""
_FIRST = 2


@dataclass(frozen=True)
class Columns:
    """Places of the columns.

    Attributes
    ----------
    channels
        Their names, in order.
    excesses
        How many laws there are, and whose excess each is (`excess.py`).
    """

    channels: tuple[str, ...]
    excesses: int = 0

    def of_run(
        self, pwm: FloatArray, told: Mapping[str, FloatArray], excess: Sequence[FloatArray], *, later: bool
    ) -> list[FloatArray]:
        """Give a run's columns, shape (rows,) each.

        Parameters
        ----------
        pwm
            Signed, counts.
        told
            Every channel's values, without gaps.
        excess
            Of each law, K.
        later
            Whether the run may show what the model lacks.
        """
        made = [np.full(pwm.size, float(later)), (pwm < 0).astype(np.float64)]
        for name in self.channels:
            made += [told[name], told[name] ** 2, np.sqrt(np.abs(told[name]))]
        return [*made, *excess]

    def later(self, levels: Levels) -> FloatArray:
        """Whether an input is of a later run, 0 or 1, shape (L,)."""
        return levels.further[:, 0]

    def backwards(self, levels: Levels) -> FloatArray:
        """Share of time turning backwards, shape (L,)."""
        return levels.further[:, 1]

    def power(self, levels: Levels, channel: str, power: float) -> FloatArray:
        """Mean of a channel's power 1, 2 or 1/2, shape (L,)."""
        return levels.further[:, _FIRST + len(POWERS) * self.channels.index(channel) + POWERS.index(power)]

    def excess(self, levels: Levels, number: int) -> FloatArray:
        """What a law carries beyond a conductance, for each W/K, shape (L,), K."""
        return levels.further[:, _FIRST + len(POWERS) * len(self.channels) + number]
