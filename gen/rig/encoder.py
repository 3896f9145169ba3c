"""The encoder on the shaft: one channel, so many pulses a turn, whichever way it turns."""

from __future__ import annotations

import math


class Encoder:
    """Counts rising edges from the turns that the shaft has made.

    Parameters
    ----------
    pulses_per_revolution
        500 in the study: 22 083 edges a second at 2650 rpm.
    """

    def __init__(self, pulses_per_revolution: int = 500) -> None:
        self.pulses_per_revolution = pulses_per_revolution

    def count(self, revolutions: float) -> int:
        """Edges since the start, after so many turns (`Motor.revolutions`)."""
        return math.floor(revolutions * self.pulses_per_revolution)

    def between(self, before: float, after: float) -> int:
        """Edges while the turns went from `before` to `after`."""
        return self.count(after) - self.count(before)
