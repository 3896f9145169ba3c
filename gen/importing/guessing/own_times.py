"""Tables in which each channel has a column of times of its own: `Time | Winding | Time | Duty`."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from gen.arrays import FloatArray
from gen.importing import clock
from gen.importing.dates import DAY_NS
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.names import TIME
from gen.importing.table import Column, Counted, Table, texts_of
from gen.importing.units import TIME as TIME_QUANTITY
from gen.importing.units import split_name, unit_of

_LEAST_TIMES = 2
_FEW_ROWS = 3
_SAMPLE = 50
_MOST = 0.95
"""Of the rows of one of several tables, that have a time."""
_APART = 0.5
"""Of the usual interval, by which two times of one row may drift apart and be those of one reading."""
_OF_ONE_BEGINNING = {"x", "xvalue"}
"""What columns of times are called that count from one time, such as LabVIEW's."""
_SKEW = 0.05
"""Of the usual interval, by which channels that are read one after the other are still read at once."""


_Key = tuple[float, int]
"""A time, and how many rows of the same columns had it before."""


@dataclass(frozen=True)
class _Group:
    """Columns that have one column of times: where that stands, its times, and where the others do."""

    at: int
    times: FloatArray
    others: list[int]


def joined(table: Table) -> Table:
    """One column of times, with a row for each time of any group of columns; a table with one time stays as it is.

    Parameters
    ----------
    table
        As it was read.
    """
    starts = [i for i, column in enumerate(table.columns) if _may_be_times(column)]  # which costs little
    if len(starts) < _LEAST_TIMES or table.rows < _FEW_ROWS:
        return table
    groups = _in_pairs(table, starts) or _side_by_side(table, starts)
    if groups:
        return _joined(table, groups)
    dated = _dates_with_times(table)
    apart = joined(dated) if dated is not table else dated
    return apart if apart is not dated else table


def _dates_with_times(table: Table) -> Table:
    """Dates and times of day in one column each, where several columns of dates have times behind them."""
    kinds = [clock.kind_of(c.cells[:_SAMPLE]) if isinstance(c.cells, list) else "" for c in table.columns]
    dates = [i for i, pair in enumerate(pairwise(kinds)) if pair == ("date", "clock")]
    if len(dates) < _LEAST_TIMES:
        return table
    columns = list(table.columns)
    for i in dates:
        both = zip(texts_of(columns[i]), texts_of(columns[i + 1]), strict=True)
        columns[i] = replace(columns[i], cells=[f"{date} {time}".strip() for date, time in both])
    return replace(table, columns=[column for i, column in enumerate(columns) if i - 1 not in dates])


def _in_pairs(table: Table, starts: Sequence[int]) -> list[_Group]:
    """Times and one channel each, by turns."""
    if len(table.columns) % 2 or any(i not in starts for i in range(0, len(table.columns), 2)):
        return []
    facts = list(Evidence([table]).facts.values())
    if any(entry.kind != "number" or _says_time(entry) for entry in facts[1::2]):
        return []
    # a processor's time beside that of the log is called otherwise
    pairs = list(zip(facts[::2], facts[1::2], strict=True))
    if len({(entry.kind, entry.named[1], _called(entry, of)) for entry, of in pairs}) > 1:
        return []
    go_alike = _at_once if _stem(*pairs[0]) in _OF_ONE_BEGINNING else _go_alike
    times = [_times(entry) for entry in facts[::2]]
    found = [_Group(2 * k, time, [2 * k + 1]) for k, time in enumerate(times) if time is not None]
    alike = all(go_alike(found[0].times, group.times) for group in found[1:])
    return found if len(found) == len(times) and not alike else []


def _side_by_side(table: Table, starts: Sequence[int]) -> list[_Group]:
    """Tables beside each other, each with its times before its columns, which end where it does."""
    facts = list(Evidence([table]).facts.values())
    called = {i: _called(facts[i], facts[i + 1]) for i in starts if i + 1 < len(facts)}
    first = starts[0]
    starts = [i for i in starts if i in called and called[i] == called[first]]
    starts = [i for i in starts if (facts[i].kind, facts[i].named[1]) == (facts[first].kind, facts[first].named[1])]
    begins = [i - first for i in starts]  # numbers of rows may stand before the time
    found = []
    for at, begin, end in zip(starts, begins, [*begins[1:], len(facts)], strict=True):
        others = [i for i in range(begin, end) if i != at]
        time = _times(facts[at])
        holds = any(facts[i].kind == "number" and not _says_time(facts[i]) for i in others if i > at)
        if time is None or at >= end or not holds or not _ends_once(time):
            return []
        found.append(_Group(at, time, others))
    if len(found) < _LEAST_TIMES or all(_one_clock(found[0].times, group.times) for group in found[1:]):
        return []
    if _same_columns(found, table.names):
        return []
    return _of_one_day(found) if facts[first].kind == "clock" else found


def _same_columns(groups: Sequence[_Group], names: Sequence[str]) -> bool:
    """Whether tables name the same columns: they are several tests, and none was measured beside another."""
    called = [{re.sub(r"_\d+(?=$|\W)", "", names[i]) for i in group.others} for group in groups]
    return any(group <= called[0] for group in called[1:])


def _one_clock(one: FloatArray, other: FloatArray) -> bool:
    """Whether two columns of times are those of the same rows, of which a few lack the one or the other."""
    known = np.isfinite(one) & np.isfinite(other)
    ends = {int(np.flatnonzero(np.isfinite(time))[-1]) for time in (one, other)}
    return len(ends) == 1 and _go_alike(np.where(known, one, np.nan), np.where(known, other, np.nan))


