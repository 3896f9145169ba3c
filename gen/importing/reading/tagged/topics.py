"""Captures of a broker's messages to tagged records: `mosquitto_sub -v` writes a topic and a payload in each line."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence

from gen.importing.clock import is_time
from gen.importing.guessing.names import TIME
from gen.importing.numbers import parse
from gen.importing.reading.flat import flat
from gen.importing.reading.lines import Lines
from gen.importing.reading.tagged.tagged_records import Record
from gen.importing.reading.tagged.tails import without_shared

_LINE = re.compile(
    r"(?:[\[(]?(?P<time>\d.{0,38}?)[\])]?[\s:,;|]+)??"
    r"(?:[A-Z]{3}: )?"  # of Tasmota's console: `MQT: tele/oven/SENSOR = {..}`
    r"(?P<topic>[A-Za-z_$/][^\s{}\"',;=]*/[^\s{}\"',;=]*?|[A-Za-z_$][^\s{}\"',;=/:]*(?=:? \{))"
    r"(?:\s+[:=]\s+|:?\s+)(?P<said>\S.*)"
)
_EPOCH = re.compile(r"\d{10}(?:\.\d+)?|\d{13}|\d{16}|\d{19}")
_STAMP = re.compile(r"(?P<when>.*\d)Z(?P<zone>[+-]\d{4})")
"""A zone behind another one: local time, as mosquitto before 2.0.15 or so wrote it."""
_LEAST = 0.6
_SAMPLE = 400
_STAMPED = "tst"
UNTIMED = "record with times: mosquitto_sub -F '%U %t %p' -t ..."
"""How to record with times."""


def is_captured(lines: Lines) -> bool:
    """Whether most lines are of a topic with a number or an object, behind a time or not.

    Parameters
    ----------
    lines
        Of a text.
    """
    sample = lines.texts[:_SAMPLE]
    found = [match for line in sample if (match := _LINE.fullmatch(line)) and _measures(match["said"])]
    timed = [match["time"] for match in found if match["time"]]
    return len(found) >= max(1.0, _LEAST * len(sample)) and len(timed) in (0, len(found)) and all(map(_is_time, timed))


def captured(lines: Lines, times: Sequence[str]) -> tuple[list[Record], list[int], list[int]]:
    """Records of messages.

    Parameters
    ----------
    lines
        For which :func:`is_captured`.
    times
        Of each line, where something else told it.

    Returns
    -------
    records, places, bad
        And the numbers of lines that are none.
    """
    messages: list[tuple[str, str, object]] = []
    places, bad = [], []
    for i, (text, number) in enumerate(zip(lines.texts, lines.numbers, strict=True)):
        match = _LINE.fullmatch(text)
        if match is None or (match["time"] and not _is_time(match["time"])):
            bad.append(number)
            continue
        messages.append((times[i] if times else _stamp(match["time"] or ""), match["topic"], _said(match["said"])))
        places.append(number)
    return _records(messages), places, bad


def is_messages(records: Sequence[object]) -> bool:
    """Whether records are messages as `mosquitto_sub -F %j` writes them, or others with topics and objects.

    Parameters
    ----------
    records
        Of a JSON text.
    """
    plain = [e for e in records if isinstance(e, dict) and isinstance(e.get("topic"), str) and "payload" in e]
    if not plain or len(plain) < len(records):
        return False
    return all(_STAMPED in e for e in plain) or any(isinstance(_said(e["payload"]), dict) for e in plain)


def messages(records: Sequence[Mapping[str, object]]) -> list[Record]:
    """Tagged records of messages.

    Parameters
    ----------
    records
        For which :func:`is_messages`.
    """
    found = []
    for record in records:
        others = {key: value for key, value in record.items() if key not in ("topic", "payload")}
        at = next((value for key, value in others.items() if key == _STAMPED or TIME.fullmatch(key.casefold())), "")
        stamp = _stamp(at) if isinstance(at, str) else repr(at)
        found.append((stamp, str(record["topic"]), _said(record["payload"])))
    return _records(found)


def _records(found: Sequence[tuple[str, str, object]]) -> list[Record]:
    """By the names of what topics say; a message that tells its own time is of that where nothing else tells it."""
    topics = {topic: "" for _, topic, _ in found}
    if len(topics) > 1 or not all(isinstance(said, dict) for _, _, said in found):
        topics = without_shared(list(topics), "/")
    records: list[Record] = []
    for at, topic, said in found:
        fields = flat(said) if isinstance(said, dict) else {"": str(said)}
        if not at:
            key = next((key for key, text in fields.items() if TIME.fullmatch(key.casefold()) and _is_time(text)), None)
            at = fields.pop(key) if key is not None else ""
        named = {f"{topics[topic]}.{key}".strip("."): value for key, value in fields.items()}
        records.append({"fields": named, "tags": {}} | ({"time": at} if at else {}))
    return records


def _said(payload: object) -> object:
    """What a message says: an object, or a text."""
    if isinstance(payload, str) and payload.lstrip()[:1] == "{":
        try:
            tree = json.loads(payload)
        except (ValueError, RecursionError):
            return payload
        return tree if isinstance(tree, dict) else payload
    return payload if isinstance(payload, (str, dict)) else json.dumps(payload)


def _measures(said: str) -> bool:
    return isinstance(_said(said), dict) or bool(parse([said]).numeric)


def _is_time(text: str) -> bool:
    return bool(_EPOCH.fullmatch(text.strip())) or is_time(_stamp(text))


def _stamp(text: str) -> str:
    twice = _STAMP.fullmatch(text.strip())
    return f"{twice['when']}{twice['zone']}" if twice else text.strip()
