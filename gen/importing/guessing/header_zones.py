"""Times whose header says how far they are from UTC, as HOBO loggers write it: `Date Time, GMT+01:00`."""

from __future__ import annotations

import re
from dataclasses import replace

from gen.importing import clock
from gen.importing.table import Counted, Table

_ZONE = re.compile(r"(?:GMT|UTC)\s?(?P<sign>[+-])\s?(?P<hours>\d{1,2}):?(?P<minutes>[0-5]\d)?(?!\d)")


def with_zones(table: Table) -> Table:
    """Put the header's distance from UTC behind its times; where these say it themselves, they stay as they are.

    Parameters
    ----------
    table
        As it was read.
    """
    made, told = list(table.columns), list(table.counted)
    for i, column in enumerate(table.columns):
        said = _ZONE.search(column.name)
        cells = column.cells
        if said is None or not isinstance(cells, list) or clock.kind_of(cells) != "instant" or clock.zoned(cells):
            continue
        offset = f"{said['sign']}{int(said['hours']):02d}:{said['minutes'] or '00'}"
        made[i] = replace(column, cells=[f"{cell.strip()}{offset}" if cell.strip() else cell for cell in cells])
        told.append(Counted(f"time of {offset} by its header", len(cells), f"column {column.name}"))
    return replace(table, columns=made, counted=tuple(told)) if len(told) > len(table.counted) else table
