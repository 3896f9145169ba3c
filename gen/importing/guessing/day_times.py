"""Times of four numbers: days, hours, minutes and seconds (`0:08:15:00`), or a fraction last (`08:15:00:12`)."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from gen.importing.table import Column, Counted, FloatArray, Table

_FOUR = re.compile(r"(\d{1,4}):(\d{1,2}):(\d{2}):(\d{2})(?:[.,](\d{1,9}))?", re.ASCII)
_LEAST_ROWS = 3
_SOUND = 0.95
"""Of the cells; others are damaged."""
_EVEN = 0.05
"""Of the usual step, by which even ones differ."""
_HOURS, _SIXTY = 24, 60


def with_days(table: Table) -> Table:
    """Put a point behind the days of such times; a table without them stays as it is.

    Parameters
    ----------
    table
        As it was read.
    """
    made, told = list(table.columns), list(table.counted)
    for i, column in enumerate(table.columns):
        parts = _parts(column)
        if parts is None:
            continue
        if _has_days(parts):
            cells = [str(cell).strip() for cell in column.cells]
            made[i] = replace(column, cells=[c.replace(":", ".", 1) if _FOUR.fullmatch(c) else c for c in cells])
            what = f"time of {column.name} taken for days, hours, minutes and seconds"
        elif len(set(parts[:, 3].tolist())) > 1:
            what = f"time of {column.name} whose last two digits were taken for hundredths of a second"
        else:
            continue
        told.append(Counted(what, len(parts), f"column {column.name}"))
    return replace(table, columns=made, counted=tuple(told)) if len(told) > len(table.counted) else table


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
    return _evenness(with_days) >= _evenness(without)


def _evenness(time: FloatArray) -> float:
    """Which share of steps is the usual one."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    return float((np.abs(steps - usual) <= _EVEN * abs(usual)).mean()) if usual > 0 else 0.0
