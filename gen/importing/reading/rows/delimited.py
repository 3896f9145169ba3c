"""Rows of cells, with whatever stands before, between and behind them, to a table."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np

from gen.errors import InputError
from gen.importing.clock import is_time
from gen.importing.guessing.names import TIME
from gen.importing.numbers import NAN_WORDS, decimal_mark, plain_number, thousands_or_fractions
from gen.importing.reading.rows.annotated import of_one_head
from gen.importing.reading.rows.broken_off import broken_off
from gen.importing.reading.rows.cells import DELIMITERS
from gen.importing.reading.rows.heads import (
    STATISTIC,
    is_label,
    is_units,
    labelled_head,
    listed_units,
    paired_head,
    parted_decimals,
    with_labels,
    with_statistic,
)
from gen.importing.reading.rows.transposed import upright
from gen.importing.reading.rows.unit_columns import with_units
from gen.importing.reading.tagged.prometheus import without_labels
from gen.importing.table import Column, Counted, Reading, Table, unique_names
from gen.importing.units import unit_of

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
_LEAST_SHIFTED = 3
_MILLIS = 3
_RULE = re.compile(r"[-=_*~]{2,}")
"""What stands between a header and its rows, where somebody reads them."""
_WHOLE_SECONDS = re.compile(r"\d{1,2}:\d{2}:\d{2}$")
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
    width = _width(rows)
    if width > MOST_COLUMNS:
        raise InputError(f"found {width} columns, expected {MOST_COLUMNS} at most", place=f"{word} {numbers[0]}")
    first, names, units = _titled(rows, _first_row(rows, numbers, width, word), width, comments)
    good, counted = _sorted_out(rows, numbers, first, width, names, word)
    if not ended and (cut := broken_off(rows, good, word, numbers[-1])):
        good, counted = good[:-1], [*counted, cut]
    if len(good) < _MOST_LOST * (len(rows) - first):
        raise InputError(
            f"only {len(good)} of {len(rows) - first} lines are rows of {width} columns; expected one table",
            place=counted[0].first,
        )
    cells = [list(column) for column in zip(*(rows[i] for i in good), strict=True)]
    if not names:
        names = [f"column_{i + 1}" for i in range(width)]
    if times:
        names, units, cells = ["clock", *names], ["", *units], [[times[i] for i in good], *cells]
    names, units = _shifted(without_labels(names), units, cells)
    if reading.delimiter == "," and (number := parted_decimals(names, cells)):
        raise InputError(
            f"has a name less than its rows have fields: is {number} one number, with a decimal comma among the commas "
            "between columns? expected another mark between columns, or decimal points",
            place=f"{word} {numbers[good[0]]}",
        )
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
    )


def _shifted(names: list[str], units: list[str], cells: Sequence[list[str]]) -> tuple[list[str], list[str]]:
    """Names of a header that has one less than its rows, which is not the last one's.

    It is that of the first column where that counts rows, as R writes them; or of the second where times have commas
    before their milliseconds.
    """
    if len(names) < _LEAST_SHIFTED or names[-1].strip() or not names[0].strip() or not any(map(str.strip, cells[-1])):
        return names, units
    first, second = cells[0][:_SAMPLE], cells[1][:_SAMPLE]
    if first in ([str(i + k) for i in range(len(first))] for k in (0, 1)) and len(first) > 1:
        return ["row", *names[:-1]], ["", *units[:-1]]
    if all(cell.isdigit() and len(cell) <= _MILLIS for cell in second) and all(map(_WHOLE_SECONDS.search, first)):
        return [names[0], "ms", *names[1:-1]], [units[0], "", *units[1:-1]]
    return names, units


def _first_row(rows: Sequence[Sequence[str]], numbers: Sequence[int], width: int, word: str) -> int:
    """Where numbers begin."""
    for is_one in (_is_data, _is_reading):
        found = next((i for i, row in enumerate(rows) if is_one(row, width)), None)
        if found is not None:
            while found > 0 and _is_reading(rows[found - 1], width):  # with more words than the first of numbers
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
        return next((i for i in range(at + 1, len(rows)) if _is_data(rows[i], width)), first), names, units
    first = _behind_labels(rows, first, width)
    names, units = _head(rows[:first], width, comments)
    if not names:
        first = _behind_a_preamble(rows, first, width)
        names, units = _head(rows[:first], width, comments)
    if names and not any(units):
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


def _is_number(cell: str) -> bool:
    text = cell.strip()
    return (
        plain_number(text) is not None
        or plain_number(text, ",") is not None
        or is_time(text)
        or (text[:1].isdigit() and unit_of(re.sub(r"^[\d.,]+\s*", "", text)) is not None)
    )


def _is_data(row: Sequence[str], width: int) -> bool:
    if len(row) != width or _numbers_channels(row):
        return False
    filled = [cell for cell in row if cell.strip() and cell.strip().casefold() not in NAN_WORDS]
    return bool(filled) and 2 * sum(map(_is_number, filled)) >= len(filled)


def _numbers_channels(row: Sequence[str]) -> bool:
    """Whether a header calls its channels by whole numbers behind a time: `time,101,102`."""
    first, *others = (cell.strip() for cell in row)
    return bool(TIME.fullmatch(first.casefold())) and all(cell.isdigit() for cell in others)


def _is_reading(row: Sequence[str], width: int) -> bool:
    """A row with a time and a number among words: which device's sensor, in what unit."""
    return len(row) == width and sum(map(_is_number, row)) > 1 and any(is_time(cell.strip()) for cell in row)


