"""A table with a row for each reading of any sensor, to one with a column for each sensor."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from gen.errors import InputError
from gen.importing.guessing.evidence import Evidence
from gen.importing.guessing.guesses import Choices
from gen.importing.guessing.series_columns import MOST_SERIES, is_plain_value, is_shared, unit_column, value_column
from gen.importing.guessing.series_fields import fields_of, telling
from gen.importing.guessing.times.guess_time import decide_time
from gen.importing.listing import listed
from gen.importing.numbers import plain_number
from gen.importing.table import Column, Counted, Table, texts_of, unique_names
from gen.importing.units import unit_of

_LEAST_TOGETHER = 1.5
"""Readings of each time, from which on what is the same beside all of them is of the time."""
_MOST_TWICE = 0.1
"""Of the readings that share name and time, those that other columns may leave so."""


def spread_out(table: Table, choices: Choices) -> Table:
    """Give each name of a column a column of its own, with one row for each time.

    Parameters
    ----------
    table
        As it was read.
    choices
        `series` is the column of names, or with commas that of names and those of values.

    Raises
    ------
    InputError
        With the file: there is no such column, no time, or nobody knows which column holds the values.
    """
    try:
        names, values = _columns(table, choices.series)
        table, times = _timed(table, names, values, choices)
        return _spread(table, names, values, times)
    except InputError as error:
        raise InputError(error.message, file=table.label, place=error.place) from None


def _timed(table: Table, names: str, values: Sequence[str], choices: Choices) -> tuple[Table, Sequence[str]]:
    """A table in which times go on, and the columns that tell them: each sensor's do, though not from row to row."""
    rest = [column.name for column in table.columns if column.name not in (names, *values)]
    try:
        form, _ = decide_time(Evidence([_of_columns(table, rest)]), choices)
    except InputError as error:
        by_names = np.argsort(np.array(texts_of(table.column(names))), kind="stable")
        try:
            form, _ = decide_time(Evidence([_of_columns(table.of_rows(by_names), rest)]), choices)
        except InputError:
            raise error from None
        table = _in_order(table, form.columns)
    if not form.columns:
        raise InputError("rows of one time cannot be told without a column of times", place="--time")
    return table, form.columns


def _in_order(table: Table, times: Sequence[str]) -> Table:
    """Rows in the order of a time that is counted; others are put into it later."""
    facts = Evidence([_of_columns(table, times)]).facts
    if len(times) != 1 or facts[times[0]].kind != "number":
        return table
    rows = np.argsort(facts[times[0]].parsed[0].values, kind="stable")
    moved = np.flatnonzero(np.diff(rows) < 0)
    if not moved.size:
        return table
    counted = Counted("place at which rows were put in the order of their times", moved.size, table.place(moved[0] + 1))
    return replace(table.of_rows(rows), counted=(*table.counted, counted))


def _of_columns(table: Table, names: Collection[str]) -> Table:
    return replace(table, columns=[column for column in table.columns if column.name in names])


def _columns(table: Table, said: str) -> tuple[str, list[str]]:
    """The column of names, and those of values."""
    parts = [said] if said in table.names else [part.strip() for part in said.split(",")]
    for name in parts:
        if name not in table.names:
            raise InputError(f'found "{name}", expected one of the columns {listed(table.names)}', place="--series")
    if len(parts) > 1:
        return parts[0], parts[1:]
    others = [column for column in table.columns if column.name != parts[0]]
    values = value_column(Evidence([replace(table, columns=others)]))
    if not values:
        raise InputError(
            f"which column holds the values nobody knows; expected --series {parts[0]},COLUMN", place="--series"
        )
    return parts[0], [values]


def _of_all(table: Table, but: Collection[str], row_of: Sequence[int], count: int) -> list[Column]:
    """Columns of numbers that say the same beside all readings of a time: an input, of which each row has one.

    Where readings have times of their own, what stands beside all and mostly stays as in the row before.
    """
    together = len(row_of) >= _LEAST_TOGETHER * count
    others = [column for column in table.columns if column.name not in but]
    facts = Evidence([replace(table, columns=others)]).facts if others else {}
    made = []
    for column in others:
        entry = facts[column.name]
        if entry.kind != "number" or len(set(entry.values.tolist())) < 2:
            continue
        if not together and (entry.values.size < table.rows or not is_shared(entry)):
            continue
        cells = [""] * count
        same = True
        for row, cell in zip(row_of, texts_of(column), strict=True):
            same = same and (not cell or cells[row] in ("", cell))
            cells[row] = cells[row] or cell
        made += [Column(column.name, cells, column.unit)] if same else []
    return made


