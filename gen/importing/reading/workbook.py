"""Excel workbooks to tables, one for each sheet that has rows of numbers."""

from __future__ import annotations

import io
import re
import warnings
import zipfile
import zlib
from dataclasses import replace
from datetime import date, datetime, time, timedelta
from decimal import Decimal
from pathlib import Path
from typing import Protocol

from gen.errors import InputError
from gen.importing.listing import listed
from gen.importing.reading.rows.delimited import table_of_rows
from gen.importing.table import Counted, Reading, Table

_PERCENT = re.compile(r'^(?:[^"\\%]|"[^"]*"|\\.)*%')
"""A number format that shows a share of 1 in percent; a quoted mark is only text."""

_WITH_COMMA = re.compile(r"[+-]?\d+,\d+")
_THOUSAND = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
_STAMP, _MIDNIGHT = re.compile(r"\d{4}-\d{2}-\d{2}T\S+"), "T00:00:00"


_UNCOMPUTED = re.compile(rb"<f\b[^>]*>[^<]*</f>\s*(?:<v\s*/>|<v>\s*</v>|</c>)")
_MOST_UNCOMPUTED = 10
"""Formulas without a value, up to which they may stand beside the rows."""


class _Formatted(Protocol):
    @property
    def number_format(self) -> str: ...


def read_workbook(file: Path, data: bytes, wanted: str = "") -> list[Table]:
    """Read every sheet that holds a table, or the one that is wanted; values as Excel last computed them.

    Raises
    ------
    InputError
        Without a file name: no workbook, no table in it, or no sheet of that name.
    """
    import openpyxl  # slow to import

    try:
        unknown = _uncomputed(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of styles and extensions that values do not need
            book = openpyxl.load_workbook(io.BytesIO(data), read_only=True, data_only=True)
            for sheet in book.worksheets:
                sheet.reset_dimensions()  # what a sheet says of its size is not always so
            sheets = {
                sheet.title: [[_text(cell.value, cell) for cell in row] for row in sheet.iter_rows()]
                for sheet in book.worksheets
            }
    except (KeyError, ValueError, OSError, TypeError, EOFError, zipfile.BadZipFile, zlib.error, SyntaxError) as error:
        raise InputError(
            f"cannot be read as an Excel workbook ({str(error)[:80]}); save it anew as .xlsx or CSV"
        ) from None
    if unknown > _MOST_UNCOMPUTED:
        raise InputError(
            f"{unknown} formulas have no stored value, as of a program that does not compute them; open the workbook "
            "in a spreadsheet program and save it"
        )
    if wanted and wanted not in sheets:
        raise InputError(f'found "{wanted}", expected one of the sheets {listed(sheets)}', place="--sheet")
    if wanted:
        return [replace(_table(file, wanted, sheets[wanted]), part="")]
    tables, without = [], []
    for name, rows in sheets.items():
        try:
            tables.append(_table(file, name, rows))
        except InputError as error:
            without.append((name, error))
    if not tables:
        raise InputError("no sheet holds rows of numbers below a header") if len(without) != 1 else without[0][1]
    if len(tables) == 1:
        skipped = tuple(Counted(f"sheet without a table: {name}", 1, f"sheet {name}") for name, _ in without)
        return [replace(tables[0], part="", counted=(*tables[0].counted, *skipped))]
    return tables


def _uncomputed(data: bytes) -> int:
    """How many formulas there are whose value nobody has computed."""
    with zipfile.ZipFile(io.BytesIO(data)) as book:
        sheets = [name for name in book.namelist() if name.startswith("xl/worksheets/")]
        return sum(len(_UNCOMPUTED.findall(book.read(name))) for name in sheets)


def _table(file: Path, name: str, rows: list[list[str]]) -> Table:
    width = max(map(len, rows), default=0)
    rows = [row + [""] * (width - len(row)) for row in rows]
    _midnights_to_dates(rows)
    _commas_to_points(rows)
    filled = [(number, row) for number, row in enumerate(rows, start=1) if any(row)]
    used = [i for i in range(max((len(row) for _, row in filled), default=0)) if any(row[i] for _, row in filled)]
    cells = [[row[i] for i in used] for _, row in filled]
    if not cells:
        raise InputError("is empty", place=f"sheet {name}")
    numbers = [number for number, _ in filled]
    try:
        return table_of_rows(file, cells, numbers, reading=Reading(decimal="."), word="row", part=name)
    except InputError as error:
        raise InputError(error.message, place=f"sheet {name}, {error.place}") from None


def _midnights_to_dates(rows: list[list[str]]) -> None:
    """Dates alone where all timestamps of a column are midnights, in place: so Excel has dates beside times of day."""
    for i in range(len(rows[0]) if rows else 0):
        stamps = [row for row in rows if _STAMP.fullmatch(row[i])]
        if stamps and all(row[i].endswith(_MIDNIGHT) for row in stamps):
            for row in stamps:
                row[i] = row[i].removesuffix(_MIDNIGHT)


def _commas_to_points(rows: list[list[str]]) -> None:
    """Points in columns of numbers that were typed as text with decimal commas, in place."""
    for i in range(len(rows[0]) if rows else 0):
        typed = [row for row in rows if _WITH_COMMA.fullmatch(row[i])]
        if any(not _THOUSAND.fullmatch(row[i]) for row in typed):
            for row in typed:
                row[i] = row[i].replace(",", ".")


def _text(value: object, cell: _Formatted) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, (int, float)):
        return f"{_hundredfold(value)} %" if _PERCENT.search(cell.number_format) else repr(value)
    if isinstance(value, (datetime, date, time)):
        return value.isoformat()
    if isinstance(value, timedelta):
        return repr(value.total_seconds())
    return str(value).strip()


def _hundredfold(value: float) -> str:
    """A share of 1 in percent, to the digit: 0.07 becomes 7."""
    return f"{Decimal(repr(value)) * 100:f}"
