"""Temperatures that are told in another unit from some row on, which no column says."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gen.arrays import FloatArray
from gen.importing.sequence import gap_length

_LEAST_K, _OFF_K = 15.0, 2.0
"""How far a reading goes at once, and how far it may lie off the same temperature in the other unit."""
_ALONE = 4.0
"""Times the largest other step that a column goes where it is the only one."""


def switched_at(temps: Mapping[str, FloatArray], time_s: FloatArray) -> tuple[int, str] | None:
    """Find the row from which on all temperatures are those before in another unit.

    Parameters
    ----------
    temps
        By the column of the run file, the ambient's among them, as if all were in degC; NaN where missing, shape (n,).
    time_s
        Of the rows, shape (n,): behind a gap, or where the clock begins anew, a motor may be anything.

    Returns
    -------
    row, unit
        The first row, and what its readings are in (``degF``, or ``degC`` where those before were); None for none.
    """
    known = [values for values in temps.values() if np.isfinite(values).sum() > 1]
    if not known:
        return None
    found = [_switches(values, time_s, alone=len(known) == 1) for values in known]
    common = set.intersection(*map(set, found))
    return min(common) if common else None


def _switches(values: FloatArray, time_s: FloatArray, *, alone: bool) -> list[tuple[int, str]]:
    """Rows at which a column may have changed its unit, and to which."""
    rows = np.flatnonzero(np.isfinite(values) & np.isfinite(time_s))
    before, after = values[rows[:-1]], values[rows[1:]]
    later = np.diff(time_s[rows])
    goes_on = (later > 0.0) & (later <= gap_length(time_s[rows]))
    steps = np.where(goes_on, np.abs(after - before), 0.0)
    made = []
    for k in np.flatnonzero(steps >= _LEAST_K).tolist():
        if alone and steps[k] < _ALONE * np.delete(steps, k).max(initial=0.0):
            continue
        for one, other, unit in ((before[k], after[k], "degF"), (after[k], before[k], "degC")):
            if abs(1.8 * one + 32.0 - other) <= _OFF_K:
                made.append((int(rows[k + 1]), unit))
    return made
