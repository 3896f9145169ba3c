"""Missing samples of a channel, and gaps in it."""

from __future__ import annotations

import numpy as np

from gen.arrays import BoolArray, FloatArray

MISSING = 1.5
"""Without values for longer than so many of a column's usual distances, while there are rows: a gap."""
_USUAL = 0.9
"""Of the distances between a column's values so many are no longer than the usual one: a sensor that is slower than the
rows, and falls on every second or third of them, has no gaps."""
SILENT = 20.0
"""The same where there are no rows either: a log whose rows come unevenly has no gap at each long step."""


def held_over_gaps(values: FloatArray) -> FloatArray:
    """Each missing sample replaced by the latest one before it (the first one before all); not all may be missing."""
    known = np.flatnonzero(~np.isnan(values))
    latest = np.searchsorted(known, np.arange(values.size), side="right") - 1
    held: FloatArray = values[known[np.maximum(latest, 0)]]
    return held


def gaps(time_s: FloatArray, values: FloatArray) -> BoolArray:
    """Find out after which of a column's known values there is a gap.

    Parameters
    ----------
    time_s, values
        Shape (N,); NaN where nothing was measured.

    Returns
    -------
    NDArray
        Shape (K,) for K known values; the last is False.
    """
    known = np.flatnonzero(np.isfinite(values))
    found = np.zeros(known.size, dtype=np.bool_)
    if known.size < 2:
        return found
    distance, rows = np.diff(time_s[known]), np.diff(known)
    usual = float(np.quantile(distance, _USUAL, method="inverted_cdf"))
    found[:-1] = ((rows > 1) & (distance > MISSING * usual)) | (distance > SILENT * usual)
    return found
