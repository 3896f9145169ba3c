"""Long series made short for pictures: the extremes of equal spans of time are kept, so that no peak is lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Samples:
    """Values and their times, s, as many each; no value is missing."""

    time_s: FloatArray
    values: FloatArray

    def thinned(self, most: int) -> Samples:
        """The first, the last, and the least and largest of equal spans of time: at most `most` of them (4 or more)."""
        if self.time_s.size <= most:
            return self
        spans = (most - 2) // 2
        ends = np.linspace(self.time_s[0], self.time_s[-1], spans + 1)[1:-1]
        kept = [0, self.time_s.size - 1]
        for part in np.split(np.arange(self.time_s.size), np.searchsorted(self.time_s, ends)):
            if part.size:
                kept += [int(part[np.argmin(self.values[part])]), int(part[np.argmax(self.values[part])])]
        chosen = np.unique(kept)
        return Samples(self.time_s[chosen], self.values[chosen])


def measured(time_s: FloatArray, values: FloatArray) -> Samples:
    """Samples of a series in which values are missing (NaN)."""
    good = np.isfinite(values)
    return Samples(time_s[good], values[good])


def held(time_s: FloatArray, values: FloatArray) -> Samples:
    """Samples of what is held from one row to the next: its changes, and the ends."""
    changed = np.flatnonzero(np.diff(values) != 0.0) + 1
    chosen = np.unique([0, *changed.tolist(), time_s.size - 1])
    return Samples(time_s[chosen], values[chosen])
