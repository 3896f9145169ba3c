"""Objects by their times, by keys that mean nothing (Firebase), or of columns (pandas): to an array of objects."""

from __future__ import annotations

from collections.abc import Mapping

from gen.importing.numbers import plain_number
from gen.importing.reading.stamps import is_stamp

_LEAST = 5
_LEAST_ALIKE = 20
"""Of keys that are no times: fewer objects with the same names are parts, and no rows."""


def entries_of(tree: object) -> object:
    """An array of the objects within one whose keys are times, or which have all the same names; else as it is.

    Objects that have all the same rows, by number or time, are columns, as pandas writes them.

    Parameters
    ----------
    tree
        A JSON text; what is looked for may be the only object within others.
    """
    if not isinstance(tree, dict):
        return tree
    if len(tree) == 1:
        (within,) = tree.values()
        found = entries_of(within)
        return found if found is not within else tree
    rows = _of_columns(tree)
    if rows:
        return rows
    entries = list(tree.values())
    if len(entries) < _LEAST or not all(isinstance(entry, dict) and entry for entry in entries):
        return tree
    if all(map(is_stamp, tree)):
        return [{"time": key, **entry} for key, entry in tree.items()]
    alike = {tuple(sorted(entry)) for entry in entries}
    return entries if len(entries) >= _LEAST_ALIKE and len(alike) == 1 else tree


def _of_columns(tree: Mapping[str, object]) -> list[dict[str, object]]:
    """Rows of columns that hold a value for each row, by its time or number: ``{"T1": {"0": 21.5, "1": 21.6}, ..}``."""
    columns = [column for column in tree.values() if isinstance(column, dict)]
    if not tree or len(columns) < len(tree) or len(columns[0]) < _LEAST or all(map(_is_index, tree)):
        return []
    index = list(columns[0])
    if len(index) <= len(tree):  # rather objects of numbered channels
        return []
    if not all(map(_is_index, index)) or any(list(column) != index for column in columns):
        return []
    if any(isinstance(value, (dict, list)) for column in columns for value in column.values()):
        return []
    rows = [
        dict(zip(tree, values, strict=True)) for values in zip(*(column.values() for column in columns), strict=True)
    ]
    if index == [str(row) for row in range(len(index))]:  # which says nothing
        return rows
    called = "time" if all(map(is_stamp, index)) and "time" not in tree else ""
    return [{called: key, **row} for key, row in zip(index, rows, strict=True)]


def _is_index(key: str) -> bool:
    """Whether a key is the number or the time of a row."""
    return plain_number(key) is not None or is_stamp(key)
