"""Text files to tables: CSV of any dialect, a sketch's output, what a controller publishes, JSON."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gen.errors import InputError
from gen.importing.numbers import decimal_mark
from gen.importing.reading import documents
from gen.importing.reading.encoding import decode
from gen.importing.reading.keyed import array_table, is_json, json_table, keyed_table, tagged_table
from gen.importing.reading.lines import Lines
from gen.importing.reading.pairs import is_keyed, is_sparsely_keyed
from gen.importing.reading.published import is_published, published_table
from gen.importing.reading.rows.cells import DELIMITERS, guess_delimiter, lines_of, split_rows, stamped
from gen.importing.reading.rows.delimited import table_of_rows
from gen.importing.reading.tagged import chips, line_protocol, marked, prometheus, rounds, topics
from gen.importing.reading.torn import without_blocks
from gen.importing.table import Reading, Table

_BEGINS_AS_JSON = re.compile(r'\s*\ufeff?\s*(?:\[\s*\{|\{\s*")')
_MAY_BE_DOCUMENTS = re.compile(r"^\{\s*$", re.MULTILINE)
_FRAME = re.compile(
    r"\s*(?:\(\d+\.\d+\) )?\s*\w*can\d+\s+[0-9A-F]{3,8}(?:##?[0-9A-FR]*|\s+\[\d+\](?:\s+[0-9A-F]{2})*)\s*$",
    re.IGNORECASE,
)
"""candump's: `(1772439300.000123) can0 123#0011`, `can0  123   [2]  00 11`."""
_SAMPLE = 400
_NEAR_END = 200
"""Characters."""


def read_text(file: Path, data: bytes, given: Reading) -> Table:
    """Read one text file.

    Parameters
    ----------
    file
        Its name.
    data
        What is in it.
    given
        What need not be guessed; empty fields are.

    Raises
    ------
    InputError
        Without a file name, with the place.
    """
    text, encoding, why = decode(data, given.encoding)
    text, torn = without_blocks(text)
    table = _table(file, text, given, encoding, why)
    return replace(table, counted=(*torn, *table.counted))


def _table(file: Path, text: str, given: Reading, encoding: str, why: str) -> Table:
    reading = Reading(encoding, given.delimiter, given.decimal, {"encoding": why} if why else {})
    text = text.removeprefix("\ufeff")
    lines = lines_of(text)
    if not lines.texts:
        raise InputError("there are only comments; expected a header line and rows" if lines.comments else "is empty")
    if (of_objects := _of_objects(file, text, lines, reading)) is not None:
        return of_objects
    if not given.delimiter and is_published(lines.texts):
        return published_table(file, *stamped(lines), replace(reading, decimal="."))
    if not given.delimiter and (one_by_one := _one_by_one(file, lines, replace(reading, decimal="."))):
        return one_by_one
    lines, times = stamped(lines)
    if not given.delimiter and is_keyed(lines.texts):
        return _keyed(file, lines, times, reading)
    ended = text.endswith(("\n", "\r"))
    try:
        return _delimited(file, lines, times, reading, ended=ended)
    except InputError:
        if given.delimiter or not is_sparsely_keyed(lines.texts):
            raise
        return _keyed(file, lines, times, reading)


def _of_objects(file: Path, text: str, lines: Lines, reading: Reading) -> Table | None:
    """A table of JSON: one text, an object a line, or one after the other; None of others."""
    plain = replace(reading, decimal=".", delimiter="")
    whole, may_be_json = None, text.lstrip("\ufeff \t\r\n").startswith(("[", "{"))
    if may_be_json:
        whole = array_table(file, text, plain)
        if whole is not None and (whole.rows > 1 or len(lines.texts) > 1 or not is_json(lines.texts)):
            return whole
        if is_json(lines.texts):
            if whole is None and len(lines.texts) == 1:
                _check_whole(text)
            return json_table(file, lines, plain)
    if _MAY_BE_DOCUMENTS.search(text) and (each := documents.one_a_line(text)) is not None:
        return json_table(file, each, plain)
    if may_be_json and whole is None and _BEGINS_AS_JSON.match(text):
        _check_whole(text)
    return None


def _delimited(file: Path, lines: Lines, times: Sequence[str], reading: Reading, *, ended: bool) -> Table:
    if not reading.delimiter:
        reading = _with_delimiter(reading, lines.texts)
    rows, numbers = split_rows(lines, reading.delimiter)
    if times and len(rows) != len(times):
        raise InputError("quoted line ends in a serial monitor's lines; expected one row a line")
    return table_of_rows(file, rows, numbers, reading=reading, comments=lines.comments, times=times, ended=ended)


def _one_by_one(file: Path, lines: Lines, reading: Reading) -> Table | None:
    """A table of lines that each hold a reading, or the readings of one thing; None of others."""
    if prometheus.is_scraped(lines):
        return tagged_table(file, prometheus.scraped(lines), lines, reading, prometheus.UNTIMED)
    if line_protocol.is_line_protocol(lines):
        return tagged_table(file, line_protocol.points(lines), lines, reading, "")
    if chips.is_of_chips(lines.texts):
        return tagged_table(file, chips.of_chips(lines), lines, reading, chips.UNTIMED)
    _check_frames(lines)
    lines, times = stamped(lines)
    if topics.is_captured(lines):
        return tagged_table(file, topics.captured(lines, times), lines, reading, topics.UNTIMED)
    if rounds.is_rounds(lines.texts):
        return tagged_table(file, rounds.rounds(lines, times), lines, reading, rounds.UNTIMED)
    named = marked.named(lines)
    if named is not None and rounds.is_rounds(named.texts):
        return tagged_table(file, rounds.rounds(named, times), named, reading, marked.UNTIMED)
    return None


def _check_frames(lines: Lines) -> None:
    """Refuse frames of a bus as they are: what is in them only its description tells."""
    sample = lines.texts[:_SAMPLE]
    if sum(1 for line in sample if _FRAME.match(line)) > 0.5 * len(sample):
        raise InputError(
            "holds frames of a bus that are not decoded; expected what is in them: cantools decode FILE.dbc < LOG",
            place=f"line {lines.numbers[0]}",
        )


def _check_whole(text: str) -> None:
    """Refuse what begins as JSON and breaks off, or is broken."""
    try:
        json.loads(text)
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        said = f"begins as JSON and is none from here on ({error.msg})"
        if text[:1] == "[" and len(text) - error.pos < _NEAR_END:
            said += "; does the file end early? expected all of it, or a ] for what follows its last whole object"
        raise InputError(said, place=place) from None
    except RecursionError:
        raise InputError("is JSON of more depth than any log has") from None


def _with_delimiter(reading: Reading, lines: list[str]) -> Reading:
    delimiter, why = guess_delimiter(lines)
    return replace(reading, delimiter=delimiter, why={**reading.why, "delimiter": why})


def _keyed(file: Path, lines: Lines, times: Sequence[str], reading: Reading) -> Table:
    table = keyed_table(file, lines, times, reading)
    return replace(table, reading=_keyed_decimal(table, reading))


def _keyed_decimal(table: Table, reading: Reading) -> Reading:
    if reading.decimal:
        return replace(reading, delimiter="")
    cells = [cell for column in table.columns if isinstance(column.cells, list) for cell in column.cells[:2000]]
    mark, confidence, why = decimal_mark(cells)
    return replace(reading, decimal=mark, unsure="" if confidence >= 0.6 else why, why={**reading.why, "decimal": why})


def shown_delimiter(delimiter: str) -> str:
    """A delimiter in words."""
    return DELIMITERS.get(delimiter, repr(delimiter)) if delimiter else ""
