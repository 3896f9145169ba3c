"""The rows that can be in a run: sums and means below a log have no time, and tell nothing of what its columns are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gen.errors import InputError
from gen.importing.converted import Converted
from gen.importing.guessing.evidence import Evidence
from gen.importing.mapping import TimeForm
from gen.importing.table import Column, Table
from gen.importing.timing import timed


def of_timed_rows(evidence: Evidence, form: TimeForm) -> Evidence:
    """The columns in the rows that have a time; in all of them where that is none of these.

    Parameters
    ----------
    evidence
        The columns.
    form
        What the time is.
    """
    try:
        known = [np.isfinite(timed(evidence, i, form, Converted(t))[0]) for i, t in enumerate(evidence.tables)]
    except InputError:
        return evidence  # which is told when rows are made
    if all(rows.all() for rows in known) or not all(rows.any() for rows in known):
        return evidence
    return Evidence([_rows(table, rows) for table, rows in zip(evidence.tables, known, strict=True)])


def _rows(table: Table, known: NDArray[np.bool_]) -> Table:
    kept = np.flatnonzero(known)
    return replace(table, columns=[_cells(column, kept) for column in table.columns], places=table.places[kept])


def _cells(column: Column, kept: NDArray[np.int64]) -> Column:
    cells = column.cells
    return replace(column, cells=[cells[i] for i in kept.tolist()] if isinstance(cells, list) else cells[kept])
