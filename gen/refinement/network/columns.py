"""What else drives a motor, as columns of the fit: whether the run is later than the model, the sense of rotation,
and each channel with what a polynomial in it needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels

POWERS = (1, 2, 3)
"""Of a channel: means of these are exact, however much it moves within a bin."""
_FIRST = 2


@dataclass(frozen=True)
class Columns:
    """Places of the columns.

    Attributes
    ----------
    channels
        Their names, in order.
    """

    channels: tuple[str, ...]

    def of_run(self, pwm: FloatArray, told: Mapping[str, FloatArray], *, later: bool) -> list[FloatArray]:
        """Give a run's columns, shape (rows,) each.

        Parameters
        ----------
        pwm
            Signed, counts.
        told
            Every channel's values, without gaps.
        later
            Whether the run may show what the model lacks.
        """
        made = [np.full(pwm.size, float(later)), (pwm < 0).astype(np.float64)]
        for name in self.channels:
            made += [told[name] ** power for power in POWERS]
        return made

    def later(self, levels: Levels) -> FloatArray:
        """Whether an input is of a later run, 0 or 1, shape (L,)."""
        return levels.further[:, 0]

    def backwards(self, levels: Levels) -> FloatArray:
        """Share of time turning backwards, shape (L,)."""
        return levels.further[:, 1]

    def power(self, levels: Levels, channel: str, power: int) -> FloatArray:
        """Mean of a channel's power 0..3, shape (L,)."""
        if power == 0:
            return np.ones(levels.count)
        return levels.further[:, _FIRST + len(POWERS) * self.channels.index(channel) + POWERS.index(power)]

    def polynomial(self, levels: Levels, channel: str, coefficients: Sequence[float]) -> FloatArray:
        """Mean of a polynomial in a channel, highest power first, shape (L,)."""
        degree = len(coefficients) - 1
        return np.asarray(sum(c * self.power(levels, channel, degree - k) for k, c in enumerate(coefficients)))
