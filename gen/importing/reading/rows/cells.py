"""A text parted into lines, and lines into cells."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence

from gen.errors import InputError
from gen.importing.numbers import plain_number
from gen.importing.reading.lines import Lines
from gen.importing.reading.logged import is_logged, logged
from gen.importing.reading.rows.kinds import is_number

DELIMITERS = {";": "semicolon", "\t": "tab", "|": "pipe", ",": "comma", " ": "white space"}
_COMMENT = re.compile(r"\s*(?:#|%(?![,;|\t])|//|\*\*|--\s)")  # a unit of a row of units may be `%`
_STAMPED = re.compile(r"\s*(\d{1,2}:\d{2}:\d{2}(?:[.,]\d+)?)\s*->\s?(.*)")
_SAMPLE = 400
_LEAST_CONSISTENT = 0.8
_LEAST_OF_A_WIDTH = 0.1
_MOST_LOST = 0.5
_HEAD_LINES = 20


def lines_of(text: str) -> Lines:
    """Part a text into lines; comments and empty lines are set apart."""
    texts, numbers, comments = [], [], []
    for number, line in enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), start=1):
        if not line.strip():
            continue
        if line[0] in "#%/*- \t" and (mark := _COMMENT.match(line)):
            comments.append(line[mark.end() :].strip())
            continue
        texts.append(line)
        numbers.append(number)
    return Lines(texts, numbers, comments)


def stamped(lines: Lines) -> tuple[Lines, list[str]]:
    """Part the time from lines of a serial monitor (``13:45:10.123 -> 23.5,102``) or of a system's log.

    Returns
    -------
    lines, times
        No times where most lines have none; then the lines are those given.
    """
    sample = lines.texts[:_SAMPLE]
    if is_logged(sample):
        return logged(lines)
    if sum(1 for line in sample if _STAMPED.match(line)) <= 0.5 * len(sample):
        return lines, []
    texts, numbers, times = [], [], []
    for line, number in zip(lines.texts, lines.numbers, strict=True):
        found = _STAMPED.match(line)
        texts.append(found[2] if found else line)
        times.append(found[1] if found else "")
        numbers.append(number)
    return Lines(texts, numbers, lines.comments), times


def guess_delimiter(lines: Sequence[str]) -> tuple[str, str]:
    """The delimiter, and why; a comma last of all marks, for it may be a decimal's.

    Raises
    ------
    InputError
        Without a file name: no mark parts the lines into columns.
    """
    middle = max(0, len(lines) // 2 - _SAMPLE // 2)
    head = min(_SAMPLE // 4, middle)
    sample = [*lines[:head], *lines[middle : middle + _SAMPLE]]
    for delimiter, name in DELIMITERS.items():
        fields = Counter(_fields(line, delimiter) for line in sample)
        width = max((w for w in fields if w > 1), key=lambda w: fields[w], default=1)
        if width > 1 and fields[width] >= _LEAST_CONSISTENT * len(sample):
            return delimiter, f"{name}: {width} columns in {fields[width]} of {len(sample)} lines looked at"
    best = Counter(
        (delimiter, _fields(line, delimiter))
        for delimiter in DELIMITERS
        for line in sample
        if _fields(line, delimiter) > 1 and _numbers(line, delimiter)
    ).most_common(1)
    if best and best[0][1] >= _MOST_LOST * len(sample):
        (delimiter, width), number = best[0]
        return delimiter, f"{DELIMITERS[delimiter]}: {width} columns in {number} of {len(sample)} lines looked at"
    for delimiter, name in DELIMITERS.items():  # a later header may have other columns
        fields = Counter(_fields(line, delimiter) for line in sample if _numbers(line, delimiter))
        widths = [w for w in fields if w > 1 and fields[w] >= _LEAST_OF_A_WIDTH * len(sample)]
        if sum(fields[w] for w in widths) >= _LEAST_CONSISTENT * len(sample):
            shown = " or ".join(map(str, sorted(widths)))
            return delimiter, f"{name}: {shown} columns in most of {len(sample)} lines looked at"
    raise InputError(
        "no delimiter parts its lines into the same number of columns (tried comma, semicolon, tab, pipe, spaces); "
        "expected a table",
        place="line 1",
    )


def _fields(line: str, delimiter: str) -> int:
    if delimiter == " ":
        return len(line.split())
    if '"' in line:
        line = re.sub(r'"[^"]*"', "", line)
    return line.count(delimiter) + 1


def _numbers(line: str, delimiter: str) -> bool:
    return any(plain_number(cell.strip(), ",") is not None for cell in line.split(delimiter))


def split_rows(lines: Lines, delimiter: str, word: str = "line") -> tuple[list[list[str]], list[int]]:
    """Part lines into cells, quotes taken off; a quoted cell may hold line ends.

    Raises
    ------
    InputError
        Without a file name, with the line of a field that is too large to be one.
    """
    if delimiter == " " and not any('"' in line for line in lines.texts[:_SAMPLE]):
        return [line.split() for line in lines.texts], lines.numbers
    if delimiter == " ":
        lines = Lines([" ".join(line.split()) for line in lines.texts], lines.numbers, lines.comments)
    reader = csv.reader(_closed(lines.texts), delimiter=delimiter, skipinitialspace=True)
    rows: list[list[str]] = []
    numbers: list[int] = []
    before = 0
    try:
        for row in reader:
            rows.append(row)
            numbers.append(lines.numbers[before])
            before = reader.line_num
    except csv.Error as error:
        raise InputError(
            f"{error}; expected rows of numbers", place=f"{word} {lines.numbers[min(before, len(lines.numbers) - 1)]}"
        ) from None
    return rows, numbers


def _closed(texts: list[str]) -> list[str]:
    """A quote that noise put into a line must not swallow the lines behind it; a header may hold line ends."""
    odd = [i for i, line in enumerate(texts) if line.count('"') % 2 and i >= _HEAD_LINES]
    if odd:
        texts = list(texts)
        for i in odd:
            texts[i] = texts[i].replace('"', "")
    return texts


def without_colons(cells: list[str]) -> list[str]:
    """A first column without the mark behind each of its times: `1714684205: 21.4`, as rrdtool writes.

    Parameters
    ----------
    cells
        Of the column.
    """
    return [cell[:-1] for cell in cells] if all(cell[-1:] == ":" and is_number(cell[:-1]) for cell in cells) else cells
