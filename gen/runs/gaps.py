"""Missing samples of a channel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def held_over_gaps(values: Array) -> Array:
    """Each missing sample replaced by the latest one before it (the first one before all); not all may be missing."""
    known = np.flatnonzero(~np.isnan(values))
    latest = np.searchsorted(known, np.arange(values.size), side="right") - 1
    held: Array = values[known[np.maximum(latest, 0)]]
    return held
