"""Tables in which each channel has a column of times of its own: `Time | Winding | Time | Duty`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.importing import clock
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.guessing.names import TIME
from gen.importing.table import Column, Counted, FloatArray, Table, texts_of
from gen.importing.units import TIME as TIME_QUANTITY
from gen.importing.units import split_name, unit_of

_LEAST_PAIRS = 2
_FEW_ROWS = 3
_SAMPLE = 50
_APART = 0.5
"""Of the usual interval, by which two times of one row may drift apart and be those of one reading."""


def joined(table: Table) -> Table:
    """One column of times, with a row for each time of any channel; a table without such pairs stays as it is.

    Parameters
    ----------
    table
        As it was read.
    """
    if len(table.columns) < 2 * _LEAST_PAIRS or len(table.columns) % 2 or table.rows < _FEW_ROWS:
        return table
    if not all(map(_may_be_times, table.columns[::2])):  # which costs nothing
        return table
    facts = list(Evidence([table]).facts.values())
    times = [_times(entry) for entry in facts[::2]]
    found = [time for time in times if time is not None]
    if len(found) < len(times) or any(entry.kind != "number" or _says_time(entry) for entry in facts[1::2]):
        return table
    if all(_go_alike(found[0], time) for time in found[1:]):
        return table
    # a processor's time beside that of the log is called otherwise
    if (
        len({(entry.kind, entry.named[1], _stem(entry, of)) for entry, of in zip(facts[::2], facts[1::2], strict=True)})
        > 1
    ):
        return table
    return _joined(table, found)


def _stem(facts: Facts, of: Facts) -> str:
    """What a column of times is called, without numbers and without the channel that it is of."""
    base = facts.named[0].casefold().replace(of.named[0].casefold(), "")
    return "".join(c for c in base if c.isalpha())


def _go_alike(one: FloatArray, other: FloatArray) -> bool:
    """Whether two columns of times tell the same of each row, from wherever they count."""
    both = np.isfinite(one) & np.isfinite(other)
    if both.sum() < 2 or (np.isfinite(one) != np.isfinite(other)).any():
        return False
    steps = np.diff(one[both])
    apart = np.ptp(other[both] - one[both])
    return bool(apart < _APART * max(float(np.median(steps)), 1e-12))


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
    if facts.kind == "instant" and isinstance(cells, list):
        ns = clock.instants(cells, clock.date_order(cells)[0])
        return np.where(ns == np.iinfo(np.int64).min, np.nan, ns.astype(np.float64))
    if facts.kind != "number" or not _says_time(facts) or not facts.steps.size or (facts.steps < 0).any():
        return None
    return facts.parsed[0].values


def _joined(table: Table, times: list[FloatArray]) -> Table:
    said = [texts_of(column) for column in table.columns]
    when: dict[str, float] = {}
    place: dict[str, int] = {}
    cells: list[dict[str, str]] = [{} for _ in times]
    for k, time in enumerate(times):
        for row in np.flatnonzero(np.isfinite(time)).tolist():
            text = said[2 * k][row]
            when[text] = float(time[row])
            place[text] = min(place.get(text, row), row)
            cells[k][text] = said[2 * k + 1][row]
    order = sorted(when, key=lambda text: when[text])
    columns = [replace(table.columns[0], cells=order)]
    columns += [
        Column(column.name, [values.get(text, "") for text in order], column.unit)
        for column, values in zip(table.columns[1::2], cells, strict=True)
    ]
    names = ", ".join(column.name for column in table.columns[2::2])
    counted = Counted(f"column with times of its own beside {table.columns[0].name}", len(times) - 1, f"column {names}")
    rows = np.array([place[text] for text in order], dtype=np.int64)
    return replace(table, columns=columns, places=table.places[rows], counted=(*table.counted, counted))
