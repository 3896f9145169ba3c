"""Lines that name their numbers: JSON objects, and what sketches print (``T1:23.4 T2:25.1``), to tables."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from gen.errors import InputError
from gen.importing.listing import listed
from gen.importing.reading.entries import entries_of
from gen.importing.reading.flat import flat
from gen.importing.reading.lines import Lines
from gen.importing.reading.pairs import HEADS, LONGEST, SAMPLE, kinds_of, names_in, record_of, sampled, words_in
from gen.importing.reading.rows.delimited import MOST_COLUMNS, keyed_comments
from gen.importing.reading.tagged import signals
from gen.importing.reading.tagged.prometheus import answered
from gen.importing.reading.tagged.senml import is_senml, resolved
from gen.importing.reading.tagged.tagged_records import Record, is_tagged, of_one_time
from gen.importing.reading.tagged.topics import is_messages, messages
from gen.importing.reading.told_units import units_within, with_told_units
from gen.importing.table import Column, Counted, Reading, Table, unique_names

_ROWS = ("values", "data", "rows")
RECURRING = 0.25
"""Columns for each record, beside those of one, from which on names in lists are numbers of messages, and none."""
_OBJECTS = re.compile(r"\s*(?:\[\s*)?\{")
_SHOWN = 8
"""Names that a message says."""


def is_json(lines: Sequence[str]) -> bool:
    """Whether most lines are JSON objects, or arrays of them."""
    sample = lines[:SAMPLE]
    return bool(sample) and sum(1 for line in sample if _OBJECTS.match(line)) > 0.5 * len(sample)


def json_table(file: Path, lines: Lines, reading: Reading) -> Table:
    """A table of JSON objects, one a line; inner objects become ``outer.inner``.

    Raises
    ------
    InputError
        Without a file name: no line is an object.
    """
    records: list[Record] = []
    named: list[dict[str, str]] = []
    numbers, bad, packs = [], [], []
    special = False
    for text, number in zip(lines.texts, lines.numbers, strict=True):
        found = _objects(text)
        if len(found) > 1 and is_senml([record for record, _ in found]):
            packs.append([record for record, _ in found])
        special = (
            special or bool(packs) or (len(named) < SAMPLE and any(_may_be_special(record) for record, _ in found))
        )
        for record, texts in found:
            if special or len(named) < SAMPLE:  # whole objects take more memory than all else
                records.append(record)
            named.append(with_told_units(texts))
            numbers.append(number)
        if not found:
            bad.append(number)
    if not records:
        raise InputError("no line is a JSON object", place=f"line {bad[0] if bad else 1}")
    said = "line that is no JSON object"
    if special and (tagged := _tagged(records, numbers, packs)) is not None:
        return _one_by_one(file, *tagged, bad, lines, reading, said)
    return _table(file, _recurring(named, records) if special else named, numbers, bad, lines, reading, said)


def _objects(line: str) -> list[tuple[dict[str, object], dict[str, str]]]:
    """The objects of a line, whole and flat: one, or those of an array; none where it is no JSON."""
    try:
        tree = json.loads(line.strip().rstrip(","))
        entries = tree if isinstance(tree, list) else [tree]
        found = [(entry, flat(entry)) for entry in entries if isinstance(entry, dict)]
    except (ValueError, RecursionError):
        return []
    return [(entry, texts) for entry, texts in found if texts]


def _may_be_special(record: Record) -> bool:
    """Whether a record may be of fields and tags, or a broker's message, or holds lists whose entries have names."""
    if "fields" in record or "payload" in record:
        return True
    return any(isinstance(v, list) or (isinstance(v, dict) and _may_be_special(v)) for v in record.values())


