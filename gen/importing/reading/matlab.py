"""MATLAB's files to tables: vectors, columns of matrices, fields of structures."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray
from gen.errors import InputError
from gen.importing.guessing.names import TIME
from gen.importing.reading.rows.delimited import MOST_COLUMNS
from gen.importing.reading.told_units import with_told_units
from gen.importing.table import Cells, Column, Counted, Reading, Table

_LABELS = ("label", "name", "title", "blockName")
_INFOS = ("DataInfo", "TimeInfo")
_CARRIERS = {"value", "values", "data"}
"""What a structure calls its numbers, which says nothing of them."""
_ANY = "0"
"""Stands for a vector's numbers, beside which a unit may stand."""
_LEAST_SIGNALS = 2
Names = tuple[str, ...]
Vector = tuple[Names, Cells]


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
    found = [
        entry
        for name, value in content.items()
        if not name.startswith("__") and name not in opaque
        for entry in _entries((name,), value)
    ]
    vectors = [(path, cells) for path, cells in found if not isinstance(cells, str)]
    if len(vectors) > MOST_COLUMNS:
        raise InputError(f"found {len(vectors)} vectors, expected {MOST_COLUMNS} at most")
    units = _units(vectors, [(path, text) for path, text in found if isinstance(text, str)])
    vectors, left = _of_one_length(_with_one_time(vectors))
    if not vectors:
        hint = "; a table or timetable is opaque: write it by writetable(T, 'log.csv')" if opaque else ""
        raise InputError(f"found no vectors of one length{hint}")
    names = _names([path for path, _ in vectors])
    columns = [Column(names[path], cells, units.get(path, "")) for path, cells in vectors]
    comments = {name: f"{value:g}" for name, value in content.items() if isinstance(value, (int, float))}
    rows = len(columns[0].cells)
    counted = (Counted("vector of another length, left out", len(left), ".".join(left[0])),) if left else ()
    return Table(file, columns, np.arange(1, rows + 1), "row", comments=comments, reading=Reading(), counted=counted)


def _entries(path: Names, value: object) -> Iterator[tuple[Names, Cells | str]]:
    """Columns and texts in a variable, by the names that lead there; structures of an array by their labels."""
    fields = getattr(value, "_fieldnames", None)
    if fields is not None:
        for field in fields:
            yield from _entries((*path, field), getattr(value, field))
        return
    if isinstance(value, str):
        yield path, value
    if not isinstance(value, np.ndarray) or value.ndim not in (1, 2):
        return
    if value.dtype.kind == "O" and all(hasattr(entry, "_fieldnames") for entry in value.flat):
        for i, entry in enumerate(value.flat, start=1):
            within = {path: cells for path, cells in _entries((), entry) if not isinstance(cells, str)}
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


def _units(vectors: Sequence[Vector], texts: Sequence[tuple[Names, str]]) -> dict[Names, str]:
    """The units that texts tell beside vectors: `s.winding.unit`, `units.winding`, a timeseries' `DataInfo.Units`."""
    plain = {".".join(path): path for path, _ in vectors}
    record = dict.fromkeys(plain, _ANY)
    for path, text in texts:
        if len(path) > 1 and path[-2] in _INFOS:
            path = (*path[:-2], f"{path[-2].removesuffix('Info')}_{path[-1]}")
        record.setdefault(".".join(path), text)
    told = with_told_units(record)
    return {path: told[name].removeprefix(_ANY).strip() for name, path in plain.items() if told[name] != _ANY}


def _with_one_time(vectors: Sequence[Vector]) -> list[Vector]:
    """Signals that each have a time of their own: with one where it is the same, else each behind its own."""
    inside: dict[Names, list[Vector]] = {}
    for path, cells in vectors:
        inside.setdefault(path[:-1], []).append((path, cells))
    signals = {parent: signal for parent, own in inside.items() if (signal := _signal(own)) is not None}
    if len(signals) < _LEAST_SIGNALS:
        return list(vectors)
    times = [time for (_, time), _ in signals.values()]
    if all(np.array_equal(time, times[0]) for time in times[1:]):
        first = next(iter(signals.values()))[0][0]
        others = {path for (path, _), _ in signals.values()} - {first}
        return [(path, cells) for path, cells in vectors if path not in others]
    longest = max(map(len, times))
    return [
        (path, np.append(cells, np.full(longest - len(cells), np.nan)))
        for pair in signals.values()
        for path, cells in pair
    ]


def _signal(own: Sequence[Vector]) -> tuple[tuple[Names, FloatArray], tuple[Names, FloatArray]] | None:
    """A structure's time and its values, where it holds these two."""
    numbers = [(path, cells) for path, cells in own if isinstance(cells, np.ndarray) and cells.dtype.kind == "f"]
    times = [entry for entry in numbers if TIME.fullmatch(entry[0][-1].casefold())]
    if len(numbers) != 2 or len(times) != 1 or len(numbers[0][1]) != len(numbers[1][1]) or len(times[0][1]) < 2:
        return None
    other = next(entry for entry in numbers if entry is not times[0])
    return times[0], other  # type: ignore[return-value]


def _of_one_length(vectors: Sequence[Vector]) -> tuple[list[Vector], list[Names]]:
    """Vectors of the length that most have, and the others that are none of single numbers."""
    lengths = Counter(len(cells) for _, cells in vectors if len(cells) > 1)
    if not lengths:
        return [], []
    rows = max(lengths, key=lambda length: (lengths[length], length))
    kept = [(path, cells) for path, cells in vectors if len(cells) == rows]
    return kept, [path for path, cells in vectors if len(cells) not in (rows, 0, 1)]


def _label(entry: object) -> str:
    """What a structure of an array calls itself: a signal of Simulink's has a label."""
    said = (getattr(entry, key, "") for key in _LABELS)
    return next((text.strip() for text in said if isinstance(text, str) and text.strip()), "")


def _names(paths: Sequence[Names]) -> dict[Names, str]:
    """Columns by the last of their names that says something; by all of them where several have the same last one."""
    said = {path: path[:-1] if len(path) > 1 and path[-1].casefold() in _CARRIERS else path for path in paths}
    last = Counter(path[-1] for path in said.values())
    return {path: plain[-1] if last[plain[-1]] == 1 else ".".join(plain) for path, plain in said.items()}
