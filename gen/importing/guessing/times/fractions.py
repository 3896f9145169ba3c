"""Fractions of a second in a column of their own beside times of whole seconds.

`Date&Time | ms`, `Time | Millitm`, `tv_sec | tv_usec`, ROS's `header.stamp.secs | header.stamp.nsecs`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.importing import clock
from gen.importing.guessing.names import TIME
from gen.importing.numbers import parse
from gen.importing.table import Column, Counted, Table, texts_of
from gen.importing.units import split_name

_NANOS, _MICROS, _MILLIS, _HUNDREDTHS, _SECOND = 1e-3, 1.0, 1e3, 1e4, 1e6
"""Of each, in us."""
_PARTS = (
    (re.compile(r"n\.?s(?:ecs?)?|nanos?|nano ?sec(?:ond)?s?"), _NANOS),
    (re.compile(r"[uµμ]\.?s(?:ecs?)?|micros?|micro ?sec(?:ond)?s?"), _MICROS),
    (re.compile(r"m\.?s(?:ecs?)?|millis|milli ?sec(?:ond)?s?|millitm|millisekunden|millisecondes"), _MILLIS),
    (re.compile(r"1/100 ?s?|cs|centis|centi ?sec(?:ond)?s?|hundredths?"), _HUNDREDTHS),
    (re.compile(r"s|secs?|seconds?|frac|fractions?|sub ?sec(?:ond)?s?"), _SECOND),
)
_BESIDE = re.compile(r"frac|fractions?|fractional|part|of|seconds?|sub ?sec(?:ond)?s?|remainder|rest")
_SECONDS = re.compile(r"s|secs?|seconds?|sekunden|epoch|unix|unixtime")
_TOKENS = re.compile(r"1/100 ?s?|[mnuµμ]\.s(?:ecs?)?|[^\W\d_]+")
_SINCE_1970 = (1e9, 2.5e9)
_MOST_ASTRAY, _EVENER = 0.1, 0.5
_WHOLE = re.compile(r"\d{1,2}:\d{2}:\d{2}(?![.,:]?\d)")


def with_fractions(table: Table) -> Table:
    """Give times of whole seconds the fractions that another column holds; other tables stay as they are.

    Parameters
    ----------
    table
        As it was read.
    """
    columns = table.columns
    for i, before in enumerate(columns):
        for j in _nearest(i, len(columns)) if _may_be_whole(before) else ():
            cells = _in_one(before, columns[j], table.reading.decimal or ".", beside=abs(i - j) == 1)
            if cells is not None:
                told = Counted(f"fraction of a second from {columns[j].name}", len(cells), f"column {columns[j].name}")
                made = [
                    replace(before, cells=cells) if k == i else column for k, column in enumerate(columns) if k != j
                ]
                return replace(table, columns=made, counted=(*table.counted, told))
    return table


def _nearest(at: int, count: int) -> Iterator[int]:
    """All other columns: the next one, the one before, then the others."""
    yield from sorted((j for j in range(count) if j != at), key=lambda j: (abs(j - at) != 1, j < at, j))


def _may_be_whole(column: Column) -> bool:
    """Whether a column may hold times of whole seconds, by what costs little."""
    if not isinstance(column.cells, list):
        return column.cells.dtype.kind == "f"
    first = next((cell for cell in column.cells if cell.strip()), "")
    return bool(first.strip().isdigit() or _WHOLE.search(first))


def _in_one(before: Column, column: Column, mark: str, *, beside: bool) -> list[str] | None:
    """A time's cells with the fractions that another column holds; None where it holds none."""
    scale = _scale(column, before)
    found = _fractions(column, scale, mark) if scale else None
    if found is None:
        return None
    digits = 3 if not (found % 1000).any() else 6
    shown = [f"{part:06d}"[:digits] for part in found.tolist()]
    if isinstance(before.cells, list) and clock.kind_of(before.cells) in ("instant", "clock"):
        if not all(_WHOLE.search(cell) for cell in before.cells if cell.strip()) or not beside:
            return None
        if not _rise_within(before.cells, found):
            return None
        return [_WHOLE.sub(rf"\g<0>.{part}", cell, count=1) for cell, part in zip(before.cells, shown, strict=True)]
    whole = _whole_seconds(before, mark)
    if whole is None or not _rise_within(whole.tolist(), found):
        return None
    of_seconds = _is_of_seconds(before, whole) or (_called_so(before) and _repeats(whole))
    if not (of_seconds and beside) and not ((of_seconds or _called_so(before)) and _evener(whole, found)):
        return None
    return [f"{second}{mark}{part}" for second, part in zip(whole.tolist(), shown, strict=True)]


