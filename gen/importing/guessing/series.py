"""A table with a row for each reading of any sensor, to one with a column for each sensor."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from gen.errors import InputError
from gen.importing.guessing.evidence import Evidence
from gen.importing.guessing.guesses import Choices
from gen.importing.guessing.series_columns import MOST_SERIES, is_plain_value, unit_column, value_column
from gen.importing.guessing.times.guess_time import decide_time
from gen.importing.listing import listed
from gen.importing.numbers import plain_number
from gen.importing.table import Column, Counted, Table
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
        `series` is the column of names, or with a comma that of names and that of values.

    Raises
    ------
    InputError
        With the file: there is no such column, no time, or nobody knows which column holds the values.
    """
    try:
        names, values = _columns(table, choices.series)
        rest = [column for column in table.columns if column.name not in (names, values)]
        form, _ = decide_time(Evidence([replace(table, columns=rest)]), choices)
        if not form.columns:
            raise InputError("rows of one time cannot be told without a column of times", place="--time")
        return _spread(table, names, values, form.columns)
    except InputError as error:
        raise InputError(error.message, file=table.label, place=error.place) from None


def _columns(table: Table, said: str) -> tuple[str, str]:
    """The column of names, and that of values."""
    parts = [said] if said in table.names else [part.strip() for part in said.split(",")]
    for name in parts:
        if name not in table.names:
            raise InputError(f'found "{name}", expected one of the columns {listed(table.names)}', place="--series")
    if len(parts) == 2:
        return parts[0], parts[1]
    others = [column for column in table.columns if column.name != parts[0]]
    values = value_column(Evidence([replace(table, columns=others)]))
    if len(parts) != 1 or not values:
        raise InputError(
            f"which column holds the values nobody knows; expected --series {parts[0]},COLUMN", place="--series"
        )
    return parts[0], values


def _of_all(table: Table, but: Collection[str], row_of: Sequence[int], count: int) -> list[Column]:
    """Columns of numbers that say the same beside all readings of a time: an input, of which each row has one."""
    if len(row_of) < _LEAST_TOGETHER * count:
        return []
    others = [column for column in table.columns if column.name not in but]
    facts = Evidence([replace(table, columns=others)]).facts if others else {}
    made = []
    for column in others:
        entry = facts[column.name]
        if entry.kind != "number" or len(set(entry.values.tolist())) < 2:
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
    others = [column for column in table.columns if column.name not in (names, values)]
    said = unit_column(Evidence([replace(table, columns=others)])) if others else ""
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


def _spread(table: Table, names: str, values: str, times: Sequence[str]) -> Table:
    said = texts_of(table.column(values))
    when = list(zip(*(texts_of(table.column(name)) for name in times), strict=True))
    of, beside = _told_apart(table, names, {values, *times}, when)
    kind = names if is_plain_value(values) else values
    of = [f"{kind} {name}" if name.replace(".", "").isdigit() else name for name in of]
    series = list(dict.fromkeys(name for name in of if name))
    if not 0 < len(series) <= MOST_SERIES:
        raise InputError(f"found {len(series)} names, expected {MOST_SERIES} at most", place=f"column {names}")
    rows = {time: row for row, time in enumerate(dict.fromkeys(when))}
    cells = {name: [""] * len(rows) for name in series}
    units, told = _units(table, of, names, values)
    first, twice = np.zeros(len(rows), dtype=np.int64), []
    for i in reversed(range(table.rows)):
        first[rows[when[i]]] = table.places[i]
    for i, (name, value, time) in enumerate(zip(of, said, when, strict=True)):
        if not name:
            continue
        if cells[name][rows[time]] and value:
            twice.append(i)
        elif value:
            cells[name][rows[time]] = told(i, value)
    counted = list(table.counted)
    if beside:
        counted.append(Counted(f"name of {names}, told apart by {listed(beside)}", len(series), f"column {names}"))
    if twice:
        counted.append(Counted("second reading of one name and time, left out", len(twice), table.place(twice[0])))
    columns = [Column(name, [time[k] for time in rows], table.column(name).unit) for k, name in enumerate(times)]
    columns += _of_all(table, {names, values, *times, *beside}, [rows[time] for time in when], len(rows))
    columns += [Column(name, cells[name], units.get(name, "")) for name in series]
    return replace(table, columns=columns, places=first, counted=tuple(counted))


def texts_of(column: Column) -> list[str]:
    """Give a column's cells as texts, empty where nothing is.

    Parameters
    ----------
    column
        Of texts, numbers or instants.
    """
    if isinstance(column.cells, list):
        return [cell.strip() for cell in column.cells]
    if column.cells.dtype.kind == "M":
        return ["" if np.isnat(cell) else str(cell.astype("datetime64[ns]")) for cell in column.cells]
    return ["" if not np.isfinite(value) else repr(float(value)) for value in column.cells.astype(np.float64)]
