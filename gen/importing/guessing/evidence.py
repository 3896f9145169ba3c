"""What the columns of files with one header hold, taken together."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.importing.behind import brought, commonest
from gen.importing.clock import kind_of
from gen.importing.guessing.names import AMBIENT, PARTS, carried
from gen.importing.numbers import Parsed, parse
from gen.importing.table import Column, Table
from gen.importing.units import TEMPERATURE, Unit, split_name, unit_of

_LEAST_NUMBERS = 0.2
_COUNTED_TIME = re.compile(r"(?P<base>t|[Tt]ime|[Ee]lapsed|[Zz]eit|[Tt]emps|[Tt]empo)[ _.](?P<unit>min|mins|d)")
"""Minutes or days where numbers rise all the way: `t_min` may be the least of temperatures, too."""


@dataclass(frozen=True, eq=False)
class Facts:
    """One column in all files.

    Parameters
    ----------
    name
        As the files have it.
    columns
        Of each table.
    decimals
        Decimal mark of each table.
    """

    name: str
    columns: Sequence[Column]
    decimals: Sequence[str]

    @cached_property
    def kind(self) -> str:
        """What it holds: "number", "instant", "date", "clock", "minutes", "text" or "nothing"."""
        cells = self.columns[0].cells
        if not isinstance(cells, list):
            if cells.dtype.kind == "M":
                return "instant"
            return "number" if self.values.size else "nothing"
        found = kind_of(cells)
        if found:
            return found
        if self.values.size and max(entry.numeric for entry in self.parsed) >= _LEAST_NUMBERS:
            return "number"
        return "text" if any(entry.text.any() for entry in self.parsed) else "nothing"

    @cached_property
    def parsed(self) -> list[Parsed]:
        """The numbers of each table, all in one unit where units stand behind them."""
        return [brought(entry, self.own) for entry in self._written]

    def parsed_in(self, index: int, unit: Unit | None) -> Parsed:
        """The numbers of one table in a unit of their quantity: what stands behind them counts, whatever was said.

        Parameters
        ----------
        index
            The table.
        unit
            What numbers without one are in; None, or one of another quantity than the column's, leaves them as in
            `parsed`.
        """
        if unit is None or (self.own is not None and self.own.target != unit.target):
            return self.parsed[index]
        return brought(self._written[index], unit)

    @cached_property
    def _written(self) -> list[Parsed]:
        return [_parsed(column, mark) for column, mark in zip(self.columns, self.decimals, strict=True)]

    @cached_property
    def _headed(self) -> tuple[str, Unit | None, str]:
        """Name without unit, and the unit that the header or a row below it says."""
        base, unit, written = split_name(carried(self.name))
        if unit is None and written and (PARTS.search(written) or AMBIENT.search(written)):
            base = f"{base} {written}"  # `CH0(Winding)`
        elif unit is None and written.isdigit() and base:
            base = f"{base}{written}"  # `T[0]`
        if unit is not None:
            return base, unit, "name"
        row = unit_of(self.columns[0].unit) if self.columns[0].unit else None
        return (base, row, "row of units") if row is not None else (base, None, "")

    @cached_property
    def own(self) -> Unit | None:
        """The unit of its numbers: the header's, or that behind most of them where it is of another quantity."""
        headed, behind = self._headed[1], commonest(self._written)
        return headed if headed is not None and (behind is None or behind.target == headed.target) else behind

    @cached_property
    def values(self) -> FloatArray:
        """All numbers, shape (n,), without those missing."""
        joined = np.concatenate([entry.values for entry in self.parsed])
        return np.asarray(joined[np.isfinite(joined)])

    @cached_property
    def steps(self) -> FloatArray:
        """Differences from number to number within each table."""
        found = [entry.values[np.isfinite(entry.values)] for entry in self.parsed]
        return np.concatenate([np.diff(values) for values in found])

    @cached_property
    def texts(self) -> list[str]:
        """All cells as text; empty for a typed column."""
        return [cell for column in self.columns if isinstance(column.cells, list) for cell in column.cells]

    @cached_property
    def times_read(self) -> dict[tuple[int | str, ...], IntArray]:
        """Times of each table, once they were read, by the table and how."""
        return {}

    @cached_property
    def named(self) -> tuple[str, Unit | None, str]:
        """Name without unit, the unit, and where that was found: "name", "row of units", "values" or nothing."""
        base, unit, where = self._headed
        if self.own is not None:
            return (base, unit, where) if self.own is unit else (base, self.own, "values")
        minutes = _COUNTED_TIME.fullmatch(base)
        if minutes and self.kind == "number" and self.steps.size and (self.steps > 0).all():
            return minutes["base"], unit_of(minutes["unit"]), "name"
        return base, None, ""

    @property
    def written_unit(self) -> str:
        """What stands in brackets behind the name, or below it, whether it is known as a unit or not."""
        return split_name(self.name)[2] or self.columns[0].unit

    def without(self, numbers: Collection[float]) -> Facts:
        """The column with nothing where one of these numbers is.

        Parameters
        ----------
        numbers
            As `values` has them.
        """
        if not numbers:
            return self
        odd = [np.isin(entry.values, list(numbers)) for entry in self.parsed]
        columns = [_emptied(column, rows) for column, rows in zip(self.columns, odd, strict=True)]
        return Facts(self.name, columns, self.decimals)

    @property
    def in_degrees(self) -> bool:
        """Whether its unit is one of temperatures."""
        unit = self.named[1]
        return unit is not None and unit.quantity == TEMPERATURE

    @property
    def whole(self) -> bool:
        """Whether all numbers are whole."""
        return bool(np.all(self.values == np.round(self.values)))

    @property
    def span(self) -> tuple[float, float]:
        """Smallest and largest number; of no numbers, zeros."""
        return (float(self.values.min()), float(self.values.max())) if self.values.size else (0.0, 0.0)

    @property
    def starts(self) -> FloatArray:
        """Median of each table's first five numbers."""
        found = [entry.values[np.isfinite(entry.values)][:5] for entry in self.parsed]
        return np.array([np.median(values) for values in found if values.size])


def _emptied(column: Column, rows: BoolArray) -> Column:
    cells = column.cells
    if isinstance(cells, list):
        return replace(column, cells=["" if gone else cell for cell, gone in zip(cells, rows.tolist(), strict=True)])
    return replace(column, cells=np.where(rows, np.nan, cells))


def _parsed(column: Column, mark: str) -> Parsed:
    cells = column.cells
    if isinstance(cells, list):
        return parse(cells, mark or ".")
    instants = cells.dtype.kind == "M"
    values = np.full(len(cells), np.nan) if instants else np.where(np.isfinite(cells), cells, np.nan)
    none = np.zeros(len(values), dtype=bool)
    return Parsed(values, np.isnan(values), none, none)


class Evidence:
    """The columns of tables that have the same ones.

    Parameters
    ----------
    tables
        At least one; all with the same names of columns.
    """

    def __init__(self, tables: Sequence[Table]) -> None:
        self.tables = tables
        decimals = [table.reading.decimal for table in tables]
        self.facts = {name: Facts(name, [table.column(name) for table in tables], decimals) for name in tables[0].names}

    @property
    def numbers(self) -> list[Facts]:
        """Columns of numbers, in order."""
        return [facts for facts in self.facts.values() if facts.kind == "number"]