def _rise_within(cells: Sequence[str] | Sequence[int], parts: IntArray) -> bool:
    """Whether fractions rise from row to row of one second, as those of a loop's own time do not.

    Rows of one time, one for each sensor, have one fraction.
    """
    times = list(zip(cells, parts.tolist(), strict=True))
    if parts.size and parts.min() < parts.max():
        times = [time for time, _ in groupby(times)]
    steps = [b - a for (one, a), (other, b) in pairwise(times) if one == other]
    return sum(1 for step in steps if step <= 0) <= _MOST_ASTRAY * len(steps)


def _evener(whole: IntArray, parts: IntArray) -> bool:
    """Whether rows follow each other more evenly with the fractions than without."""
    without = np.diff(whole.astype(np.float64))
    return bool(np.std(without + np.diff(parts) * 1e-6) < _EVENER * np.std(without))


def _called_so(column: Column) -> bool:
    """Whether a column is a time by its name."""
    return bool(TIME.fullmatch(split_name(column.name)[0].casefold()))


def _repeats(whole: IntArray) -> bool:
    """Whether rows share seconds, as of a clock of whole seconds."""
    return bool((np.diff(whole) == 0).mean() > _MOST_ASTRAY)


def _whole_seconds(column: Column, mark: str) -> IntArray | None:
    """Whole numbers that do not fall; None for others."""
    if isinstance(column.cells, list):
        values = parse(column.cells, mark).values
    elif column.cells.dtype.kind == "f":
        values = np.asarray(column.cells, dtype=np.float64)
    else:
        return None
    if not values.size or not np.all(np.isfinite(values)) or np.any(values % 1.0):
        return None
    whole = values.astype(np.int64)
    steps = np.diff(whole)
    rises = steps.size and (steps < 0).mean() <= _MOST_ASTRAY and whole[-1] > whole[0] >= 0
    return whole if rises else None


def _is_of_seconds(column: Column, whole: IntArray) -> bool:
    """Whether numbers are seconds, by their name or as those since 1970."""
    tokens = _tokens(column)
    return bool(tokens and _SECONDS.fullmatch(tokens[-1])) or _SINCE_1970[0] < whole[0] < _SINCE_1970[1]


def _tokens(column: Column) -> list[str]:
    """The words of a column's name, its unit last: of `ms` above `ms` once."""
    found = _TOKENS.findall(f"{column.name} {column.unit}".casefold())
    return [word for k, word in enumerate(found) if k == 0 or word != found[k - 1]]


def _scale(column: Column, before: Column) -> float:
    """What 1 of a column's numbers is in us, by its name or unit; 0 for what is no fraction of that time's second."""
    tokens, others = _tokens(column), _tokens(before)
    if not tokens:
        return 0.0
    *words, last = tokens
    same = words in (others, others[:-1])
    if not same and not all(_BESIDE.fullmatch(word) for word in words):
        return 0.0
    return next((scale for pattern, scale in _PARTS if pattern.fullmatch(last)), 0.0)


def _fractions(column: Column, scale: float, mark: str) -> IntArray | None:
    """In whole us; None where a number is none, or a second or more."""
    values: FloatArray = (
        parse(column.cells, mark).values if isinstance(column.cells, list) else np.asarray(column.cells)
    )
    if values.dtype.kind != "f" or not np.all(np.isfinite(values)):
        return None
    if scale == _SECOND and not np.any(values % 1.0) and np.any(values):
        digits = max(len(text.strip()) for text in texts_of(column))  # of whole numbers: `000` to `999`
        scale = _SECOND / 10.0**digits if digits > 1 else scale
    parts = np.floor(values * scale + 0.5 * (scale >= 1.0))
    return parts.astype(np.int64) if bool(np.all((parts >= 0) & (parts < 1e6))) else None
