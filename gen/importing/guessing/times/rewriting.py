"""Columns of a table written otherwise: each by itself, or with what the column behind it says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from gen.importing.table import Column, Counted, Table

ByItself = Callable[[Column], tuple[list[str], str] | None]
"""A column's cells, written otherwise, and what to tell of it; None for a column that stays."""
WithTheNext = Callable[[Column, Column], tuple[list[str], str] | None]
"""Likewise of a column and the one behind it."""


def each_rewritten(table: Table, by: ByItself) -> Table:
    """Rewrite every column that asks for it; without any, a table stays as it is.

    Parameters
    ----------
    table
        As it was read.
    by
        For each column.
    """
    made, told = list(table.columns), list(table.counted)
    for i, column in enumerate(table.columns):
        found = by(column)
        if found is not None:
            made[i] = replace(column, cells=found[0])
            told.append(Counted(found[1], len(found[0]), f"column {column.name}"))
    return replace(table, columns=made, counted=tuple(told)) if len(told) > len(table.counted) else table


def first_joined(table: Table, by: WithTheNext) -> Table:
    """Put the first column that says something of the one before it into that one; without any, a table stays.

    Parameters
    ----------
    table
        As it was read.
    by
        For each column and the one behind it.
    """
    columns = list(table.columns)
    for i, (before, column) in enumerate(pairwise(columns)):
        found = by(before, column)
        if found is not None:
            told = Counted(found[1], len(found[0]), f"column {column.name}")
            made = [*columns[:i], replace(before, cells=found[0]), *columns[i + 2 :]]
            return replace(table, columns=made, counted=(*table.counted, told))
    return table