def _is_head(row: Sequence[str]) -> bool:
    if _numbers_channels(row):
        return True
    filled = [cell for cell in row if cell.strip()]
    if all(_RULE.fullmatch(cell.strip()) for cell in filled):
        return False
    return 2 * len(filled) > len(row) and not any(plain_number(cell.strip()) is not None for cell in filled)


def _head(before: Sequence[list[str]], width: int, comments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names and units; no names where there is no header.

    A header may lack the last name, or have one more: a column of comments that no row has (LabVIEW's files).
    """
    labelled = labelled_head(before, width)
    heads = [_padded(row, width) for row in before[-4:] if abs(len(row) - width) <= 1 and _is_head(row)]
    if labelled is not None and (not heads or is_label(heads[-1][0])):
        return labelled
    if len(heads) > 1 and sum(1 for cell in heads[-1] if STATISTIC.fullmatch(cell.strip())) > 1:
        return _under_names(heads)
    if len(heads) > 1 and is_units(heads[-1], heads[-2]) and not is_units(heads[-2]):
        return heads[-2], heads[-1]
    if heads:
        return heads[-1], [""] * width
    for text in reversed(comments):  # as numpy.savetxt writes it
        for delimiter in DELIMITERS:
            row = text.split() if delimiter == " " else text.split(delimiter)
            if width > 1 and len(row) == width and _is_head(row) and ":" not in row[0]:
                return [cell.strip() for cell in row], [""] * width
    return [], [""] * width


def _under_names(heads: Sequence[list[str]]) -> tuple[list[str], list[str]]:
    """Names and units where the last line only says which value of an interval a column holds: `Min`, `Max`."""
    *above, last = heads
    names = next((row for row in reversed(above) if not is_units(row)), [""] * len(last))
    units = next((row for row in reversed(above) if is_units(row)), [""] * len(last))
    made = [
        with_statistic(name.strip(), cell) if STATISTIC.fullmatch(cell.strip()) else cell or name
        for name, cell in zip(names, last, strict=True)
    ]
    return made, [unit if unit_of(unit) else "" for unit in units]


def _behind_a_preamble(rows: Sequence[list[str]], first: int, width: int) -> int:
    """The first row of the table where lines of a preamble (`Samples 120`) look like rows: behind a later header."""
    for i in range(first, min(first + _LONGEST_PREAMBLE, len(rows))):
        if not _is_data(rows[i], width):
            continue
        if _is_number(rows[i][0]):
            return i if i > first and abs(len(rows[i - 1]) - width) <= 1 and _is_head(rows[i - 1]) else first
    return first


def _behind_labels(rows: Sequence[list[str]], first: int, width: int) -> int:
    """The first row behind lines that say what they hold (`Wf_increment,1,1`) where rows say nothing there."""
    if not any(row and is_label(row[0]) for row in rows[:first]):
        return first
    behind = [row[0].strip() for row in rows[first : first + _HEAD_LINES] if len(row) == width]
    labels = next((i for i, cell in enumerate(behind) if not cell), 0)
    told = all(re.search(r"[^\W\d_]", cell) and not _is_number(cell) for cell in behind[:labels])
    return first + labels if told and not any(behind[labels:]) else first


def _padded(row: list[str], width: int) -> list[str]:
    return [*row, *[""] * (width - len(row))][:width]


def _sorted_out(
    rows: Sequence[list[str]], numbers: Sequence[int], first: int, width: int, names: Sequence[str], word: str
) -> tuple[list[int], list[Counted]]:
    """Rows that are some, and what the others are."""
    good: list[int] = []
    others: dict[str, list[int]] = {}
    head = [name.strip() for name in names]
    for i in range(first, len(rows)):
        row = rows[i]
        if head and row and row[0].strip() == head[0] and [cell.strip() for cell in row] == head:
            others.setdefault("repeated header", []).append(i)
        elif len(row) == width and (row[0][:1].isdigit() or any(map(_may_be_number, row))):
            good.append(i)
        else:
            others.setdefault(f"line that is no row of {width} columns", []).append(i)
    return good, [Counted(what, len(found), f"{word} {numbers[found[0]]}") for what, found in others.items()]


def _may_be_number(cell: str) -> bool:
    return any(map(str.isdigit, cell))
