"""Reading run files: quickly when they are well-formed, with the place of the fault when they are not."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.errors import InputError
from gen.runs.columns import Columns
from gen.runs.head import NUMBER, Head, check_columns, decoded, naming, opened, read_head
from gen.runs.run import AMBIENT, Run, board_columns
from gen.runs.thinning import thinned

_CELSIUS = (-273.15, 5000.0)
_HIGHEST = 1e12
"""No column's value is larger, in its unit: calculations with larger ones overflow."""
_FULL_PWM = 255
_PLAIN = b"0123456789+-.eE,"
_BLOCK_BYTES = 1 << 19


@dataclass(frozen=True)
class Contents:
    """What a run file holds, without any of its values.

    Parameters
    ----------
    rows
        How many there are.
    filled
        Columns with a value in at least one row.
    comments
        The comment lines.
    parts
        Columns with a temperature of a part, read in at least one row: of `filled` neither the ambient nor what a
        board's model says.
    """

    rows: int
    filled: frozenset[str]
    comments: Mapping[str, str] = field(default_factory=dict)
    parts: frozenset[str] = frozenset()


def read_run(
    path: Path | str,
    components: Collection[str] | None = None,
    *,
    require: Collection[str] = (),
    ambient: str = AMBIENT,
    most_rows: int | None = None,
) -> Run:
    """Read a run file.

    Parameters
    ----------
    path
        The CSV file.
    components
        Names of the model's components: their ``<name>_degC`` columns, as far as present, become `temps`, and
        other columns `extras`. None: every column ``<name>_degC`` is a component but the ambient and what a board's
        model says.
    require
        Components whose column must be present.
    ambient
        Name of the column with the ambient temperature.
    most_rows
        A file of more than twice as many rows is thinned to about as many (see :mod:`gen.runs.thinning`) and read
        in little memory; every row is checked all the same.

    Raises
    ------
    InputError
        With file, line and column, what was found and what was expected.
    """
    with naming(path), opened(Path(path)) as stream:
        head = read_head(stream)
        check_columns(head, require)
        channels = _read_rows(stream, head, None if most_rows is None else 2 * most_rows)
    rows = channels["time_s"].size
    if most_rows is not None and rows > 2 * most_rows:
        sampled = {name for name in channels if name.endswith("_degC")}
        channels = thinned(channels, sampled, most_rows)
    time_s, pwm = channels.pop("time_s"), channels.pop("pwm")
    measured = channels.pop(ambient, None)
    if components is None:
        own = board_columns(channels)
        components = [
            name.removesuffix("_degC") for name in channels if re.fullmatch(r".+_degC", name) and name not in own
        ]
    return Run(
        time_s=time_s,
        pwm=pwm.astype(np.int64),
        temps={name: channels.pop(f"{name}_degC") for name in components if f"{name}_degC" in channels},
        ambient=measured,
        extras=channels,
        comments=head.comments,
        rows_in_file=rows,
    )


def check_run(path: Path | str, *, require: Collection[str] = ()) -> Contents:
    """Check every row of a run file as :func:`read_run` does, and keep no value.

    Parameters
    ----------
    path, require
        As for :func:`read_run`.

    Raises
    ------
    InputError
        As :func:`read_run`.
    """
    filled: set[str] = set()
    rows = 0
    with naming(path), opened(Path(path)) as stream:
        head = read_head(stream)
        check_columns(head, require)
        for values in _checked(stream, head):
            rows += len(values)
            filled.update(head.columns[i] for i in np.flatnonzero(np.isfinite(values).any(axis=0)))
    others = {AMBIENT} | board_columns(head.columns)
    parts = frozenset(name for name in filled - others if name.endswith("_degC"))
    return Contents(rows, frozenset(filled), head.comments, parts)


def _read_rows(stream: IO[bytes], head: Head, compact_after: int | None) -> dict[str, FloatArray]:
    columns = Columns(head.columns, compact_after)
    for values in _checked(stream, head):
        columns.append(values)
    return columns.finished()


def _checked(stream: IO[bytes], head: Head) -> Iterator[FloatArray]:
    """Parse block by block, which bounds the memory and confines the slow way to the blocks that need it.

    Yields the rows of each block, shape (n, columns), all faults in them found; at least one block.
    """
    rows, last_time = 0, -np.inf
    for first, lines in _blocks(stream, head.first_row):
        fast = _parse_fast(lines, len(head.columns))
        values = _parse_slowly(lines, head, first) if fast is None else fast
        _check_values(values, head, first, last_time)
        last_time = values[-1, head.columns.index("time_s")]
        rows += len(values)
        yield values
    if rows == 0:
        raise InputError("there are no rows; expected at least one", place=f"line {head.first_row}")