def array_table(file: Path, text: str, reading: Reading) -> Table | None:
    """A table of one JSON text: an array of objects, or an object of arrays; None where it is neither.

    Either may lie within objects that say what was measured.

    Raises
    ------
    InputError
        Without a file name: there are several of them, and nobody knows which is the log.
    """
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError):
        return None
    samples = answered(tree) or signals.records_of(tree)
    if samples:
        return _one_by_one(
            file, samples, list(range(1, len(samples) + 1)), [], Lines([], [], []), reading, "", "element"
        )
    tree = _joined(entries_of(tree))
    units = units_within(tree)
    if isinstance(tree, dict) and len(tree) > 1 and all(isinstance(v, list) and len(v) > 1 for v in tree.values()):
        lengths = {len(values) for values in tree.values()}
        if len(lengths) == 1:
            tree = [dict(zip(tree, row, strict=True)) for row in zip(*tree.values(), strict=True)]
    if not isinstance(tree, list) or not tree or not all(isinstance(record, dict) for record in tree):
        within = dict(_within(tree))
        if len(within) > 1:
            raise InputError(f"holds several tables ({listed(within)}); expected one")
        if not within:
            return None
        tree = next(iter(within.values()))
    numbers = list(range(1, len(tree) + 1))
    tagged = _tagged(tree, numbers, [tree] if is_senml(tree) else [])
    if tagged is not None:
        return _one_by_one(file, *tagged, [], Lines([], [], []), reading, "", "element")
    records = _recurring([flat(record) for record in tree], tree)
    return _table(
        file,
        [with_told_units(units | record) for record in records],
        numbers,
        [],
        Lines([], [], []),
        reading,
        "",
        "element",
    )


def tagged_table(
    file: Path,
    found: tuple[Sequence[Record], Sequence[int], Sequence[int]],
    lines: Lines,
    reading: Reading,
    untimed: str,
) -> Table:
    """A table of readings that come one by one, with a row for each time.

    Parameters
    ----------
    file
        Its name.
    found
        Tagged records, the line of each, and the lines that are none.
    lines
        The text's.
    reading
        How the file was read.
    untimed
        How to record with times, where these tell none.
    """
    table = _one_by_one(file, *found, lines, reading, "line that is no reading")
    return replace(table, untimed="" if any(record.get("time") for record in found[0]) else untimed)


def _tagged(
    records: Sequence[Record], numbers: Sequence[int], packs: Sequence[Sequence[Record]]
) -> tuple[Sequence[Record], Sequence[int]] | None:
    """Tagged records of records that are such, or are messages of a broker, or of SenML; None of others."""
    if packs and sum(map(len, packs)) == len(records):
        found = resolved(packs)
        return found, range(1, len(found) + 1)
    if is_messages(records):
        return messages(records), numbers
    return (records, numbers) if is_tagged(records) else None


def _one_by_one(
    file: Path,
    records: Sequence[Record],
    numbers: Sequence[int],
    bad: Sequence[int],
    lines: Lines,
    reading: Reading,
    what: str,
    word: str = "line",
) -> Table:
    rows, places = of_one_time(records, numbers)
    return _table(file, [with_told_units(flat(row)) for row in rows], places, bad, lines, reading, what, word)


def _joined(tree: object) -> object:
    """One array of an array of arrays of objects; what only the first of one says (Home Assistant's) holds for all."""
    parts = tree if isinstance(tree, list) else []
    if not parts or not all(isinstance(part, list) and all(isinstance(e, dict) for e in part) for part in parts):
        return tree
    made: list[dict[str, object]] = []
    for first, *others in filter(None, parts):
        once = {key: value for key, value in first.items() if not any(key in other for other in others)}
        made += [first, *(once | other for other in others)]
    return made


def _within(tree: object, path: str = "$") -> Iterator[tuple[str, list[dict[str, object]]]]:
    """Tables within a JSON text, by where they are: arrays of objects, objects of arrays, rows below names."""
    if isinstance(tree, list):
        objects = [entry for entry in tree if isinstance(entry, dict)]
        if len(objects) > 1 and len(objects) == len(tree):
            yield path, objects
        elif len(tree) == 1:
            yield from _within(tree[0], f"{path}[0]")
    elif isinstance(tree, dict):
        records = _of_columns(tree)
        if records:
            yield path, records
            return
        beside = {key: value for key, value in tree.items() if isinstance(value, list) and _plain(value)}
        for key, value in tree.items():
            for at, found in _within(value, f"{path}.{key}"):
                yield at, _with_arrays(found, beside)


