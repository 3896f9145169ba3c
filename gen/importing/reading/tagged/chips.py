"""What `sensors` (lm-sensors) prints again and again, with a time before each round: to tagged records."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.importing.reading.lines import Lines
from gen.importing.reading.stamps import AROUND, is_stamp
from gen.importing.reading.tagged.tagged_records import Record

_ADAPTER = "Adapter: "
"""What stands below the name of each chip."""
_READING = re.compile(
    r"(?P<label>[^:()]{1,60}):\s+(?P<number>[+-]?\d+(?:\.\d+)?)\s?(?P<of>(?:\W{0,3}[CF]|RPM|mV|V|mW|W|mA|A|%|MHz)(?!\w))"
)
_BROKEN = re.compile(r"^\W{2,3}(?=[CF]$)")
"""A degree sign of another encoding."""
_SAMPLE = 400
_LEAST_CHIPS = 3
UNTIMED = "print the time before each round: while :; do date +%FT%T; sensors; sleep 10; done"
"""How to record with times."""


def is_of_chips(texts: Sequence[str]) -> bool:
    """Whether lines are what `sensors` prints, more than a few times.

    Parameters
    ----------
    texts
        The lines.
    """
    sample = texts[:_SAMPLE]
    adapters = sum(1 for text in sample if text.startswith(_ADAPTER))
    return adapters >= _LEAST_CHIPS and sum(1 for text in sample if _READING.match(text)) >= adapters


def of_chips(lines: Lines) -> tuple[list[Record], list[int], list[int]]:
    """A record for each chip of each round; limits in brackets behind a reading are none.

    Parameters
    ----------
    lines
        For which :func:`is_of_chips`.

    Returns
    -------
    records, places, bad
        And the numbers of lines that are none.
    """
    made: list[Record] = []
    places, bad = [], []
    chip, at = "", ""
    fields: dict[str, str] = {}
    behind = [*lines.texts[1:], ""]
    for text, number, following in zip(lines.texts, lines.numbers, behind, strict=True):
        reading = _READING.match(text)
        if following.startswith(_ADAPTER):
            chip, fields = text.strip(), {}
        elif is_stamp(text):
            at = text.strip(AROUND)
        elif reading:
            if not fields:
                made.append({"fields": fields, "tags": {"chip": chip}} | ({"time": at} if at else {}))
                places.append(number)
            fields[reading["label"].strip()] = f"{reading['number']} {_BROKEN.sub('°', reading['of'])}"
        elif not text.startswith(_ADAPTER) and not text.lstrip().startswith("("):  # limits that are below
            bad.append(number)
    return made, places, bad
