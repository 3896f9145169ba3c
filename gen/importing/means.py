"""Rows of one time to one row."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray

_DIGITS = 9


def means(values: FloatArray, kept: IntArray, repeated: IntArray) -> FloatArray:
    """Values with the mean of the rows of one time in the first of them.

    Parameters
    ----------
    values
        Of all rows, NaN where missing, shape (N,).
    kept
        Rows that stay, ascending.
    repeated
        Rows that have the time of one that stays before them.
    """
    rows = np.sort(np.concatenate([kept, repeated]))
    rows = rows[np.isfinite(values[rows]) & (rows >= kept[0])]
    of = np.searchsorted(kept, rows, side="right") - 1
    count = np.bincount(of, minlength=kept.size)
    total = np.bincount(of, weights=values[rows], minlength=kept.size)
    made = values.copy()
    several = count > 1
    made[kept[several]] = np.round(total[several] / count[several], _DIGITS)
    lone = (count == 1) & ~np.isfinite(values[kept])
    made[kept[lone]] = total[lone]
    return made
