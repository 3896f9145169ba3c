"""Fractions of a second in a column of their own behind times of whole seconds: `Date&Time | ms`, `Time | Millitm`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from gen.importing import clock
from gen.importing.guessing.times.rewriting import first_joined
from gen.importing.numbers import parse
from gen.importing.table import Column, FloatArray, IntArray, Table
from gen.importing.units import TIME as TIME_QUANTITY
from gen.importing.units import split_name, unit_of

_MILLIS = re.compile(r"ms|m\.?secs?|millis|milli ?seconds?|millitm|millisekunden|millisecondes", re.IGNORECASE)
_SECONDS = re.compile(r"s|secs?|seconds?|fractions?(?: of seconds?)?|subsec(?:onds?)?", re.IGNORECASE)
_MOST_ASTRAY = 0.1
_WHOLE = re.compile(r"\d{1,2}:\d{2}:\d{2}(?![.,:]?\d)")


def with_fractions(table: Table) -> Table:
    """Give times of whole seconds the fractions that the column behind them holds; other tables stay as they are.

    Parameters
    ----------
    table
        As it was read.
    """
    return first_joined(table, lambda before, column: _in_one(before, column, table.reading.decimal))


def _in_one(before: Column, column: Column, mark: str) -> tuple[list[str], str] | None:
    scale = _scale(column)
    if not scale or not isinstance(before.cells, list) or clock.kind_of(before.cells) not in ("instant", "clock"):
        return None
    found = _fractions(column, scale, mark)
    if found is None or not all(_WHOLE.search(cell) for cell in before.cells if cell.strip()):
        return None
    if not _rise_within(before.cells, found):
        return None
    digits = 3 if not (found % 1000).any() else 6
    shown = (f"{part:06d}"[:digits] for part in found.tolist())
    cells = [_WHOLE.sub(rf"\g<0>.{part}", cell, count=1) for cell, part in zip(before.cells, shown, strict=True)]
    return cells, f"fraction of a second from {column.name}"


def _rise_within(cells: Sequence[str], parts: IntArray) -> bool:
    """Whether fractions rise from row to row of one second, as those of a loop's own time do not."""
    steps = [b - a for (one, a), (other, b) in pairwise(zip(cells, parts.tolist(), strict=True)) if one == other]
    return sum(1 for step in steps if step <= 0) <= _MOST_ASTRAY * len(steps)


def _scale(column: Column) -> float:
    """What 1 of a column's numbers is in us, by its name or unit; 0 for what is no fraction of a second."""
    base, unit, _ = split_name(column.name)
    unit = unit or unit_of(column.unit)
    if unit is not None and unit.quantity != TIME_QUANTITY:
        return 0.0
    if _MILLIS.fullmatch(base):
        return 1e3
    return 1e6 if _SECONDS.fullmatch(base) else 0.0


def _fractions(column: Column, scale: float, mark: str) -> IntArray | None:
    """In whole us; None where a number is none, or a second or more."""
    values: FloatArray = (
        parse(column.cells, mark or ".").values if isinstance(column.cells, list) else np.asarray(column.cells)
    )
    if values.dtype.kind != "f":
        return None
    parts = np.round(values * scale)
    return parts.astype(np.int64) if bool(np.all((parts >= 0) & (parts < 1e6))) else None
