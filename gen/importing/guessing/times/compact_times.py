"""Dates and times whose digits stand together: `20260302081500`, `20260302` and `081500`, a GPS's `081500.12`.

Also `0815`, and `260302081500`. As plain numbers they would be counts, of which 60 to 99 are missing in each hundred.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from gen.importing.guessing.names import TIME
from gen.importing.guessing.times.plain_steps import evenness
from gen.importing.table import Column, Counted, Table
from gen.importing.units import split_name, unit_of

_STAMP = re.compile(
    r"(20\d{2})(0[1-9]|1[0-2])(0[1-9]|[12]\d|3[01])([01]\d|2[0-3])([0-5]\d)([0-5]\d)?(?:[.,]?(\d{1,6}))?", re.ASCII
)
_SHORT_STAMP = re.compile(
    r"([1-4]\d)(0[1-9]|1[0-2])(0[1-9]|[12]\d|3[01])([01]\d|2[0-3])([0-5]\d)([0-5]\d)(?:[.,](\d{1,6}))?", re.ASCII
)
"""With two digits of the year."""
_DAY = re.compile(r"(20\d{2})(0[1-9]|1[0-2])(0[1-9]|[12]\d|3[01])", re.ASCII)
_CLOCK = re.compile(r"([01]?\d|2[0-3])([0-5]\d)([0-5]\d)(?:[.,](\d{1,6}))?", re.ASCII)
_LEAST_ROWS, _DIGITS, _FEW_DIGITS = 5, 6, 4


def with_parted_times(table: Table) -> Table:
    """Give such numbers the marks that part them; a table without them stays as it is.

    Parameters
    ----------
    table
        As it was read.
    """
    made, told = list(table.columns), list(table.counted)
    for i, column in enumerate(table.columns):
        cells = column.cells
        if not isinstance(cells, list) or len(cells) < _LEAST_ROWS or not _called_a_time(column):
            continue
        if not all(cell.strip()[:1].isdigit() for cell in cells[:_LEAST_ROWS]) or ":" in cells[0]:
            continue
        plain = [cell.strip() for cell in cells]
        stamps = _parted(plain, _STAMP)
        short_stamps = None if stamps else _parted(plain, _SHORT_STAMP)
        short = all(cell.isdigit() and len(cell) <= _FEW_DIGITS for cell in plain)
        plain = [cell.zfill(_DIGITS) if cell.isdigit() else cell for cell in plain]  # a spreadsheet drops zeros
        clocks = None if stamps else _parted(plain, _CLOCK)
        if stamps is not None:
            parted = [f"{y}-{m}-{d}T{h}:{n}:{s or '00'}.{f or '0'}" for y, m, d, h, n, s, f in stamps]
        elif short_stamps is not None:
            parted = [f"20{y}-{m}-{d}T{h}:{n}:{s}.{f or '0'}" for y, m, d, h, n, s, f in short_stamps]
        elif clocks is not None and short and _runs_as_clock(plain):
            parted = [f"{n}:{s}" for _, n, s, _ in clocks]  # hours and minutes, or minutes and seconds
        elif clocks is not None and _runs_as_clock(plain):
            parted = [f"{int(h):02d}:{n}:{s}.{f or '0'}" for h, n, s, f in clocks]
            days = _days_before(made[:i])
            if days is not None:
                made[days[0]] = replace(made[days[0]], cells=days[1])
        else:
            continue
        made[i] = replace(column, cells=parted)
        told.append(Counted(f"time of {column.name} written without marks", len(parted), f"column {column.name}"))
    return replace(table, columns=made, counted=tuple(told)) if len(told) > len(table.counted) else table


def _called_a_time(column: Column) -> bool:
    base, unit, _ = split_name(column.name)
    return (
        unit is None and not unit_of(column.unit) and bool(TIME.fullmatch(base.casefold()) or "utc" in base.casefold())
    )


def _parted(cells: list[str], form: re.Pattern[str]) -> list[tuple[str, ...]] | None:
    """What all cells say in a form; None where one says nothing in it."""
    if not all(map(form.fullmatch, cells[:_LEAST_ROWS])):  # which most columns end at
        return None
    found = [form.fullmatch(cell) for cell in cells]
    return [match.groups() for match in found if match] if all(found) else None


def _runs_as_clock(cells: list[str]) -> bool:
    """Whether numbers go on evenly as hours, minutes and seconds, which they do not as counts."""
    counts = np.array([float(cell.replace(",", ".")) for cell in cells])
    hours, rest = np.divmod(counts, 10_000)
    minutes, seconds = np.divmod(rest, 100)
    time = hours * 3600 + minutes * 60 + seconds
    return bool(evenness(np.diff(time) % 86_400.0) > evenness(np.diff(counts)))


def _days_before(columns: list[Column]) -> tuple[int, list[str]] | None:
    """The column of days without marks before one of times, with its marks."""
    for i, column in enumerate(columns):
        days = _parted([cell.strip() for cell in column.cells], _DAY) if isinstance(column.cells, list) else None
        if days:
            return i, ["-".join(day) for day in days]
    return None
