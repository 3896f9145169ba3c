"""Columns that hold the unit of the column before them, row after row: `Ch1_Value`, `Ch1_Unit`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from gen.importing.table import Column
from gen.importing.units import unit_of

_NAMED = re.compile(r"(?:.*[^a-z])?(?:unit|units|einheit|unit[ée]|unit[àa]|unidad|eenheid)(?:[^a-z].*)?", re.IGNORECASE)


def with_units(columns: Sequence[Column]) -> list[Column]:
    """Columns with the units that the ones behind them hold.

    Parameters
    ----------
    columns
        Of one table; those of units stay.
    """
    made = list(columns)
    for i, column in enumerate(made[1:], start=1):
        if isinstance(column.cells, list) and not made[i - 1].unit and _NAMED.fullmatch(column.name):
            said = {cell.strip() for cell in column.cells} - {""}
            if len(said) == 1 and unit_of(next(iter(said))):
                made[i - 1] = replace(made[i - 1], unit=next(iter(said)))
    return made
