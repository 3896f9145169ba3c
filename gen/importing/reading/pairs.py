"""What a line of a sketch, a daemon or a printer names: a time before it, then names with numbers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

from gen.importing.reading.rows.delimited import MOST_COLUMNS
from gen.importing.reading.words import parted

_NUMBER = r"[+-]?\d*[.,]?\d+(?:[eE][+-]?\d+)?"
_PAIR = re.compile(
    r"(?P<key>[A-Za-zÄÖÜäöü°%µ@][\w°%µ@ ./()\[\]-]{0,40}?)\s*[:=]\s*(?P<value>" + _NUMBER + r"|nan|null)"
    r"(?P<unit>\s?(?:[°'*º]\s?[CFK]|degC|degF|[CFKVA%]|mA|mV|rpm|[muµμ]?s|min|h|[mk]?W)(?=[\s,;|]|$))?"
    r"(?:\s?/\s?(?P<target>" + _NUMBER + r")(?=[\s,;|]|$))?",
    re.IGNORECASE,
)
_DAY = r"(?:\d{4}[-/.]\d{2}[-/.]\d{2}|\d{1,2}[-/.]\d{1,2}[-/.]\d{4})"
_CLOCK = r"\d{1,2}:\d{2}:\d{2}(?:[.,]\d{1,9})?"
_HEADS = (
    (
        "timestamp",
        re.compile(rf"[\[(]?(?P<stamp>{_DAY}[T ,]\s?{_CLOCK}(?:Z|[+-]\d{{2}}:?\d{{2}})?)[\])]?(?=[\s,;:|>-])"),
    ),
    ("epoch", re.compile(r"^\s*\((?P<stamp>\d{9,10}\.\d{3,9})\)(?=\s)")),
    ("millis", re.compile(r"^\s*(?:\x1b\[[0-9;]*m)?[EWIDV] \((?P<stamp>\d+)\) [\w.-]{1,40}:(?=\s)")),
    ("millis", re.compile(r"^\s*[\[(]?\s*(?P<stamp>\d+) ?ms[\])]?(?=[\s,;:|>-])")),
    ("seconds", re.compile(r"^\s*\[\s*(?P<stamp>\d+\.\d{1,9})\](?=\s)")),
    (
        "clock",
        re.compile(
            rf"^\s*(?:[A-Z][a-z]{{2}} [ \d]\d )?[\[(]?(?P<stamp>{_CLOCK})(?:,\d{{3}}(?=\]))?[\])]?(?=[\s,;:|>-])"
        ),
    ),
)
"""The time that a logger, a daemon, a terminal or a firmware puts before a line."""
HEADS = {"clock", *(name for name, _ in _HEADS)}
"""What the times before lines are called."""
_COUNT = re.compile(r"^\s*(?P<key>[A-Za-z]+) (?P<value>\d+(?:\.\d+)?):\s")
"""A line's own number: `Stats 420126.9: ..`."""
_ROW = re.compile(r"^\s*(?P<stamp>\d+(?:\.\d+)?)[\s,;|]+(?=[A-Za-z])")
"""A number without a name before the others, as a sketch's `millis()`; what it is, it has to show."""
_FRAME = re.compile(r"\s*\w+\s+[0-9A-F]+\s+\[\d+\]\s+(?:[0-9A-F]{2}\s+)*::\s+\w+\(", re.IGNORECASE)
"""What stands before a decoded frame of a bus: `can0  123   [2]  01 02 :: Motor(`."""
_SECTION = re.compile(r"(?P<of>[A-Za-z_]\w*)\s*:\s+$")
"""Of what the numbers behind it are: `extruder: target=200 temp=199.8`."""
_SAID = re.compile(r"^(?:ok|recv|rx|info|debug|data|out)\s+", re.IGNORECASE)
SAMPLE = 400
LONGEST = 2000
"""Of a line that names its numbers."""
_LEAST_ALIKE = 0.5
_LEAST_BETWEEN = 0.25
"""Of the lines, where others stand between them that are no rows: commands, answers."""
_LEAST_KIND = 0.05
"""Of the lines, for another kind of them to be readings, too; or the only one of a file that is no table."""
_MOST_LEFT = 0.3
"""Of a line that names its numbers, beside them."""
_MOST_PLAIN = 0.05
_PLAIN = re.compile(r"\s*[+-]?\d[\d.,eE+-]*\s*[,;\t| ]\s*[+-]?\d")
"""A line that begins as a row of a table does."""
_SECTION_MARK = re.compile(r"[A-Za-z_]\w*\s*:\s+(?=[A-Za-z_])")
_LONGEST_HEAD = 120


