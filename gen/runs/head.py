"""The head of a run file: comments and column names. Needs none of the numeric libraries."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from gen.errors import InputError

NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
OTHER_FILES = "`gen import` makes run files of a logger's own"
"""What a refusal says of a file that may be no run file at all."""


@dataclass(frozen=True)
class Head:
    """What stands before the rows.

    Parameters
    ----------
    comments
        The comment lines; a line without a colon has an empty value.
    columns
        Names of the columns, in order.
    first_row
        Number of the line that holds the first row; the file's first line is 1.
    """

    comments: dict[str, str]
    columns: list[str]
    first_row: int


def check_head(path: Path | str, require: Collection[str] = ()) -> None:
    """Find out before long work, or heavy imports, whether a file is there and has a run file's head.

    Parameters
    ----------
    path
        The CSV file; what is no file to be opened twice, such as a pipe, is left to its reader.
    require
        Components whose column must be present.

    Raises
    ------
    InputError
        With file, line and column, what was found and what was expected.
    """
    if Path(path).exists() and not Path(path).is_file() and not Path(path).is_dir():
        return
    with naming(path), opened(Path(path)) as stream:
        check_columns(read_head(stream), require)


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """Add the file's name to what is raised inside."""
    try:
        yield
    except InputError as error:
        raise InputError(error.message, file=str(path), place=error.place) from error.__cause__


@contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """Open a run file to read.

    Raises
    ------
    InputError
        Without a file name, when it cannot be read.
    """
    try:
        with path.open("rb") as stream:
            yield stream
    except FileNotFoundError:
        raise InputError("there is no such file; expected a run file") from None
    except IsADirectoryError:
        raise InputError("this is a directory; expected a run file") from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None


def read_head(stream: IO[bytes]) -> Head:
    """Read the lines before the rows.

    Raises
    ------
    InputError
        Without a file name, when there is no header line.
    """
    comments: dict[str, str] = {}
    number = 0
    while raw := stream.readline():
        number += 1
        if number == 1:
            raw = raw.removeprefix(b"\xef\xbb\xbf")
        line = decoded(raw.removesuffix(b"\n").removesuffix(b"\r"), number).strip()
        if line.startswith("#"):
            key, _, value = line[1:].partition(":")
            comments[key.strip()] = value.strip()
        elif line:
            return Head(comments, [name.strip() for name in line.split(",")], number + 1)
    if not comments:
        raise InputError("the file is empty; expected a header line and rows")
    raise InputError("there are only comments; expected a header line and rows", place=f"line {number}")


def check_columns(head: Head, require: Collection[str]) -> None:
    """Check the columns' names.

    Parameters
    ----------
    head
        The file's.
    require
        Components whose column must be present.

    Raises
    ------
    InputError
        Without a file name.
    """
    place = f"line {head.first_row - 1}"
    if all(NUMBER.fullmatch(name) or not name for name in head.columns):
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
            hint += f"; {OTHER_FILES}" if name in ("time_s", "pwm") else ""
            raise InputError(f"missing column {name}; found {found}{hint}", place=place)


def decoded(line: bytes, number: int) -> str:
    """Decode one line.

    Raises
    ------
    InputError
        Without a file name, when it is not UTF-8.
    """
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(
            f"byte 0x{line[error.start]:02x} is not UTF-8; expected a UTF-8 text; {OTHER_FILES}", place=f"line {number}"
        ) from error
