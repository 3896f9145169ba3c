"""Times whose header says how far they are from UTC, as HOBO loggers write it: `Date Time, GMT+01:00`."""

from __future__ import annotations

import re

from gen.importing import clock
from gen.importing.guessing.times.rewriting import each_rewritten
from gen.importing.table import Column, Table

_ZONE = re.compile(r"(?:GMT|UTC)\s?(?P<sign>[+-])\s?(?P<hours>\d{1,2}):?(?P<minutes>[0-5]\d)?(?!\d)")


def with_zones(table: Table) -> Table:
    """Put the header's distance from UTC behind its times; where these say it themselves, they stay as they are.

    Parameters
    ----------
    table
        As it was read.
    """
    return each_rewritten(table, _with_zone)


def _with_zone(column: Column) -> tuple[list[str], str] | None:
    said, cells = _ZONE.search(column.name), column.cells
    if said is None or not isinstance(cells, list) or clock.kind_of(cells) != "instant" or clock.zoned(cells):
        return None
    offset = f"{said['sign']}{int(said['hours']):02d}:{said['minutes'] or '00'}"
    return [f"{cell.strip()}{offset}" if cell.strip() else cell for cell in cells], f"time of {offset} by its header"
