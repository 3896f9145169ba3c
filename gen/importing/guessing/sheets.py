"""Which sheets of a workbook are logs, and which only stand beside one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gen.errors import InputError
from gen.importing.guessing.decide import decide
from gen.importing.guessing.guesses import Choices, quoted
from gen.importing.listing import listed
from gen.importing.mapping import Mapping
from gen.importing.table import Counted, Table

_FEW = 0.1
"""Of the rows of the longest sheet: a summary, or what the test was, has fewer."""


def logs_among(tables: Sequence[Table], choices: Choices, known: Mapping | None) -> list[Table]:
    """Tables without sheets that are short, are no log, and have other columns than the longest sheet of their file.

    Parameters
    ----------
    tables
        Of all files.
    choices, known
        What the user and the mapping file say.
    """
    made: list[Table] = []
    files: dict[Path, list[Table]] = {}
    for table in tables:
        files.setdefault(table.file, []).append(table)
    for sheets in files.values():
        longest = max(sheets, key=lambda table: table.rows)
        beside = [table for table in sheets if _stands_beside(table, longest, choices, known)]
        told = [Counted(f"sheet that is no log: {table.part}", 1, f"sheet {table.part}") for table in beside]
        left = [
            replace(table, counted=(*table.counted, *told)) if table is longest else table
            for table in sheets
            if not any(table is other for other in beside)
        ]
        made += [replace(left[0], part="")] if len(left) == 1 < len(sheets) else left
    return made


def _stands_beside(table: Table, longest: Table, choices: Choices, known: Mapping | None) -> bool:
    if table.rows >= _FEW * longest.rows or table.names == longest.names:
        return False
    try:
        decide([table], choices, known)
    except InputError:
        return True
    return False


def choice_of_sheets(tables: Sequence[Table], file: Path) -> str:
    """What to add to a message about one of several sheets; empty for a file that has not several.

    Parameters
    ----------
    tables
        Of all files.
    file
        Which of them.
    """
    names = [quoted(table.part) for table in tables if table.file == file and table.part]
    return f"; or --sheet NAME, of {listed(names)}, if only one is the log" if len(names) > 1 else ""
