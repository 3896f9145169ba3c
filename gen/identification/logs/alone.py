"""Readings that stand alone: far off the one before and the one after, which agree, while the input was held.

The check of jumps (see `believed`) says little where rows are far apart: in 30 s a part may change by 150 K. But heat
that does not change cannot warm a part by tens of kelvin within a row and cool it again within the next.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray

LEAST_K = 3.0
"""What is nearer to its neighbours than this is left to the fit."""
TIMES = 10.0
"""And than so many times what neighbours usually differ by: where an input that is switched between rows moves a part
from row to row, that is much."""
AGREE = 3.0
"""Times by which the reading is further off than its neighbours are apart."""


def standing_alone(values: FloatArray, pwm: IntArray) -> BoolArray:
    """Say which readings stand alone, shape (N,).

    Parameters
    ----------
    values
        Shape (N,), degC; NaN where missing.
    pwm
        Shape (N,), held from each row to the next.
    """
    found = np.zeros(values.size, dtype=bool)
    known = np.flatnonzero(np.isfinite(values))
    if known.size < 3:
        return found
    before, here, after = values[known[:-2]], values[known[1:-1]], values[known[2:]]
    off = np.where((here - before) * (here - after) > 0.0, np.minimum(np.abs(here - before), np.abs(here - after)), 0.0)
    usual = float(np.median(np.abs(np.diff(values[known]))))
    changes = np.append(0, np.cumsum(np.diff(pwm) != 0))
    held = changes[known[2:]] == changes[known[:-2]]
    far = (off > max(LEAST_K, TIMES * usual)) & (off > AGREE * np.abs(after - before))
    found[known[1:-1][far & held]] = True
    return found
