"""Reading run files: quickly when they are well-formed, with the place of the fault when they are not."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gen.errors import InputError
from gen.runs.run import AMBIENT, FloatArray, Run

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_PLAIN = b"0123456789+-.eE,"
_BLOCK = 10_000


@dataclass(frozen=True)
class _Head:
    comments: dict[str, str]
    columns: list[str]
    first_row: int
    """Number of the line that holds the first row; the file's first line is 1."""


def read_run(
    path: Path | str,
    components: Collection[str] | None = None,
    *,
    require: Collection[str] = (),
    ambient: str = AMBIENT,
) -> Run:
    """Read a run file.

    Parameters
    ----------
    path
        The CSV file.
    components
        Names of the model's components: their ``<name>_degC`` columns, as far as present, become `temps`, and
        other columns `extras`. None: every column ``<name>_degC`` but the ambient is a component.
    require
        Components whose column must be present.
    ambient
        Name of the column with the ambient temperature.

    Raises
    ------
    InputError
        With file, line and column, what was found and what was expected.
    """
    try:
        head, values = _parse(_read(Path(path)), require)
    except InputError as error:
        raise InputError(error.message, file=str(path), place=error.place) from error.__cause__
    channels = {name: values[:, i].copy() for i, name in enumerate(head.columns)}
    time_s, pwm = channels.pop("time_s"), channels.pop("pwm")
    measured = channels.pop(ambient, None)
    if components is None:
        components = [name.removesuffix("_degC") for name in channels if re.fullmatch(r".+_degC", name)]
    return Run(
        time_s=time_s,
        pwm=pwm.astype(np.int64),
        temps={name: channels.pop(f"{name}_degC") for name in components if f"{name}_degC" in channels},
        ambient=measured,
        extras=channels,
        comments=head.comments,
    )


def _parse(raw: bytes, require: Collection[str]) -> tuple[_Head, FloatArray]:
    raw = raw.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n")
    if not raw.strip():
        raise InputError("the file is empty; expected a header line and rows")
    head, body = _parse_head(raw)
    _check_columns(head, require)
    body = body.rstrip(b"\n")
    if not body:
        raise InputError("there are no rows; expected at least one", place=f"line {head.first_row}")
    values = _parse_rows(body.split(b"\n"), head)
    _check_values(values, head)
    return head, values


def _parse_head(raw: bytes) -> tuple[_Head, bytes]:
    comments: dict[str, str] = {}
    start = 0
    number = 0
    while start < len(raw):
        number += 1
        end = raw.find(b"\n", start)
        end = len(raw) if end < 0 else end
        line = _decode(raw[start:end], number).strip()
        start = end + 1
        if line.startswith("#"):
            key, _, value = line[1:].partition(":")
            comments[key.strip()] = value.strip()
        elif line:
            return _Head(comments, [name.strip() for name in line.split(",")], number + 1), raw[start:]
    raise InputError("there are only comments; expected a header line and rows", place=f"line {number}")


def _check_columns(head: _Head, require: Collection[str]) -> None:
    place = f"line {head.first_row - 1}"
    if all(_NUMBER.fullmatch(name) or not name for name in head.columns):
        raise InputError("found numbers, expected a header line such as time_s,pwm,brush_degC", place=place)
    seen: set[str] = set()
    for index, name in enumerate(head.columns):
        if not name:
            raise InputError(f"column {index + 1} has no name in the header", place=place)
        if name in seen:
            raise InputError("this column appears twice in the header", place=f"{place}, column {name}")
        seen.add(name)
    for name in ("time_s", "pwm", *(f"{component}_degC" for component in require)):
        if name not in seen:
            found = ", ".join(head.columns)
            hint = "; expected commas between the columns" if re.search(r"[;\t]", found) else ""
            raise InputError(f"missing column {name}; found {found}{hint}", place=place)


def _parse_rows(lines: list[bytes], head: _Head) -> FloatArray:
    """Parse block by block, which bounds the memory and confines the slow way to the blocks that need it."""
    parts = []
    for first in range(0, len(lines), _BLOCK):
        block = lines[first : first + _BLOCK]
        values = _parse_fast(block, len(head.columns))
        parts.append(_parse_slowly(block, head, head.first_row + first) if values is None else values)
    return np.concatenate(parts)


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


def _parse_slowly(lines: list[bytes], head: _Head, first: int) -> FloatArray:
    rows = []
    for number, line in enumerate(lines, start=first):
        fields = _decode(line, number).split(",")
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
    value = float(text) if _NUMBER.fullmatch(text) else float("inf")
    if np.isinf(value):
        shown = text if len(text) <= 40 else f"{text[:36]}..."
        expected = "a finite number" if _NUMBER.fullmatch(text) else "a number, or nothing for a missing sample"
        raise InputError(f'found "{shown}", expected {expected}', place=f"line {line}, column {column}")
    return value


def _check_values(values: FloatArray, head: _Head) -> None:
    def fail(bad: NDArray[np.bool_], column: str, message: str) -> None:
        row = int(np.argmax(bad))
        value = values[row, head.columns.index(column)]
        found = "found nothing" if np.isnan(value) else f"found {value:.17g}"
        raise InputError(f"{found}, {message}", place=f"line {head.first_row + row}, column {column}")

    time_s = values[:, head.columns.index("time_s")]
    pwm = values[:, head.columns.index("pwm")]
    for column, channel in (("time_s", time_s), ("pwm", pwm)):
        if np.isnan(channel).any():
            fail(np.isnan(channel), column, "expected a number in every row")
    late = np.diff(time_s, prepend=-np.inf) <= 0.0
    if late.any():
        row = int(np.argmax(late))
        fail(late, "time_s", f"expected more than {time_s[row - 1]:.17g} s, the time of the row before")
    wrong = (np.abs(pwm) > 255) | (pwm != np.round(pwm))
    if wrong.any():
        fail(wrong, "pwm", "expected a whole number -255..255")


def _decode(line: bytes, number: int) -> str:
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(
            f"byte 0x{line[error.start]:02x} is not UTF-8; expected a UTF-8 text", place=f"line {number}"
        ) from error


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise InputError("there is no such file; expected a run file") from None
    except IsADirectoryError:
        raise InputError("this is a directory; expected a run file") from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None
