"""AM and PM in a column of their own behind times of hours to 12."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

from gen.importing import clock
from gen.importing.table import Counted, Table

_HALF = re.compile(r"[AaPp]\.?\s?[Mm]\.?")


def with_halves(table: Table) -> Table:
    """Put AM and PM behind the times before them; a table without such a column stays as it is.

    Parameters
    ----------
    table
        As it was read.
    """
    columns = list(table.columns)
    for i, (before, column) in enumerate(pairwise(columns), start=1):
        halves, times = column.cells, before.cells
        if not isinstance(halves, list) or not isinstance(times, list) or not halves:
            continue
        if not all(_HALF.fullmatch(half.strip()) or not half.strip() for half in halves) or not any(halves):
            continue
        if clock.kind_of(times) not in ("instant", "clock", "minutes"):
            continue
        cells = [f"{time.strip()} {half.strip()}".strip() for time, half in zip(times, halves, strict=True)]
        told = Counted(f"AM or PM from {column.name}", len(cells), f"column {column.name}")
        columns[i - 1] = replace(before, cells=cells)
        return replace(table, columns=[*columns[:i], *columns[i + 1 :]], counted=(*table.counted, told))
    return table
