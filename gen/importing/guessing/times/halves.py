"""AM and PM in a column of their own behind times of hours to 12."""

from __future__ import annotations

import re

from gen.importing import clock
from gen.importing.guessing.times.rewriting import first_joined
from gen.importing.table import Column, Table

_HALF = re.compile(r"[AaPp]\.?\s?[Mm]\.?")


def with_halves(table: Table) -> Table:
    """Put AM and PM behind the times before them; a table without such a column stays as it is.

    Parameters
    ----------
    table
        As it was read.
    """
    return first_joined(table, _in_one)


def _in_one(before: Column, column: Column) -> tuple[list[str], str] | None:
    halves, times = column.cells, before.cells
    if not isinstance(halves, list) or not isinstance(times, list) or not halves:
        return None
    if not all(_HALF.fullmatch(half.strip()) or not half.strip() for half in halves) or not any(halves):
        return None
    if clock.kind_of(times) not in ("instant", "clock", "minutes"):
        return None
    cells = [f"{time.strip()} {half.strip()}".strip() for time, half in zip(times, halves, strict=True)]
    return cells, f"AM or PM from {column.name}"
