"""JSON documents that hold a series of samples for each signal, as panels and databases answer: to tagged records."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from gen.importing.guessing.names import TIME
from gen.importing.reading.tagged.tagged_records import Record

_NAMES = ("name", "target", "metric", "label", "title", "key", "id")
_MOST = 2000
_EPOCH = (1e9, 2.5e18)
_LEAST = 3
"""Samples of a signal."""


@dataclass(frozen=True)
class _Signal:
    name: str
    tags: Mapping[str, str]
    times: Sequence[object]
    values: Sequence[object]


def records_of(tree: object) -> list[Record] | None:
    """Records in the order of their times; None of a document of another kind.

    Known are series with pairs of times and values (`datapoints`, `data`), with arrays of both (`x` and `y`), and with
    columns and rows below tags (InfluxDB); tables of fields (Grafana's frames); and lists of objects of a time and a
    value below names (ThingsBoard).

    Parameters
    ----------
    tree
        A JSON text.
    """
    found = list(_signals(tree))
    called = {(signal.name, tuple(signal.tags.items())) for signal in found}
    if not found or len(called) < len(found) or len(found) > _MOST:
        return None
    if any(len(signal.times) != len(signal.values) for signal in found):
        return None
    kinds = {type(at) for signal in found for at in signal.times}
    if not (kinds <= {int, float} or kinds == {str}):
        return None
    records: list[Record] = [
        {"fields": {signal.name: value}, "tags": dict(signal.tags), "time": at}
        for signal in found
        for at, value in zip(signal.times, signal.values, strict=True)
    ]
    records.sort(key=lambda record: record["time"])  # type: ignore[arg-type,return-value]
    return records


def _signals(tree: object) -> Iterator[_Signal]:
    """All signals within a document."""
    if isinstance(tree, dict):
        own = [*_of_fields(tree), *_of_columns(tree), *_of_names(tree)]
        yield from own
        for value in tree.values() if not own else ():
            yield from _signals(value)
    elif isinstance(tree, list) and len(tree) <= _MOST:  # longer ones are rows
        each = [_of_entry(entry) if isinstance(entry, dict) else [] for entry in tree]
        several = all(each)  # of one that is none, nobody would know that it is missing
        for own in each if several else ():
            yield from own
        for entry in tree if not several else ():
            if isinstance(entry, (dict, list)):
                yield from _signals(entry)


def _of_entry(entry: Mapping[str, object]) -> list[_Signal]:
    """The signals of one of several series."""
    paired = _of_pairs(entry)
    return _of_columns(entry) or ([paired] if paired is not None else [])


def _of_pairs(entry: Mapping[str, object]) -> _Signal | None:
    """A series that is called something, of pairs of a time and a value, or of an array of each."""
    name = next((str(entry[key]) for key in _NAMES if isinstance(entry.get(key), str)), "")
    lists = {key: value for key, value in entry.items() if isinstance(value, list) and len(value) >= _LEAST}
    if not name or not lists:
        return None
    for value in lists.values():
        if all(isinstance(pair, list) and len(pair) == 2 for pair in value):
            first, second = ([pair[k] for pair in value] for k in (0, 1))
            turned = _since_1970(second) and not _since_1970(first)
            return _Signal(name, {}, second, first) if turned else _Signal(name, {}, first, second)
    times = next((value for key, value in lists.items() if key == "x" or TIME.fullmatch(key.casefold())), None)
    others = [value for value in lists.values() if value is not times and times and len(value) == len(times)]
    return _Signal(name, {}, times, others[0]) if times is not None and len(others) == 1 else None


def _of_columns(tree: Mapping[str, object]) -> list[_Signal]:
    """The columns of rows below tags: ``{"name": .., "tags": {..}, "columns": ["time", "temp"], "values": [..]}``."""
    columns, rows, tags = tree.get("columns"), tree.get("values"), tree.get("tags")
    if not isinstance(columns, list) or not isinstance(rows, list) or not isinstance(tree.get("name"), str):
        return []
    if not all(isinstance(row, list) and len(row) == len(columns) for row in rows) or "time" not in columns:
        return []
    turned = dict(zip(columns, zip(*rows, strict=True), strict=True))
    said = {key: str(value) for key, value in tags.items()} if isinstance(tags, dict) else {}
    return [_Signal(str(name), said, turned["time"], turned[name]) for name in columns if name != "time"]


def _of_fields(tree: Mapping[str, object]) -> list[_Signal]:
    """The fields of one of Grafana's frames, with their units and labels."""
    schema, data = tree.get("schema"), tree.get("data")
    fields = schema.get("fields") if isinstance(schema, dict) else None
    arrays = data.get("values") if isinstance(data, dict) else None
    if not isinstance(fields, list) or not isinstance(arrays, list) or len(fields) != len(arrays):
        return []
    if not all(isinstance(field, dict) for field in fields) or not all(isinstance(array, list) for array in arrays):
        return []
    times = next((k for k, field in enumerate(fields) if field.get("type") == "time"), None)
    if times is None:
        return []
    made = []
    for field, values in zip(fields, arrays, strict=True):
        config, labels = field.get("config"), field.get("labels")
        unit = config.get("unit") if isinstance(config, dict) else ""
        told = [f"{value} {unit}" if isinstance(value, (int, float)) and unit else value for value in values]
        name = str(field.get("name", ""))
        tags = {key: str(value) for key, value in labels.items()} if isinstance(labels, dict) else {}
        made.append(_Signal(name, {k: value for k, value in tags.items() if value != name}, arrays[times], told))
    return [signal for k, signal in enumerate(made) if k != times]


def _of_names(tree: Mapping[str, object]) -> list[_Signal]:
    """Lists of objects of a time and a value, by name: ``{"winding": [{"ts": .., "value": ..}], ..}``."""
    made = []
    for name, entries in tree.items():
        if not isinstance(entries, list) or len(entries) < _LEAST or not all(isinstance(e, dict) for e in entries):
            return []
        keys = set(entries[0])
        times = next((key for key in keys if TIME.fullmatch(str(key).casefold())), None)
        if times is None or len(keys) != 2 or any(set(entry) != keys for entry in entries):
            return []
        value = next(key for key in keys if key != times)
        made.append(_Signal(name, {}, [e[times] for e in entries], [e[value] for e in entries]))
    return made if len(made) > 1 else []


def _since_1970(values: Sequence[object]) -> bool:
    return all(isinstance(value, (int, float)) and _EPOCH[0] < value < _EPOCH[1] for value in values)