def _blocks(stream: IO[bytes], first: int) -> Iterator[tuple[int, list[bytes]]]:
    """Blocks of whole lines with the number of their first; empty lines at the file's end belong to none."""
    rest = b""
    while True:
        read = stream.read(_BLOCK_BYTES)
        whole, newline, rest = (rest + read).rpartition(b"\n") if read else (rest, b"", b"")
        block = (whole + newline).replace(b"\r\n", b"\n")
        body = block.rstrip(b"\n")
        if body:
            lines = body.split(b"\n")
            yield first, lines
            first += len(lines)
        if not read:
            return
        # Empty lines that others follow are a fault of the next block: they go there, but for the last line's own end.
        rest = block[len(body) + bool(body) :] + rest


def _parse_fast(lines: list[bytes], width: int) -> FloatArray | None:
    """Parse well-formed lines; None for anything unusual, which the slow way then names or accepts.

    Python's own float is as quick here as pandas' parser, and rounds correctly in every version.
    """
    joined = b",".join(lines)
    if joined.translate(None, _PLAIN) or any(line.count(b",") != width - 1 for line in lines):
        return None
    missing = float("nan")
    try:
        numbers = [float(text) if text else missing for text in joined.split(b",")]
    except ValueError:
        return None
    values = np.array(numbers, dtype=np.float64).reshape(len(lines), width)
    return None if np.isinf(values).any() else values


def _parse_slowly(lines: list[bytes], head: Head, first: int) -> FloatArray:
    rows = []
    for number, line in enumerate(lines, start=first):
        fields = decoded(line, number).split(",")
        if not line.strip():
            raise InputError("found an empty line between the rows, expected a row", place=f"line {number}")
        if line.lstrip().startswith(b"#"):
            raise InputError("found a comment, expected it before the header", place=f"line {number}")
        if len(fields) != len(head.columns):
            raise InputError(
                f"found {len(fields)} fields, expected {len(head.columns)}, as many as the header has",
                place=f"line {number}",
            )
        rows.append([_number(text.strip(), number, name) for text, name in zip(fields, head.columns, strict=True)])
    return np.asarray(rows, dtype=np.float64)


def _number(text: str, line: int, column: str) -> float:
    if not text:
        return float("nan")
    value = float(text) if NUMBER.fullmatch(text) else float("inf")
    if np.isinf(value):
        shown = text if len(text) <= 40 else f"{text[:36]}..."
        expected = "a finite number" if NUMBER.fullmatch(text) else "a number, or nothing for a missing sample"
        raise InputError(f'found "{shown}", expected {expected}', place=f"line {line}, column {column}")
    return value


def _shown(value: float) -> str:
    """The shortest text that reads back as the same number: what stood in the file, most often."""
    return repr(float(value)).removesuffix(".0")


def _check_values(values: FloatArray, head: Head, first: int, last_time: float) -> None:
    def fail(bad: BoolArray, column: str, message: str) -> None:
        row = int(np.argmax(bad))
        value = values[row, head.columns.index(column)]
        found = "found nothing" if np.isnan(value) else f"found {_shown(value)}"
        raise InputError(f"{found}, {message}", place=f"line {first + row}, column {column}")

    time_s = values[:, head.columns.index("time_s")]
    pwm = values[:, head.columns.index("pwm")]
    for column, channel in (("time_s", time_s), ("pwm", pwm)):
        if np.isnan(channel).any():
            fail(np.isnan(channel), column, "expected a number in every row")
    before = np.concatenate([[last_time], time_s[:-1]])
    late = time_s <= before
    if late.any():
        fail(late, "time_s", f"expected more than {_shown(before[np.argmax(late)])} s, the time of the row before")
    wrong = (np.abs(pwm) > _FULL_PWM) | (pwm != np.round(pwm))
    if wrong.any():
        fail(wrong, "pwm", f"expected a whole number -{_FULL_PWM}..{_FULL_PWM}")
    for index, column in enumerate(head.columns):
        low, high = _CELSIUS if column.endswith("_degC") else (-_HIGHEST, _HIGHEST)
        beyond = (values[:, index] < low) | (values[:, index] > high)
        if beyond.any():
            fail(beyond, column, f"expected a number within {low:g}..{high:g}")
