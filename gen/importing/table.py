"""What was read of a file before anybody knows what it means: named columns of text, numbers or instants."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray, IntArray

InstantArray = NDArray[np.datetime64]
_UNIT = re.compile(r"(.+?)(\s*[\[(].*[\])]|_[A-Za-z%]{1,6})?")
Cells = list[str] | FloatArray | InstantArray


@dataclass(frozen=True)
class Column:
    """One column.

    Parameters
    ----------
    name
        As the file has it; ``column_3`` where it has none.
    cells
        Texts, numbers (NaN where missing) or instants (datetime64[ns], NaT where missing), one for each row.
    unit
        What a row of units below the header says; empty without one.
    """

    name: str
    cells: Cells
    unit: str = ""


@dataclass(frozen=True)
class Counted:
    """Something that was found in a file, and how often.

    Parameters
    ----------
    what
        In words.
    count
        How often.
    first
        Where first: ``line 17``, ``line 17, column T1``.
    """

    what: str
    count: int
    first: str

    def __str__(self) -> str:
        return f"{self.count} x {self.what} (first: {self.first})"


@dataclass(frozen=True)
class Reading:
    """How a file's text becomes columns; empty where it does not apply.

    Parameters
    ----------
    encoding, delimiter, decimal
        As Python names them; the delimiter ``" "`` is any white space.
    why
        For each of them that was guessed, why.
    unsure
        Why the decimal mark is doubtful; empty where it is not.
    sheet
        Of a workbook, the only sheet to read.
    """

    encoding: str = ""
    delimiter: str = ""
    decimal: str = ""
    why: dict[str, str] = field(default_factory=dict)
    unsure: str = ""
    sheet: str = ""


@dataclass(frozen=True)
class Table:
    """One table of one file.

    Parameters
    ----------
    file
        Where it was read.
    columns
        All of one length.
    places
        Line (or row) of the file for each row, shape (N,).
    word
        What `places` count: "line" or "row".
    part
        The sheet, of a file with several tables; else empty.
    comments
        Lines ``# key: value`` of the file.
    reading
        How the text was taken.
    counted
        Lines that are no rows, and the like.
    untimed
        How to have times, where none are in it: how to record with them, or the interval that a line says.
    """

    file: Path
    columns: Sequence[Column]
    places: IntArray
    word: str = "line"
    part: str = ""
    comments: dict[str, str] = field(default_factory=dict)
    reading: Reading = field(default_factory=Reading)
    counted: tuple[Counted, ...] = ()
    untimed: str = ""

    @property
    def rows(self) -> int:
        """How many there are."""
        return int(self.places.size)

    @property
    def names(self) -> list[str]:
        """Of the columns, in order."""
        return [column.name for column in self.columns]

    @property
    def label(self) -> str:
        """File and sheet, as messages name it."""
        return f"{self.file}, sheet {self.part}" if self.part else str(self.file)

    def column(self, name: str) -> Column:
        """The column of that name."""
        return next(column for column in self.columns if column.name == name)

    def of_rows(self, rows: IntArray) -> Table:
        """A table of some of the rows, or of all in another order."""
        columns = [
            replace(c, cells=[c.cells[i] for i in rows] if isinstance(c.cells, list) else c.cells[rows])
            for c in self.columns
        ]
        return replace(self, columns=columns, places=self.places[rows])

    def place(self, row: int, column: str = "") -> str:
        """Where a row, or a cell of it, stands in the file."""
        where = f"{self.word} {self.places[row]}"
        return f"{where}, column {column}" if column else where


def unique_names(names: Sequence[str]) -> list[str]:
    """Names for all columns, each once.

    Parameters
    ----------
    names
        As the file has them: what has no name is numbered (``column_3``), what is there again gets a number before its
        unit (``T_2 (degC)``).
    """
    given = [name.strip() or f"column_{i}" for i, name in enumerate(names, start=1)]
    seen: Counter[str] = Counter()
    made: list[str] = []
    for name in given:
        seen[name] += 1
        shown = name
        while seen[name] > 1 and (shown in given or shown in made):
            parted = _UNIT.fullmatch(name)
            shown = f"{parted[1]}_{seen[name]}{parted[2] or ''}" if parted else f"{name}_{seen[name]}"
            seen[name] += shown in given or shown in made
        made.append(shown)
    return made


def texts_of(column: Column) -> list[str]:
    """Give a column's cells as texts, empty where nothing is.

    Parameters
    ----------
    column
        Of texts, numbers or instants.
    """
    if isinstance(column.cells, list):
        return [cell.strip() for cell in column.cells]
    if column.cells.dtype.kind == "M":
        return ["" if np.isnat(cell) else str(cell.astype("datetime64[ns]")) for cell in column.cells]
    return ["" if not np.isfinite(value) else repr(float(value)) for value in column.cells.astype(np.float64)]
