"""Times of four numbers: days, hours, minutes and seconds (`0:08:15:00`), or a fraction last (`08:15:00:12`)."""

from __future__ import annotations

import re

import numpy as np

from gen.arrays import FloatArray
from gen.importing.guessing.times.plain_steps import evenness
from gen.importing.guessing.times.rewriting import each_rewritten
from gen.importing.table import Column, Table

_FOUR = re.compile(r"(\d{1,4}):(\d{1,2}):(\d{2}):(\d{2})(?:[.,](\d{1,9}))?", re.ASCII)
_LEAST_ROWS = 3
_SOUND = 0.95
"""Of the cells; others are damaged."""
_HOURS, _SIXTY = 24, 60


def with_days(table: Table) -> Table:
    """Put a point behind the days of such times; a table without them stays as it is.

    Parameters
    ----------
    table
        As it was read.
    """
    return each_rewritten(table, _with_day)


def _with_day(column: Column) -> tuple[list[str], str] | None:
    parts = _parts(column)
    if parts is None:
        return None
    cells = [str(cell).strip() for cell in column.cells]
    if _has_days(parts):
        parted = [cell.replace(":", ".", 1) if _FOUR.fullmatch(cell) else cell for cell in cells]
        return parted, f"time of {column.name} taken for days, hours, minutes and seconds"
    if len(set(parts[:, 3].tolist())) > 1:
        return cells, f"time of {column.name} whose last two digits were taken for hundredths of a second"
    return None


def _parts(column: Column) -> FloatArray | None:
    """The four numbers of each such time, shape (N, 4); None where more than a few cells are none."""
    cells = column.cells
    if not isinstance(cells, list) or len(cells) < _LEAST_ROWS:
        return None
    if not any(map(_FOUR.fullmatch, (cell.strip() for cell in cells[:_LEAST_ROWS]))):  # which most columns end at
        return None
    found = [match for cell in cells if (match := _FOUR.fullmatch(cell.strip()))]
    if len(found) < _SOUND * len(cells):
        return None
    return np.array([[float(part) for part in match.groups()[:4]] for match in found])


def _has_days(parts: FloatArray) -> bool:
    """Whether the first number counts days: where the others may be a time of day that goes on as evenly, or more."""
    days, hours, minutes, seconds = parts.T
    if (hours >= _HOURS).any() or (minutes >= _SIXTY).any() or (seconds >= _SIXTY).any():
        return False
    with_days = ((days * _HOURS + hours) * _SIXTY + minutes) * _SIXTY + seconds
    without = (days * _SIXTY + hours) * _SIXTY + minutes + seconds / 100.0
    return evenness(np.diff(with_days)) >= evenness(np.diff(without))
