"""InfluxDB's line protocol, which Telegraf writes, too: ``motor,sensor=winding temp=21.5 1772439300000000000``."""

from __future__ import annotations

import re

from gen.importing.reading.lines import Lines
from gen.importing.reading.tagged.tagged_records import Record

_KEY = r"(?:[^\s,=\"\\]|\\.)+"
_FIELD = rf'{_KEY}=(?:"(?:[^"\\]|\\.)*"|[^\s,"]+)'
_LINE = re.compile(
    rf"(?P<whose>{_KEY})(?P<tags>(?:,{_KEY}={_KEY})*) (?P<fields>{_FIELD}(?:,{_FIELD})*)(?: (?P<when>-?\d+))?\s*"
)
_TAG = re.compile(rf"({_KEY})=({_KEY})")
_VALUE = re.compile(rf'({_KEY})=("(?:[^"\\]|\\.)*"|[^\s,"]+)')
_BOOLEAN = {"t": "1", "true": "1", "f": "0", "false": "0"}
_LEAST = 0.8
_SAMPLE = 400
_SINCE_1970 = re.compile(r"\d{10}(?:\d{3}){0,3}")
"""In s, ms, us or ns: no table's last number, and no count of a sketch."""


def is_line_protocol(lines: Lines) -> bool:
    """Whether most lines are of measurement, tags, fields and a time since 1970.

    Parameters
    ----------
    lines
        Of a text.
    """
    sample = lines.texts[:_SAMPLE]
    found = [match for line in sample if (match := _LINE.fullmatch(line))]
    return len(found) >= _LEAST * len(sample) and all(_SINCE_1970.fullmatch(match["when"] or "") for match in found)


def points(lines: Lines) -> tuple[list[Record], list[int], list[int]]:
    """Records of points, in the order of their times: exports come series by series.

    Returns
    -------
    records, places, bad
        And the numbers of lines that are none.
    """
    made: list[tuple[int, Record, int]] = []
    bad: list[int] = []
    for text, number in zip(lines.texts, lines.numbers, strict=True):
        match = _LINE.fullmatch(text)
        if match is None or not match["when"]:
            bad.append(number)
            continue
        fields: dict[str, object] = {_plain(key): _value(value) for key, value in _VALUE.findall(match["fields"])}
        tags = {_plain(key): _plain(value) for key, value in _TAG.findall(match["tags"])}
        point = {"name": _plain(match["whose"]), "fields": fields, "tags": tags, "time": match["when"]}
        made.append((int(match["when"]), point, number))
    made.sort(key=lambda entry: entry[0])
    return [record for _, record, _ in made], [place for _, _, place in made], bad


def _plain(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text)


def _value(text: str) -> str:
    if text.startswith('"'):
        return _plain(text[1:-1])
    if re.fullmatch(r"[+-]?\d+[iu]", text):
        return text[:-1]
    return _BOOLEAN.get(text.casefold(), text)
