"""Lines of a name, a number and its unit with bars or tabs between (``ipmitool sensor``): to lines that name it."""

from __future__ import annotations

import re
from dataclasses import replace

from gen.importing.clock import is_time
from gen.importing.reading.lines import Lines
from gen.importing.units import unit_of

_LINE = re.compile(
    r"\s*(?P<called>[A-Za-z][^\t|:=]{0,60}?)\s*(?P<mark>[\t|])\s*(?P<number>[+-]?\d+(?:[.,]\d+)?)\s*(?P<of>[^\t|\d]{0,20}?)"
    r"\s*(?:(?P=mark)\s*(?P<next>[^\t|]*?)\s*(?P<rest>(?P=mark).*)?)?$"
)
_NO_NAME = re.compile(r"[^\w°%µ@ ./()\[\]-]")
_SAMPLE = 400
_LEAST = 0.3
"""Of the lines: what is off says so in words, and what is no number, too."""
_SHORT = {"percent": "%"}
"""Units as lines that name their numbers have them."""
UNTIMED = "print the time before each round: while :; do date +%FT%T; COMMAND; sleep 10; done"
"""How to record with times."""


def named(lines: Lines) -> Lines | None:
    """The lines as ``name: number unit``; None where they are rather a table's.

    Parameters
    ----------
    lines
        A log's.
    """
    sample = [_LINE.match(text) for text in lines.texts[:_SAMPLE]]
    found = [match for match in sample if match]
    behind = [match["next"] or "" for match in found]
    if len(found) < _LEAST * len(sample) or any(is_time(text) or text.replace(".", "", 1).isdigit() for text in behind):
        return None
    return replace(lines, texts=[_named(text) for text in lines.texts])


def _named(text: str) -> str:
    match = _LINE.match(text)
    if not match:
        return text
    unit = unit_of(match["of"]) or unit_of(match["next"] or "")
    said = _SHORT.get(unit.name, unit.name) if unit else ""
    return f"{_NO_NAME.sub('', match['called'])}: {match['number']} {said}".rstrip()