def _with_arrays(records: list[dict[str, object]], beside: Mapping[str, list[object]]) -> list[dict[str, object]]:
    """Records with what arrays of as many values beside their table say of each: its times."""
    whole = {key: values for key, values in beside.items() if len(values) == len(records) > 1}
    if not whole:
        return records
    rows = zip(*whole.values(), strict=True)
    return [{**dict(zip(whole, row, strict=True)), **own} for row, own in zip(rows, records, strict=True)]


def _of_columns(tree: Mapping[str, object]) -> list[dict[str, object]]:
    """Records of an object that holds arrays of one length, or names and rows; none where it does not."""
    names, rows = (next((tree[key] for key in keys if key in tree), None) for keys in (("columns",), _ROWS))
    if isinstance(names, list) and isinstance(rows, list) and rows and all(isinstance(name, str) for name in names):
        if all(isinstance(row, list) and len(row) == len(names) for row in rows):
            return [dict(zip(names, row, strict=True)) for row in rows]
        return []
    arrays = {key: value for key, value in tree.items() if isinstance(value, list) and len(value) > 1 and _plain(value)}
    if len(arrays) < 2 or len({len(value) for value in arrays.values()}) != 1:
        return []
    return [dict(zip(arrays, row, strict=True)) for row in zip(*arrays.values(), strict=True)]


def _plain(values: Sequence[object]) -> bool:
    return not any(isinstance(value, (dict, list)) for value in values)


def keyed_table(file: Path, lines: Lines, times: Sequence[str], reading: Reading) -> Table:
    """A table of lines such as ``T1:23.4 T2:25.1``; of several kinds of lines, each fills its own columns."""
    records: list[dict[str, str]] = []
    numbers, bad = [], []
    kinds = kinds_of(sampled(lines.texts), timed=bool(times))
    twice = frozenset(key for kind in kinds for key, count in Counter(kind).items() if count > 1)
    firsts = [next(line for line in lines.texts if names_in(line[:LONGEST]) == kind) for kind in kinds]
    wanted = [set(record_of(line, twice)) for line in firsts]
    for i, (text, number) in enumerate(zip(lines.texts, lines.numbers, strict=True)):
        record = record_of(text, twice) if len(text) <= LONGEST else {}
        if any(2 * len(set(record) & kind) >= len(kind) and set(record) <= kind for kind in wanted):
            words = words_in(text)
            told = with_told_units({"clock": times[i], **words, **record} if times else words | record)
            if len(wanted) > 1 and records and _of_one_time(records[-1], told, words):
                records[-1] |= told
                continue
            records.append(told)
            numbers.append(number)
        else:
            bad.append(number)
    names = list(dict.fromkeys(name for line in firsts for name in record_of(line, twice)))
    shown = ", ".join(names[:_SHOWN]) + (" .." if len(names) > _SHOWN else "")
    return _table(file, records, numbers, bad, lines, reading, f"line without {shown}")


def _of_one_time(before: Mapping[str, str], record: Mapping[str, str], words: Mapping[str, str]) -> bool:
    """Whether lines of two kinds, of which none names a number that the other does, tell the same time."""
    shared = (before.keys() & record.keys()) - words.keys()
    return bool(shared) and shared <= HEADS and all(before[name] == record[name] for name in shared)


def _recurring(named: list[dict[str, str]], records: Sequence[Mapping[str, object]]) -> list[dict[str, str]]:
    """Flat records with entries of lists by what they are called; by their place if each record calls them anew."""
    names = {name for record in named for name in record}
    recur = len(names) <= max(map(len, named)) + RECURRING * len(named)
    return named if recur else [with_told_units(flat(record, named=False)) for record in records]


def _table(
    file: Path,
    records: Sequence[dict[str, str]],
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
