"""Columns of a switch, a relay or a thermostat: ON and OFF, in words, are 1 and 0."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from gen.importing.guessing.names import SIGN
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
_WAYS = (
    ("cw", "ccw"),
    ("clockwise", "counterclockwise"),
    ("clockwise", "counter-clockwise"),
    ("clockwise", "anticlockwise"),
    ("forward", "reverse"),
    ("forward", "backward"),
    ("forwards", "backwards"),
    ("fwd", "rev"),
    ("fwd", "bwd"),
    ("rechts", "links"),
    ("vor", "zurück"),
    ("vorwärts", "rückwärts"),
)
"""Which way a motor turns: the first one is that of a positive input."""
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
    return _either(cells, _WORDS, "0")


def _either(cells: Sequence[str], words: Sequence[tuple[str, str]], other: str) -> list[str] | None:
    """``1`` for the first of a pair of words, and what the second stands for; None where anything else stands."""
    first = {cell.strip().casefold() for cell in cells[:_SAMPLE]} - NOTHING
    if not any(first <= set(pair) for pair in words):
        return None
    folded = [cell.strip().casefold() for cell in cells]
    said = set(folded) - NOTHING
    for one, second in words:
        if said and said <= {one, second}:
            return ["1" if cell == one else other if cell == second else "" for cell in folded]
    return None


def switched(table: Table, but: Collection[str] = ()) -> Table:
    """Give a table whose columns of on and off hold 1 and 0, and those of directions 1 and -1, which is counted.

    Parameters
    ----------
    table
        As it was read.
    but
        Columns to leave alone.
    """
    counted, columns = list(table.counted), []
    for column in table.columns:
        words = column.cells if isinstance(column.cells, list) and column.name not in but else []
        found = numbers_of(words) if words else None
        what = f"on or off of {column.name}, taken for 1 or 0"
        if words and found is None and SIGN.search(column.name):
            found = _either(words, _WAYS, "-1")
            what = f"direction of {column.name}, taken for 1 or -1"
        if found is not None:
            counted.append(Counted(what, sum(1 for cell in found if cell), f"column {column.name}"))
        columns.append(column if found is None else Column(column.name, found, column.unit))
    return replace(table, columns=columns, counted=tuple(counted))
