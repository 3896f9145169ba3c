"""Columns of a switch, a relay or a thermostat: ON and OFF, in words, are 1 and 0."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from gen.importing.numbers import NAN_WORDS
from gen.importing.table import Column, Counted, Table

_WORDS = (
    ("on", "off"),
    ("true", "false"),
    ("ein", "aus"),
    ("an", "aus"),
    ("marche", "arrêt"),
    ("acceso", "spento"),
    ("encendido", "apagado"),
    ("ligado", "desligado"),
    ("aan", "uit"),
)
NOTHING = NAN_WORDS | {"", "unavailable", "unknown"}


_SAMPLE = 50
"""Cells whose other texts rule all words out."""


def numbers_of(cells: Sequence[str]) -> list[str] | None:
    """Give ``1`` for on and ``0`` for off, nothing where nothing is said; None where anything else stands.

    Parameters
    ----------
    cells
        Texts.
    """
    first = {cell.strip().casefold() for cell in cells[:_SAMPLE]} - NOTHING
    if not any(first <= {on, off} for on, off in _WORDS):
        return None
    folded = [cell.strip().casefold() for cell in cells]
    said = set(folded) - NOTHING
    for on, off in _WORDS:
        if said and said <= {on, off}:
            return ["1" if cell == on else "0" if cell == off else "" for cell in folded]
    return None


def switched(table: Table, but: Collection[str] = ()) -> Table:
    """Give a table whose columns of on and off hold 1 and 0, which is counted.

    Parameters
    ----------
    table
        As it was read.
    but
        Columns to leave alone.
    """
    counted, columns = list(table.counted), []
    for column in table.columns:
        found = numbers_of(column.cells) if isinstance(column.cells, list) and column.name not in but else None
        if found is not None:
            said = sum(1 for cell in found if cell)
            counted.append(Counted(f"on or off of {column.name}, taken for 1 or 0", said, f"column {column.name}"))
        columns.append(column if found is None else Column(column.name, found, column.unit))
    return replace(table, columns=columns, counted=tuple(counted))
