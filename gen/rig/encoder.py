"""The encoder on the shaft: one channel, so many pulses a turn, whichever way it turns."""

from __future__ import annotations

import math

import numpy as np

from gen.rig.network import Floats


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

    def edge_times(self, start_s: float, end_s: float, before: float, after: float) -> Floats:
        """Times of the edges in ``(start, end]``, s, at uniform speed; shape (edges,).

        Parameters
        ----------
        start_s, end_s
            The span of time.
        before, after
            Turns at its start and end.
        """
        first, last = self.count(before) + 1, self.count(after)
        if last < first:
            return np.empty(0)
        turns = np.arange(first, last + 1) / self.pulses_per_revolution
        times: Floats = start_s + (turns - before) / (after - before) * (end_s - start_s)
        return times