def _ends_once(time: FloatArray) -> bool:
    """Whether times are there row after row until they end: a clock that some rows lack is one of those rows."""
    known = np.flatnonzero(np.isfinite(time))
    return known.size >= _FEW_ROWS and known.size >= _MOST * (known[-1] - known[0] + 1)


def _stem(facts: Facts, of: Facts) -> str:
    """What a column of times is called, without numbers and without the channel that it is of."""
    base, channel = facts.named[0].casefold(), of.named[0].casefold()
    if base.endswith("x") and channel.endswith("y"):  # `Winding X | Winding Y`
        channel = channel[:-1].rstrip(" _.-")
    base = base.replace(channel, "") if channel else base
    return "".join(c for c in base if c.isalpha())


def _called(facts: Facts, of: Facts) -> tuple[str, bool]:
    """What a column of times is called; beside `t` stands a temperature `T`."""
    return _stem(facts, of), facts.named[0][:1].isupper()


def _of_one_day(groups: list[_Group]) -> list[_Group]:
    """Times of day of tables of which one begins behind midnight."""
    begins = [float(group.times[np.isfinite(group.times)][0]) for group in groups]
    behind = [max(begins) - begin > DAY_NS / 2 for begin in begins]
    return [
        replace(group, times=group.times + DAY_NS) if late else group
        for group, late in zip(groups, behind, strict=True)
    ]


def _go_alike(one: FloatArray, other: FloatArray) -> bool:
    """Whether two columns of times tell the same of each row, from wherever they count."""
    both = np.isfinite(one) & np.isfinite(other)
    if both.sum() < 2 or (np.isfinite(one) != np.isfinite(other)).any():
        return False
    steps = np.diff(one[both])
    apart = np.ptp(other[both] - one[both])
    return bool(apart < _APART * max(float(np.median(steps)), 1e-12))


def _at_once(one: FloatArray, other: FloatArray) -> bool:
    """Whether two columns of times that count from one beginning tell the same of each row."""
    apart = np.abs(other - one)[np.isfinite(one) & np.isfinite(other)]
    step = float(np.median(np.diff(one[np.isfinite(one)])))
    return _go_alike(one, other) and bool(apart.max() < _SKEW * step)


def _may_be_times(column: Column) -> bool:
    base, unit, _ = split_name(column.name)
    unit = unit or unit_of(column.unit)
    if unit is not None:
        return unit.quantity == TIME_QUANTITY
    if TIME.fullmatch(base.casefold()):
        return True
    return isinstance(column.cells, list) and clock.kind_of(column.cells[:_SAMPLE]) == "instant"


def _says_time(facts: Facts) -> bool:
    base, unit, _ = facts.named
    return (unit is not None and unit.quantity == TIME_QUANTITY) or bool(TIME.fullmatch(base.casefold()))


def _times(facts: Facts) -> FloatArray | None:
    """Numbers in the order of a column's times, NaN where it has none; None of a column that is none."""
    cells = facts.columns[0].cells
    if facts.kind == "instant":
        texts = isinstance(cells, list)
        ns = clock.instants(cells, clock.date_order(cells)[0]) if texts else clock.of_instants(cells)  # type: ignore[arg-type]
        return np.where(ns == clock.MISSING, np.nan, ns.astype(np.float64))
    if facts.kind == "clock" and isinstance(cells, list):
        ns, _ = clock.over_midnight(clock.of_day(cells))
        return np.where(ns == clock.MISSING, np.nan, ns.astype(np.float64))
    if facts.kind != "number" or not _says_time(facts) or not facts.steps.size or (facts.steps < 0).any():
        return None
    return facts.parsed[0].values


def _joined(table: Table, groups: Sequence[_Group]) -> Table:
    said = [texts_of(column) for column in table.columns]
    place: dict[_Key, int] = {}
    text: dict[_Key, str] = {}
    cells: dict[int, dict[_Key, str]] = {i: {} for group in groups for i in group.others}
    lost: set[int] = set()
    for group in groups:
        lost |= {row for i in group.others for row in np.flatnonzero(np.isnan(group.times)).tolist() if said[i][row]}
        repeated: Counter[float] = Counter()
        for row in np.flatnonzero(np.isfinite(group.times)).tolist():
            time = float(group.times[row])
            key = (time, repeated[time])
            repeated[time] += 1
            place[key] = min(place.get(key, row), row)
            text.setdefault(key, said[group.at][row])
            for i in group.others:
                cells[i][key] = said[i][row]
    order = sorted(place)
    first = table.columns[groups[0].at]
    columns = [replace(first, cells=[text[key] for key in order])]
    columns += [
        Column(table.columns[i].name, [values.get(key, "") for key in order], table.columns[i].unit)
        for i, values in cells.items()
    ]
    names = ", ".join(table.columns[group.others[0]].name for group in groups[1:])
    what = f"column with times of its own beside {first.name}"
    counted = [*table.counted, Counted(what, len(groups) - 1, f"column {names}")]
    if lost:
        counted.append(Counted("row without a time", len(lost), table.place(min(lost), first.name)))
    rows = np.array([place[key] for key in order], dtype=np.int64)
    return replace(table, columns=columns, places=table.places[rows], counted=tuple(counted))
