"""MATLAB's files to tables: vectors, columns of matrices, fields of structures."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from gen.errors import InputError
from gen.importing.reading.delimited import MOST_COLUMNS
from gen.importing.table import Cells, Column, Reading, Table

_LABELS = ("label", "name", "title", "blockName")


def read_matlab(file: Path, data: bytes) -> Table:
    """Read a MATLAB file of version 4 to 7: vectors of one length, columns of matrices, fields of structures.

    Raises
    ------
    InputError
        Without a file name: version 7.3, broken, or nothing that is a column.
    """
    if b"MATLAB 7.3" in data[:128]:
        raise InputError(
            "is a MATLAB file of version 7.3, which is not read; save it in MATLAB by save('log.mat', ..., '-v7'), "
            "or write a table by writetable(T, 'log.csv')"
        )
    from scipy.io import loadmat  # slow to import

    try:
        content = loadmat(
            io.BytesIO(data),  # type: ignore[arg-type]
            squeeze_me=True,
            struct_as_record=False,
            chars_as_strings=True,
        )
    except Exception as error:  # scipy raises what it meets in a broken file
        raise InputError(f"cannot be read as a MATLAB file ({str(error)[:80]})") from None
    opaque = [str(name) for name, value in content.items() if type(value).__name__ == "MatlabOpaque" or name == "None"]
    vectors = _named(
        [
            found
            for name, value in content.items()
            if not name.startswith("__") and name not in opaque
            for found in _vectors((name,), value)
        ]
    )
    lengths = Counter(len(cells) for cells in vectors.values() if len(cells) > 1)
    if not lengths:
        hint = "; a table or timetable is opaque: write it by writetable(T, 'log.csv')" if opaque else ""
        raise InputError(f"found no vectors of one length{hint}")
    if len(vectors) > MOST_COLUMNS:
        raise InputError(f"found {len(vectors)} vectors, expected {MOST_COLUMNS} at most")
    rows = max(lengths, key=lambda length: (lengths[length], length))
    columns = [Column(name, cells) for name, cells in vectors.items() if len(cells) == rows]
    comments = {name: f"{value:g}" for name, value in content.items() if isinstance(value, (int, float))}
    return Table(file, columns, np.arange(1, rows + 1), "row", comments=comments, reading=Reading())


def _vectors(path: tuple[str, ...], value: object) -> Iterator[tuple[tuple[str, ...], Cells]]:
    """Columns in a variable, by the names that lead there: fields of structures, structures of an array by label."""
    fields = getattr(value, "_fieldnames", None)
    if fields is not None:
        for field in fields:
            yield from _vectors((*path, field), getattr(value, field))
        return
    if not isinstance(value, np.ndarray) or value.ndim not in (1, 2):
        return
    if value.dtype.kind == "O" and all(hasattr(entry, "_fieldnames") for entry in value.flat):
        for i, entry in enumerate(value.flat, start=1):
            within = dict(_vectors((), entry))
            label = _label(entry) or str(i)
            for (*_, field), cells in within.items():
                yield (*path, label, *([field] if len(within) > 1 else [])), cells
    elif value.dtype.kind in "biuf":
        numbers = value.astype(np.float64)
        if numbers.ndim == 1:
            yield path, numbers
            return
        wide = numbers.T if numbers.shape[0] >= numbers.shape[1] else numbers
        for i, column in enumerate(wide, start=1):
            yield (*path[:-1], f"{path[-1] if path else 'column'}_{i}"), np.ascontiguousarray(column)
    elif value.ndim == 1 and value.size and all(isinstance(entry, str) for entry in value):
        yield path, [str(entry).strip() for entry in value]


def _label(entry: object) -> str:
    """What a structure of an array calls itself: a signal of Simulink's has a label."""
    said = (getattr(entry, key, "") for key in _LABELS)
    return next((text.strip() for text in said if isinstance(text, str) and text.strip()), "")


def _named(found: Sequence[tuple[tuple[str, ...], Cells]]) -> dict[str, Cells]:
    """Columns by the last of their names; by all of them where several have the same last one."""
    last = Counter(path[-1] for path, _ in found)
    return {path[-1] if last[path[-1]] == 1 else ".".join(path): cells for path, cells in found}
