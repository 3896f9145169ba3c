"""Rows as they can be in a run: sums and means below a log have no time, and tell nothing of what its columns are."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.errors import InputError
from gen.importing.converted import Converted
from gen.importing.guessing.evidence import Evidence
from gen.importing.mapping import TimeForm
from gen.importing.timing import timed


def of_timed_rows(evidence: Evidence, form: TimeForm, *, in_order: bool = False) -> Evidence:
    """The columns in the rows that have a time; in all of them where that is none of these.

    Parameters
    ----------
    evidence
        The columns.
    form
        What the time is.
    in_order
        Put the rows in the order of their times: what an export newest first begins with is its end.
    """
    try:
        times = [timed(evidence, i, form, Converted(t))[0] for i, t in enumerate(evidence.tables)]
    except InputError:
        return evidence  # which is told when rows are made
    rows = [_kept(time, in_order) for time in times]
    as_they_are = all(np.array_equal(kept, np.arange(time.size)) for kept, time in zip(rows, times, strict=True))
    if as_they_are or not all(kept.size for kept in rows):
        return evidence
    return Evidence([table.of_rows(kept) for table, kept in zip(evidence.tables, rows, strict=True)])


def _kept(time: FloatArray, in_order: bool) -> IntArray:
    known = np.flatnonzero(np.isfinite(time))
    return known[np.argsort(time[known], kind="stable")] if in_order else known