def sampled(lines: Sequence[str]) -> list[str]:
    """Give some of all lines, cut where they are too long, evenly spread, and out of step with rounds of them.

    Parameters
    ----------
    lines
        A log's.
    """
    step = max(1, len(lines) // SAMPLE)
    return [lines[k * step + k % step][:LONGEST] for k in range(len(lines) // step)]


def is_keyed(lines: Sequence[str]) -> bool:
    """Whether most lines consist of names with numbers, the same in most; or many, and the others hold no rows."""
    sample = sampled(lines)
    found = Counter(names_in(line) for line in sample)
    found.pop((), None)
    if not found:
        return False
    names, count = found.most_common(1)[0]
    if count < _LEAST_BETWEEN * len(sample):
        return False
    count = max(count, sum(found[kind] for kind in kinds_of(sample)))
    if count < _LEAST_ALIKE * len(sample):
        plain = sum(1 for line in sample if _PLAIN.match(_headed(line)[1]))
        if len(names) < 2 or plain > _MOST_PLAIN * len(sample):
            return False
    alike = [line for line in sample if names_in(line) == names]
    left = sorted(share_left(line) for line in alike)
    return left[len(left) // 2] < _MOST_LEFT


def is_sparsely_keyed(lines: Sequence[str]) -> bool:
    """Whether a few lines name numbers, the same in each, among many others: a printer's answers to its host.

    Parameters
    ----------
    lines
        A log's, which are no table's rows.
    """
    sample = sampled(lines)
    found = Counter(names for line in sample if (names := names_in(line)))
    if not found:
        return False
    names, count = found.most_common(1)[0]
    left = sorted(share_left(line) for line in sample if names_in(line) == names)
    return len(names) > 1 and count >= _LEAST_KIND * len(sample) and left[len(left) // 2] < _MOST_LEFT


def share_left(line: str) -> float:
    """Which share of a line, without its time, is no number with a name.

    Parameters
    ----------
    line
        The line.
    """
    body = _headed(line)[1]
    left = _without_numbers(_SECTION_MARK.sub("", parted(body, _without_numbers)[1]))
    return len(left.replace("|", "").strip(" ,;\t")) / max(len(body), 1)


def _without_numbers(body: str) -> str:
    return _PAIR.sub("", body)


def _headed(line: str) -> tuple[dict[str, str], str]:
    """The time before a line's numbers, and the line without it."""
    for name, pattern in _HEADS:
        match = pattern.search(line[:_LONGEST_HEAD])
        if match and not _PAIR.search(line[: match.start()].replace(":", " ")):
            body = line[match.end() :]
            frame = _FRAME.match(body)
            return {name: match["stamp"]}, body[frame.end() :].rstrip().removesuffix(")") if frame else body
    counted = _COUNT.match(line)
    if counted:
        return {counted["key"]: counted["value"]}, line[counted.end() :]
    first = _ROW.match(line)
    return ({"": first["stamp"]}, line[first.end() :]) if first and _PAIR.match(line, first.end()) else ({}, line)


@dataclass(frozen=True)
class _Pair:
    section: str
    key: str
    value: str


def _pairs(body: str) -> list[_Pair]:
    """The numbers that a line names, with what stands before them in the way of `extruder: `."""
    found, section, end = [], "", 0
    body = parted(body, _without_numbers)[1]
    for match in _PAIR.finditer(body):
        named = _SECTION.search(body[end : match.start()])
        section, end = named["of"] if named else section, match.end()
        key = _SAID.sub("", match["key"].strip().rpartition(" - ")[2])
        found.append(_Pair(section, key, match["value"] + (match["unit"] or "")))
        if match["target"]:
            found.append(_Pair(section, f"{key} target", match["target"]))
    return found


def names_in(line: str) -> tuple[str, ...]:
    """The names of a line's numbers, in order."""
    return tuple(pair.key for pair in _pairs(_headed(line)[1]))


def words_in(line: str) -> dict[str, str]:
    """A line's words by their names.

    Parameters
    ----------
    line
        The line.
    """
    return parted(_headed(line)[1], _without_numbers)[0]


def is_timed(line: str) -> bool:
    """Whether a line tells its time before its numbers."""
    return bool(_headed(line)[0])


def kinds_of(lines: Sequence[str], *, timed: bool = False) -> list[tuple[str, ...]]:
    """The sets of names that lines come with, the commonest first; others only where lines tell their times.

    Parameters
    ----------
    lines
        Some of a log's, at least one of which names numbers.
    timed
        Whether all had a time before them, which is no longer there.
    """
    found = Counter(names for line in lines if (names := names_in(line[:LONGEST])))
    common = found.most_common()
    first = common[0][0]
    if not (timed or all(is_timed(line) for line in lines if names_in(line[:LONGEST]) == first)):
        return [first]
    kinds = [first]
    for names, count in common[1:]:
        apart = not any(set(names) & set(kind) for kind in kinds)
        told = timed or all(is_timed(line) for line in lines if names_in(line[:LONGEST]) == names)
        if apart and told and count >= _LEAST_KIND * len(lines):
            kinds.append(names)
    return kinds


def record_of(line: str, twice: frozenset[str]) -> dict[str, str]:
    """A line's time and numbers by their names.

    Parameters
    ----------
    line
        The line.
    twice
        Names that a line has more than once: they get what they are of before them (``extruder.temp``), else a number.
    """
    head, body = _headed(line)
    made = dict(head)
    for pair in _pairs(body):
        name = f"{pair.section}.{pair.key}" if pair.key in twice and pair.section else pair.key
        again = (f"{name}_{i}" for i in range(2, MOST_COLUMNS))
        made[next(n for n in chain((name,), again) if n not in made)] = pair.value
    return made
