"""Lines that name their numbers: JSON objects, and what sketches print (``T1:23.4 T2:25.1``)."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from gen.errors import InputError
from gen.importing.delimited import MOST_COLUMNS, Lines, keyed_comments
from gen.importing.table import Column, Counted, Reading, Table, unique_names

_PAIR = re.compile(
    r"(?P<key>[A-Za-zÄÖÜäöü°%µ][\w°%µ ./()\[\]-]{0,40}?)\s*[:=]\s*(?P<value>[+-]?\d*[.,]?\d+(?:[eE][+-]?\d+)?|nan|null)"
    r"(?P<unit>\s?(?:°\s?[CFK]|degC|degF|[CFKVA%]|mA|mV|rpm|ms|s)(?=[\s,;|]|$))?",
    re.IGNORECASE,
)
_SAMPLE = 400
_LONGEST = 2000
"""Of a line that names its numbers."""


def is_json(lines: Sequence[str]) -> bool:
    """Whether most lines are JSON objects."""
    sample = lines[:_SAMPLE]
    return bool(sample) and sum(1 for line in sample if line.lstrip().startswith("{")) > 0.5 * len(sample)


def is_keyed(lines: Sequence[str]) -> bool:
    """Whether most lines consist of names with numbers, the same in most."""
    sample = [line[:_LONGEST] for line in lines[:_SAMPLE]]
    found = Counter(tuple(match["key"].strip() for match in _PAIR.finditer(line)) for line in sample)
    found.pop((), None)
    if not found or found.most_common(1)[0][1] < 0.5 * len(sample):
        return False
    left = sorted(len(_PAIR.sub("", line).strip(" ,;|\t")) / len(line) for line in sample)
    return left[len(left) // 2] < 0.3


def json_table(file: Path, lines: Lines, reading: Reading) -> Table:
    """A table of JSON objects, one a line; inner objects become ``outer.inner``.

    Raises
    ------
    InputError
        Without a file name: no line is an object.
    """
    records, numbers, bad = [], [], []
    for text, number in zip(lines.texts, lines.numbers, strict=True):
        try:
            record = json.loads(text.strip().rstrip(","))
            flat = _flat(record) if isinstance(record, dict) else {}
        except (ValueError, RecursionError):
            flat = {}
        if flat:
            records.append(flat)
            numbers.append(number)
        else:
            bad.append(number)
    if not records:
        raise InputError("no line is a JSON object", place=f"line {bad[0] if bad else 1}")
    return _table(file, records, numbers, bad, lines, reading, "line that is no JSON object")


def array_table(file: Path, text: str, reading: Reading) -> Table | None:
    """A table of one JSON text: an array of objects, or an object of arrays; None where it is neither."""
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if isinstance(tree, dict) and tree and all(isinstance(v, list) for v in tree.values()):
        if len({len(v) for v in tree.values()}) != 1:
            return None
        tree = [dict(zip(tree, row, strict=True)) for row in zip(*tree.values(), strict=True)]
    if not isinstance(tree, list) or not tree or not all(isinstance(record, dict) for record in tree):
        return None
    numbers = list(range(1, len(tree) + 1))
    return _table(file, [_flat(record) for record in tree], numbers, [], Lines([], [], []), reading, "", "element")


def keyed_table(file: Path, lines: Lines, times: Sequence[str], reading: Reading) -> Table:
    """A table of lines such as ``T1:23.4 T2:25.1``."""
    records, numbers, bad = [], [], []
    wanted = Counter(
        tuple(match["key"].strip() for match in _PAIR.finditer(line[:_LONGEST])) for line in lines.texts[:_SAMPLE]
    ).most_common(1)[0][0]
    for i, (text, number) in enumerate(zip(lines.texts, lines.numbers, strict=True)):
        found = list(_PAIR.finditer(text)) if len(text) <= _LONGEST else []
        record = {m["key"].strip(): m["value"] + (m["unit"] or "") for m in found}
        if found and set(record) <= set(wanted):
            records.append({"clock": times[i], **record} if times else record)
            numbers.append(number)
        else:
            bad.append(number)
    return _table(file, records, numbers, bad, lines, reading, f"line without {', '.join(wanted)}")


def _flat(record: Mapping[str, object], before: str = "") -> dict[str, str]:
    made: dict[str, str] = {}
    for key, value in record.items():
        if isinstance(value, dict):
            made |= _flat(value, f"{before}{key}.")
        elif isinstance(value, list):
            made |= _flat({str(i): entry for i, entry in enumerate(value, start=1)}, f"{before}{key}.")
        elif isinstance(value, bool):
            made[before + key] = str(int(value))
        else:
            made[before + key] = "" if value is None else repr(value) if isinstance(value, float) else str(value)
    return made


def _table(
    file: Path,
    records: Sequence[Mapping[str, str]],
    numbers: Sequence[int],
    bad: Sequence[int],
    lines: Lines,
    reading: Reading,
    what: str,
    word: str = "line",
) -> Table:
    names = list(dict.fromkeys(key for record in records for key in record))
    if len(names) > MOST_COLUMNS:
        raise InputError(f"found {len(names)} names, expected {MOST_COLUMNS} at most", place=f"{word} {numbers[0]}")
    columns = [
        Column(shown, [record.get(name, "") for record in records])
        for name, shown in zip(names, unique_names(names), strict=True)
    ]
    counted = (Counted(what, len(bad), f"{word} {bad[0]}"),) if bad else ()
    places = np.array(numbers, dtype=np.int64)
    return Table(file, columns, places, word, "", keyed_comments(lines.comments), reading, counted)
