"""Headers that lack a name which is not the last one's: of numbers of rows, or of parts of times."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

from gen.importing.clock import is_time, kind_of
from gen.importing.guessing.names import AMBIENT, OTHER, PARTS, TIME
from gen.importing.numbers import plain_number
from gen.importing.reading.rows.kinds import is_number
from gen.importing.units import TIME as TIME_QUANTITY
from gen.importing.units import split_name

_SAMPLE = 400
_LEAST = 3
"""Columns."""
_LEAST_RISING = 10
"""Rows."""
_WHOLE_SECONDS = re.compile(r"\d{1,2}:\d{2}:\d{2}$")
_MILLIS = re.compile(r"\d{1,3}")
_DIGITS = 3
_MOST_PWM = 255
_LEAST_DIFFERENT = 0.5
"""Of the rows, whose milliseconds are not those of any other."""
_MOSTLY = 0.5


def first_name(names: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    """What the first column is, where it is that without a name: "row" or "time", as R or rrdtool write; else empty.

    Parameters
    ----------
    names
        Of all columns; the header lacks one.
    cells
        Of the columns.
    """
    first = list(cells[0][:_SAMPLE])
    timed = next((i for i, name in enumerate(names) if _is_time(name)), None)
    if timed is None and _is_quantity(names[0]):
        if kind_of(first) in ("instant", "clock") or _rises_always(first):
            return "time"
        if not any(map(is_number, first)):
            return "row"
    if len(names) < _LEAST or len(first) < 2 or first not in ([str(i + k) for i in range(len(first))] for k in (0, 1)):
        return ""
    return "row" if timed is None or _rises(cells[timed + 1][:_SAMPLE]) else ""


def parts_times(names: Sequence[str], cells: Sequence[Sequence[str]]) -> bool:
    """Whether the mark between columns, such as a space, parts the first one's dates from their times of day.

    Parameters
    ----------
    names
        Of all columns; the header lacks one.
    cells
        Of the columns.
    """
    kinds = [kind_of(column[:_SAMPLE]) for column in cells[:2]]
    return kinds == ["date", "clock"] and not _is_time(names[1])


def milliseconds(names: Sequence[str], cells: Sequence[Sequence[str]]) -> tuple[int, bool]:
    """The column that a comma parted from times, before their milliseconds, as Python's logging and log4j write them.

    Parameters
    ----------
    names
        Of all columns; the header lacks one, and commas part the columns.
    cells
        Of the columns.

    Returns
    -------
    at, sure
        0 where there is none; and whether the numbers can be nothing else.
    """
    if len(names) < _LEAST or (split_name(names[-2])[1] and any(map(_is_word, cells[-1]))):
        return 0, False
    for at, (times, parts) in enumerate(pairwise(cells), start=1):
        if all(map(_MILLIS.fullmatch, parts)) and all(map(_WHOLE_SECONDS.search, times)):
            sample = parts[:_SAMPLE]
            go_far = max(map(int, parts)) > _MOST_PWM and len(set(sample)) >= _LEAST_DIFFERENT * len(sample)
            of_three = all(len(part) == _DIGITS for part in parts)
            return at if go_far or of_three else 0, go_far and of_three
    return 0, False


def _is_time(name: str) -> bool:
    base, unit, _ = split_name(name)
    return bool(TIME.fullmatch(base.casefold())) or (unit is not None and unit.quantity == TIME_QUANTITY)


def _is_quantity(name: str) -> bool:
    return split_name(name)[1] is not None or any(words.search(name) for words in (PARTS, AMBIENT, OTHER))


def _is_word(cell: str) -> bool:
    return any(map(str.isalpha, cell)) and plain_number(cell.strip()) is None


def _rises_always(cells: Sequence[str]) -> bool:
    """Whether numbers rise in every row, as a time does, and no quantity of a motor that also rests."""
    numbers = [plain_number(cell.strip()) for cell in cells]
    return len(numbers) >= _LEAST_RISING and all(
        a is not None and b is not None and a < b for a, b in pairwise(numbers)
    )


def _rises(cells: Sequence[str]) -> bool:
    """Whether a column may be one of times, of which a few may be the same."""
    if all(is_time(cell.strip()) for cell in cells):
        return True
    numbers = [plain_number(cell.strip().replace(",", ".")) for cell in cells]
    known = [number for number in numbers if number is not None]
    steps = [b - a for a, b in pairwise(known)]
    return len(known) == len(cells) and min(steps) >= 0 and sum(step > 0 for step in steps) > _MOSTLY * len(steps)
