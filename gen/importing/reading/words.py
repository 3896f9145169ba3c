"""Words that a line names among its numbers: ``mode=HEAT pwm=153``, ``T: 21.5 dir: FWD pwm: 0``."""

from __future__ import annotations

import re
from collections.abc import Callable

_DAY = r"\d{4}[-/.]\d{2}[-/.]\d{2}"
_CLOCK = r"\d{1,2}:\d{2}:\d{2}(?:[.,]\d{1,9})?"
_WORD = re.compile(
    r"(?<![\w./-])(?P<key>[A-Za-z_][\w./-]*)\s?(?P<mark>[:=])\s?(?!(?:nan|null)\b)"
    rf"(?P<word>\"[^\"]*\"|[A-Za-z_][\w./+-]*|0x[0-9A-F]+|{_DAY}(?:T{_CLOCK}\S*)?|{_CLOCK})(?=[\s,;|]|$)(?!\s*[:=])",
    re.IGNORECASE,
)
_OF_WHAT = re.compile(r"\s+(?:temp|temperature|value|val)\s*[:=]", re.IGNORECASE)
"""A name behind a word that says little without it."""
_NAMING = {
    "name",
    "sensor",
    "channel",
    "ch",
    "probe",
    "part",
    "id",
    "loc",
    "location",
    "device",
    "signal",
    "tag",
    "zone",
}
"""Keys whose word says of what the number behind it is: `sensor=casing temp=41.2`."""
_TAKEN = "|"
"""Stands where a word was: no name goes over it."""
_ELSE = re.compile(r"[^\s,;|]")


def parted(body: str, without_numbers: Callable[[str], str]) -> tuple[dict[str, str], str]:
    """The words of a line by their names, and the line without them.

    Parameters
    ----------
    body
        A line without the time before it.
    without_numbers
        Takes numbers with their names out of a line. A colon may also stand behind what a section, or a whole line, is
        of; it names a word only in a line of nothing but names with words and numbers.

    Returns
    -------
    words, rest
        The rest is as long as the line was.
    """
    if not _WORD.search(body):
        return {}, body
    words, rest = _taken(body, ":=")
    if _ELSE.search(without_numbers(rest)):
        words, rest = _taken(body, "=")
    return words, rest


def _taken(body: str, marks: str) -> tuple[dict[str, str], str]:
    words: dict[str, str] = {}
    rest = body
    for match in _WORD.finditer(body):
        says_of_what = match["mark"] == ":" or match["key"].casefold() in _NAMING
        if match["mark"] not in marks or (says_of_what and _OF_WHAT.match(body, match.end())):
            continue
        words.setdefault(match["key"], match["word"].strip('"'))
        rest = rest[: match.start()] + _TAKEN * len(match[0]) + rest[match.end() :]
    return words, rest
