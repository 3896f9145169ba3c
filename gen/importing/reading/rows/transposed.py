"""Tables that lie: a row for each channel, a column for each time."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from gen.importing.clock import is_time
from gen.importing.guessing.names import TIME
from gen.importing.numbers import plain_number
from gen.importing.reading.rows.heads import is_units
from gen.importing.units import TIME as TIME_QUANTITY
from gen.importing.units import split_name

_LEAST_TIMES = 8
_LEAST_CHANNELS = 2
_MOST_BEFORE = 3
"""Columns before those of times: a channel's name, its unit, where it is."""
_LONGEST_PREAMBLE = 20
_LEAST_FILLED = 0.5


def upright(rows: Sequence[list[str]]) -> tuple[list[list[str]], list[int]] | None:
    """A lying table with a row for each time.

    Parameters
    ----------
    rows
        Of a file.

    Returns
    -------
    rows, numbers
        Names, units where there are some, then a row for each time; and the column of each. None of a table that does
        not lie.
    """
    for at, row in enumerate(rows[:_LONGEST_PREAMBLE]):
        before = next((k for k in range(1, _MOST_BEFORE + 1) if _are_times(row[k:])), 0)
        if not before or _is_value(row[0]):
            continue
        if any(len(other) == len(row) for other in rows[:at]):  # below a header
            return None
        channels = [other for other in rows[at + 1 :] if any(cell.strip() for cell in other)]
        if not _are_channels(channels, before, len(row)):
            return None
        turned = _turned(row, channels, before)
        heads = len(turned) - (len(row) - before)
        return turned, [*[1] * heads, *range(before + 1, len(row) + 1)]
    return None


def _turned(times: list[str], channels: Sequence[list[str]], before: int) -> list[list[str]]:
    base, unit, _ = split_name(times[0].strip())
    said = TIME.fullmatch(base.casefold()) or (unit is not None and unit.quantity == TIME_QUANTITY)
    turned = [list(column) for column in zip(times, *channels, strict=True)]
    names = [times[0] if said else "time", *turned[0][1:]]
    units = [["-", *(cell or "-" for cell in column[1:])] for column in turned[1:before] if is_units(column[1:])]
    return [names, *units[:1], *turned[before:]]


def _are_times(cells: Sequence[str]) -> bool:
    """Whether a row's cells are times, or numbers that rise."""
    if len(cells) < _LEAST_TIMES:
        return False
    if all(is_time(cell.strip()) for cell in cells):
        return True
    numbers = [plain_number(cell.strip(), ",") if "," in cell else plain_number(cell.strip()) for cell in cells]
    known = [number for number in numbers if number is not None]
    return len(known) == len(cells) and all(a < b for a, b in pairwise(known))


def _are_channels(rows: Sequence[Sequence[str]], before: int, width: int) -> bool:
    """Whether rows are each called otherwise, and hold numbers."""
    if not _LEAST_CHANNELS <= len(rows) < width or any(len(row) != width for row in rows):
        return False
    labels = {row[0].strip() for row in rows}
    if len(labels) < len(rows) or any(not label or _is_value(label) for label in labels):
        return False
    return all(_share([_is_number(cell) for cell in row[before:] if cell.strip()]) > _LEAST_FILLED for row in rows)


def _share(tests: Sequence[bool]) -> float:
    return sum(tests) / len(tests) if tests else 1.0


def _is_number(cell: str) -> bool:
    return plain_number(cell.strip()) is not None or plain_number(cell.strip(), ",") is not None


def _is_value(cell: str) -> bool:
    return _is_number(cell) or is_time(cell.strip())