def _told_apart(
    table: Table, names: str, used: Collection[str], when: Sequence[tuple[str, ...]]
) -> tuple[list[str], list[str]]:
    """The name of each row's series, with what other columns say where several readings of one name have one time.

    Returns
    -------
    of, beside
        And these columns. A coarse clock is none of that: other columns would not tell its readings apart.
    """
    plain = texts_of(table.column(names))
    first = _twice(plain, when)
    others = [column for column in table.columns if column.name not in {names, *used}]
    facts = Evidence([replace(table, columns=others)]).facts if others and first else {}
    units = unit_column(Evidence([replace(table, columns=others)])) if facts else ""
    told = [
        name
        for name, entry in facts.items()
        if entry.kind == "text" and name != units and 1 < len(set(entry.texts)) <= MOST_SERIES
    ]
    chosen: list[str] = []
    of, left = plain, first
    for name in told:
        with_it = _joined(table, names, [*chosen, name])
        fewer = _twice(with_it, when)
        if fewer < left:
            chosen, of, left = [*chosen, name], with_it, fewer
    return (of, chosen) if left <= _MOST_TWICE * first and chosen else (plain, [])


def _twice(of: Sequence[str], when: Sequence[tuple[str, ...]]) -> int:
    """Readings that share name and time with another."""
    return len(of) - len(set(zip(of, when, strict=True)))


def _joined(table: Table, names: str, beside: Sequence[str]) -> list[str]:
    """What names and other columns say, in the order in which they stand."""
    said = [texts_of(column) for column in table.columns if column.name in {names, *beside}]
    own = texts_of(table.column(names))
    return [" ".join(filter(None, parts)) if name else "" for name, *parts in zip(own, *said, strict=True)]


def _unit_column(table: Table, but: Collection[str]) -> str:
    """The column that says the unit of each reading; empty without one."""
    others = [column for column in table.columns if column.name not in but]
    return unit_column(Evidence([replace(table, columns=others)])) if others else ""


def _units(
    table: Table, of: Sequence[str], names: str, values: str
) -> tuple[dict[str, str], Callable[[int, str], str]]:
    """What a column says of units.

    Returns
    -------
    units, told
        The unit of each name that has the same one throughout. And what writes the unit of a row behind its value where
        its name has several: a sensor that was set to another scale.
    """
    said = _unit_column(table, (names, values))
    if not said:
        return {}, lambda row, value: value
    written = texts_of(table.column(said))
    found: dict[str, set[str]] = {}
    for name, unit in zip(of, written, strict=True):
        found.setdefault(name, set()).update({unit} - {""})
    mark = table.reading.decimal or "."

    def told(row: int, value: str) -> str:
        apart = len(found[of[row]]) > 1 and unit_of(written[row]) and plain_number(value, mark) is not None
        return f"{value} {written[row]}" if apart else value

    return {name: next(iter(units)) for name, units in found.items() if len(units) == 1}, told


def _spread(table: Table, names: str, values: Sequence[str], times: Sequence[str]) -> Table:
    when = list(zip(*(texts_of(table.column(name)) for name in times), strict=True))
    of, beside = _told_apart(table, names, {*values, *times}, when)
    kind = names if len(values) > 1 or is_plain_value(values[0]) else values[0]
    of = [f"{kind} {name}" if name.replace(".", "").isdigit() else name for name in of]
    series = list(dict.fromkeys(name for name in of if name))
    if not 0 < len(series) <= MOST_SERIES:
        raise InputError(f"found {len(series)} names, expected {MOST_SERIES} at most", place=f"column {names}")
    rows = {time: row for row, time in enumerate(dict.fromkeys(when))}
    row_of = [rows[time] for time in when]
    used = {names, *values, *times, *beside}
    columns = [Column(name, [time[k] for time in rows], table.column(name).unit) for k, name in enumerate(times)]
    columns += _of_all(table, used, row_of, len(rows))
    fields = telling(table, of, values, {*used, *(column.name for column in columns)})
    twice: list[int] = []
    if len(values) == 1:
        own, twice = _own(table, of, names, values[0], row_of, len(rows))
        columns += own
    elif _unit_column(table, (names, *values)):
        said = "a column of units says nobody knows of which of several values; expected --series NAMES,VALUES of one"
        raise InputError(said, place="--series")
    else:
        fields = [*values, *fields]
    told, again = fields_of(table, of, fields, row_of, len(rows))
    columns += told
    twice = sorted({*twice, *again})
    counted = list(table.counted)
    if beside:
        counted.append(Counted(f"name of {names}, told apart by {listed(beside)}", len(series), f"column {names}"))
    if twice:
        counted.append(Counted("second reading of one name and time, left out", len(twice), table.place(twice[0])))
    first = np.zeros(len(rows), dtype=np.int64)
    for i in reversed(range(table.rows)):
        first[row_of[i]] = table.places[i]
    called = unique_names([column.name for column in columns])
    columns = [replace(column, name=name) for column, name in zip(columns, called, strict=True)]
    return replace(table, columns=columns, places=first, counted=tuple(counted))


def _own(
    table: Table, of: Sequence[str], names: str, values: str, row_of: Sequence[int], count: int
) -> tuple[list[Column], list[int]]:
    """A column of each name with its values, and the rows whose reading is the second of one name and time."""
    cells = {name: [""] * count for name in of if name}
    units, told = _units(table, of, names, values)
    twice = []
    for i, (name, value, row) in enumerate(zip(of, texts_of(table.column(values)), row_of, strict=True)):
        if not name or not value:
            continue
        if cells[name][row]:
            twice.append(i)
        else:
            cells[name][row] = told(i, value)
    return [Column(name, own, units.get(name, "")) for name, own in cells.items()], twice
