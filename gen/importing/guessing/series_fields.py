"""Numbers beside the values of a table with a row for each reading: what only some of its sensors tell."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from gen.arrays import BoolArray
from gen.importing.guessing.evidence import Evidence
from gen.importing.table import Column, Table, texts_of


def telling(table: Table, of: Sequence[str], values: Collection[str], but: Collection[str]) -> list[str]:
    """Columns of numbers that stand beside some names only, or beside names without a value: a drive's duty.

    Parameters
    ----------
    table
        As it was read.
    of
        The name of each row.
    values
        The columns of the values.
    but
        Columns that have a place already.
    """
    others = [column for column in table.columns if column.name not in but or column.name in values]
    facts = Evidence([replace(table, columns=others)]).facts
    every = set(filter(None, of))
    valued = set().union(*(_names(of, np.isfinite(facts[name].parsed[0].values)) for name in values))
    found = []
    for name, entry in facts.items():
        own = name not in values and entry.kind == "number"
        told = _names(of, np.isfinite(entry.parsed[0].values)) if own else set()
        if told and (told < every or not told <= valued):
            found.append(name)
    return found


def fields_of(
    table: Table, of: Sequence[str], fields: Sequence[str], row_of: Sequence[int], count: int
) -> tuple[list[Column], list[int]]:
    """A column of each name that tells a field: ``motor.temp`` and ``room.temp``, or ``duty`` where only one does.

    Parameters
    ----------
    table
        As it was read.
    of, row_of
        The name of each row, and the row that it becomes part of.
    fields
        Columns of the table.
    count
        How many rows there will be.

    Returns
    -------
    columns, twice
        And the rows whose reading is the second of one name and time.
    """
    made: list[Column] = []
    twice: list[int] = []
    facts = Evidence([table]).facts
    for field in fields:
        column = table.column(field)
        names = _names(of, np.isfinite(facts[field].parsed[0].values))
        cells = {name: [""] * count for name in dict.fromkeys(of) if name in names}
        for i, (name, cell) in enumerate(zip(of, texts_of(column), strict=True)):
            if cell and name in cells:
                twice += [i] if cells[name][row_of[i]] else []
                cells[name][row_of[i]] = cells[name][row_of[i]] or cell
        made += [
            Column(field if len(cells) == 1 else f"{name}.{field}", own, column.unit) for name, own in cells.items()
        ]
    return made, twice


def _names(of: Sequence[str], rows: BoolArray) -> set[str]:
    """Names of rows."""
    return {of[i] for i in np.flatnonzero(rows).tolist()} - {""}
