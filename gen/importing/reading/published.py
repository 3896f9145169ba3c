"""Lines in which a controller says what it publishes: ``'Casing': Sending state 41.20000 °C with 1 decimals``.

ESPHome's, whose later versions write ``'Casing' >> 41.2 °C``. Each line has one reading; a row is what is published
within one time, as the log has it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gen.errors import InputError
from gen.importing.reading.lines import Lines
from gen.importing.reading.rows.delimited import MOST_COLUMNS, keyed_comments
from gen.importing.table import Column, Counted, Reading, Table, unique_names

_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_TIME = re.compile(
    r"^\s*[\[(]?(?P<stamp>(?:\d{4}-\d{2}-\d{2}[T ])?\d{1,2}:\d{2}:\d{2}(?:[.,]\d{1,9})?)[\])]?(?=[\s\[|])"
)
_STATE = re.compile(
    r"'(?P<entity>[^']{1,80})'(?:: Sending state| >>) '?(?P<reading>[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|nan|ON|OFF)'?"
    r"(?: (?!with )(?P<measure>\S+))?"
)
_LEAST, _LEAST_SHARE = 3, 0.05
"""Of the lines, for a log to be one of published states: most of it may be about anything else."""
_SWITCH = {"ON": "1", "OFF": "0"}


@dataclass(frozen=True)
class _State:
    stamp: str
    name: str
    value: str
    unit: str


def is_published(lines: Sequence[str]) -> bool:
    """Whether a log says what is published, among all else that it may say."""
    found = sum(1 for line in lines if _STATE.search(line))
    return found >= max(_LEAST, _LEAST_SHARE * len(lines))


def published_table(file: Path, lines: Lines, times: Sequence[str], reading: Reading) -> Table:
    """A table of what is published: a column for each name, a row for each time.

    Parameters
    ----------
    file
        Its name.
    lines
        The log's.
    times
        Of the lines, where something before them told it; else they are in the lines.
    reading
        How the file was read.

    Raises
    ------
    InputError
        Without a file name: lines have no time, or there are too many names.
    """
    states = [_state(text, times[i] if times else "") for i, text in enumerate(lines.texts)]
    names = list(dict.fromkeys(state.name for state in states if state))
    if len(names) > MOST_COLUMNS:
        raise InputError(f"found {len(names)} names, expected {MOST_COLUMNS} at most", place=f"line {lines.numbers[0]}")
    rows: list[dict[str, str]] = []
    stamps: list[str] = []
    numbers: list[int] = []
    units = dict.fromkeys(names, "")
    for state, number in zip(states, lines.numbers, strict=True):
        if state is None:
            continue
        if not state.stamp:
            raise InputError(
                "the line has no time; expected one before each, as `esphome logs` writes it", place=f"line {number}"
            )
        if not stamps or stamps[-1] != state.stamp or state.name in rows[-1]:
            rows.append({})
            stamps.append(state.stamp)
            numbers.append(number)
        rows[-1][state.name] = state.value
        units[state.name] = units[state.name] or state.unit
    columns = [Column("clock", stamps)]
    for name, shown in zip(names, unique_names(names), strict=True):
        columns.append(Column(shown, [row.get(name, "") for row in rows], units[name]))
    other = [number for state, number in zip(states, lines.numbers, strict=True) if state is None]
    counted = (Counted("line that publishes nothing", len(other), f"line {other[0]}"),) if other else ()
    places = np.array(numbers, dtype=np.int64)
    return Table(file, columns, places, "line", "", keyed_comments(lines.comments), reading, counted)


def _state(line: str, stamp: str) -> _State | None:
    """What a line publishes."""
    plain = _COLOUR.sub("", line)
    found = _STATE.search(plain)
    if found is None:
        return None
    timed = _TIME.search(plain)
    value = found["reading"]
    return _State(
        timed["stamp"] if timed else stamp, found["entity"], _SWITCH.get(value, value), found["measure"] or ""
    )
