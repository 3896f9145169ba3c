"""Columns that hold the unit of the column before them, row after row: `Ch1_Value`, `Ch1_Unit`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from gen.importing.guessing.names import TIME
from gen.importing.table import Column
from gen.importing.units import TIME as TIME_QUANTITY
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
        before = made[i - 1]
        if not isinstance(column.cells, list) or before.unit or not _NAMED.fullmatch(column.name):
            continue
        said = {cell.strip() for cell in column.cells} - {""}
        quantities = {unit.quantity if unit is not None else "" for unit in map(unit_of, said)}
        if len(quantities) != 1 or "" in quantities:
            continue  # of several quantities: a row for each sensor
        if TIME.fullmatch(before.name.casefold()) and quantities != {TIME_QUANTITY}:
            continue  # it is meant for what follows
        if len(said) == 1:
            made[i - 1] = replace(before, unit=next(iter(said)))
        elif isinstance(before.cells, list):  # a meter that chooses its range
            cells = [
                f"{cell.strip()} {unit.strip()}".strip() for cell, unit in zip(before.cells, column.cells, strict=True)
            ]
            made[i - 1] = replace(before, cells=cells)
    return made
