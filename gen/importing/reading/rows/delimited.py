"""Rows of cells, with whatever stands before, between and behind them, to a table."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np

from gen.errors import InputError
from gen.importing.numbers import decimal_mark, thousands_or_fractions
from gen.importing.reading.rows.annotated import of_one_head
from gen.importing.reading.rows.broken_off import broken_off
from gen.importing.reading.rows.cells import without_colons
from gen.importing.reading.rows.channels import have_own_times, units_by_channel
from gen.importing.reading.rows.heads import is_label, listed_units, paired_head, parted_decimals, with_labels
from gen.importing.reading.rows.intervals import told_interval
from gen.importing.reading.rows.kinds import is_data, is_head, is_number, is_reading
from gen.importing.reading.rows.later_heads import under_one_head
from gen.importing.reading.rows.named import check_surplus, lacks_a_name, names_above
from gen.importing.reading.rows.shifted import first_name, milliseconds, parts_times
from gen.importing.reading.rows.transposed import upright
from gen.importing.reading.rows.unit_columns import with_units
from gen.importing.reading.tagged.prometheus import without_labels
from gen.importing.table import Column, Counted, Reading, Table, unique_names

_FOUND = 0.95
"""Confidence of a decimal mark that numbers show."""
_SAMPLE = 400
_MOST_LOST = 0.5
_HEAD_LINES = 20
_FEW_HEADS = 2
"""Lines of names and of units, which are no list of channels."""
_LONGEST_PREAMBLE = 100
"""Lines that come before a header, at most."""
_SHOWN = 40
MOST_COLUMNS = 2000


def table_of_rows(
    file: Path,
    rows: list[list[str]],
    numbers: list[int],
    *,
    reading: Reading,
    word: str = "line",
    part: str = "",
    comments: Sequence[str] = (),
    times: Sequence[str] = (),
    ended: bool = True,
) -> Table:
    """Find header, units and rows, and count what is none of them.

    Parameters
    ----------
    file, part, word
        Of the table.
    rows, numbers
        Cells, and the line of each.
    reading
        Encoding and delimiter; the decimal mark is guessed where it is empty.
    comments
        The comment lines.
    times
        Time of day of each row, where a serial monitor wrote one.
    ended
        Whether the last line has an end.

    Raises
    ------
    InputError
        Without a file name, with a place: no rows, or too much that is none.
    """
    lying = upright(rows) if not times else None
    if lying is not None:
        rows, numbers, word, ended = *lying, "column", True
    rows, numbers = of_one_head(rows, numbers)
    rows, told = under_one_head(rows, numbers, word)
    width = _width(rows)
    if width > MOST_COLUMNS:
        raise InputError(f"found {width} columns, expected {MOST_COLUMNS} at most", place=f"{word} {numbers[0]}")
    first, names, units = _titled(rows, _first_row(rows, numbers, width, word), width, comments)
    check_surplus(rows[:first], numbers, width, word)
    good, counted = _sorted_out(rows, numbers, first, width, names, told, word)
    if not ended and (cut := broken_off(rows, good, word, numbers[-1])):
        good, counted = good[:-1], [*counted, cut]
    if len(good) < _MOST_LOST * (len(rows) - first):
        raise InputError(
            f"only {len(good)} of {len(rows) - first} lines are rows of {width} columns; expected one table",
            place=counted[0].first,
        )
    cells = [list(column) for column in zip(*(rows[i] for i in good), strict=True)]
    cells[0] = without_colons(cells[0])
    if not names:
        names = [f"column_{i + 1}" for i in range(width)]
    names = without_labels(names)
    if lacks_a_name(rows[:first], width):
        names, units = _shifted(names, units, cells, reading, f"{word} {numbers[good[0]]}")
    if times:
        names, units, cells = ["clock", *names], ["", *units], [[times[i] for i in good], *cells]
    kept = [i for i, name in enumerate(names) if name.strip() or any(cell.strip() for cell in cells[i])]
    return Table(
        file,
        with_units(
            [
                Column(name, cells[i], units[i].strip())
                for i, name in zip(kept, unique_names([names[i] for i in kept]), strict=True)
            ]
        ),
        np.array([numbers[i] for i in good], dtype=np.int64),
        word,
        part,
        keyed_comments(comments),
        _with_decimal(reading, cells),
        tuple(counted),
        told_interval(rows[:first], comments),
    )


def _shifted(
    names: list[str], units: list[str], cells: Sequence[list[str]], reading: Reading, place: str
) -> tuple[list[str], list[str]]:
    """Names of a header that has one less than its rows, each on the column that it is of."""
    if not names[0].strip() or not any(map(str.strip, cells[-1])):
        return names, units
    if first := first_name(names, cells):
        return [first, *names[:-1]], ["", *units[:-1]]
    if parts_times(names, cells):
        return [names[0], "clock", *names[1:-1]], [units[0], "", *units[1:-1]]
    if reading.delimiter != ",":
        return names, units
    less = "has a name less than its rows have fields"
    at, sure = milliseconds(names, cells)
    if at and not sure:
        raise InputError(
            f"{less}: is {cells[at - 1][0]},{cells[at][0]} one time, with a comma before its milliseconds? "
            "expected a name for each column between commas, or a point before milliseconds",
            place=place,
        )
    if at:
        return [*names[:at], "ms", *names[at:-1]], [*units[:at], "", *units[at:-1]]
    if number := parted_decimals(names, cells):
        raise InputError(
            f"{less}: is {number} one number, with a decimal comma among the commas "
            "between columns? expected another mark between columns, or decimal points",
            place=place,
        )
    return names, units


def _first_row(rows: Sequence[Sequence[str]], numbers: Sequence[int], width: int, word: str) -> int:
    """Where numbers begin."""
    for is_one in (is_data, is_reading):
        found = next((i for i, row in enumerate(rows) if is_one(row, width)), None)
        if found is not None:
            while found > 0 and is_reading(rows[found - 1], width):  # with more words than the first of numbers
                found -= 1
            return found
    shown = " | ".join(rows[0])[:_SHOWN] if rows else "nothing"
    raise InputError(
        f'found no row of numbers, only such as "{shown}"; expected a header line and rows',
        place=f"{word} {numbers[-1] if numbers else 1}",
    )


def _titled(
    rows: Sequence[list[str]], first: int, width: int, comments: Sequence[str]
) -> tuple[int, list[str], list[str]]:
    """Where rows begin behind the lines above them, and what these say: names, which may be none, and units."""
    paired = paired_head(rows[:_LONGEST_PREAMBLE], width)
    if paired is not None:
        at, names, units = paired
        return next((i for i in range(at + 1, len(rows)) if is_data(rows[i], width)), first), names, units
    first = _behind_labels(rows, first, width)
    names, units = names_above(rows[:first], width, comments)
    if not names:
        first = _behind_a_preamble(rows, first, width)
        names, units = names_above(rows[:first], width, comments)
    if names and have_own_times(names):
        units = units_by_channel(rows[:first], names)
    elif names and not any(units):
        units = listed_units(rows[:first], comments, names) or units
    return first, with_labels(names, rows[: max(first - _FEW_HEADS, 0)]), units


def keyed_comments(comments: Sequence[str]) -> dict[str, str]:
    """Comments as a run file has them; only those that say ``key: value``."""
    found = {}
    for text in comments:
        key, colon, value = text.partition(":")
        if colon and key.strip() and len(key) <= _SHOWN:
            found[key.strip()] = value.strip()
    return found


def _with_decimal(reading: Reading, cells: Sequence[Sequence[str]]) -> Reading:
    if reading.decimal:
        return reading
    step = max(1, len(cells[0]) // 2000)
    mark, confidence, why = decimal_mark(chain.from_iterable(column[::step] for column in cells))
    unsure = "" if confidence >= 0.6 else why
    if mark == "." and confidence < _FOUND:
        unsure = unsure or thousands_or_fractions(cells)
    return replace(reading, decimal=mark, unsure=unsure, why={**reading.why, "decimal": why})


def _width(rows: Sequence[Sequence[str]]) -> int:
    counts = Counter(map(len, rows))
    wide = {width: count for width, count in counts.items() if width > 1}
    return max(wide or counts, key=lambda width: (counts[width], width), default=1)


def _behind_a_preamble(rows: Sequence[list[str]], first: int, width: int) -> int:
    """The first row of the table where lines of a preamble (`Samples 120`) look like rows: behind a later header."""
    for i in range(first, min(first + _LONGEST_PREAMBLE, len(rows))):
        if not is_data(rows[i], width):
            continue
        if is_number(rows[i][0]):
            return i if i > first and abs(len(rows[i - 1]) - width) <= 1 and is_head(rows[i - 1]) else first
    return first


def _behind_labels(rows: Sequence[list[str]], first: int, width: int) -> int:
    """The first row behind lines that say what they hold (`Wf_increment,1,1`) where rows say nothing there."""
    if not any(row and is_label(row[0]) for row in rows[:first]):
        return first
    behind = [row[0].strip() for row in rows[first : first + _HEAD_LINES] if len(row) == width]
    labels = next((i for i, cell in enumerate(behind) if not cell), 0)
    told = all(re.search(r"[^\W\d_]", cell) and not is_number(cell) for cell in behind[:labels])
    return first + labels if told and not any(behind[labels:]) else first


def _sorted_out(
    rows: Sequence[list[str]],
    numbers: Sequence[int],
    first: int,
    width: int,
    names: Sequence[str],
    told: Mapping[int, str],
    word: str,
) -> tuple[list[int], list[Counted]]:
    """Rows that are some, and what the others are."""
    good: list[int] = []
    others: dict[str, list[int]] = {}
    head = [name.strip() for name in names]
    for i in range(first, len(rows)):
        row = rows[i]
        if i in told:
            others.setdefault(told[i], []).append(i)
        elif head and row and row[0].strip() == head[0] and [cell.strip() for cell in row] == head:
            others.setdefault("repeated header", []).append(i)
        elif len(row) == width and (row[0][:1].isdigit() or any(map(_may_be_number, row))):
            good.append(i)
        else:
            others.setdefault(f"line that is no row of {width} columns", []).append(i)
    return good, [Counted(what, len(found), f"{word} {numbers[found[0]]}") for what, found in others.items()]


def _may_be_number(cell: str) -> bool:
    return any(map(str.isdigit, cell))
