"""Readings that come one by one, as records of fields that are measured, below tags that say of what.

So Telegraf and InfluxDB write them; what other programs write is brought into this form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gen.importing.reading.tagged.tails import CARRIERS

_TIMES = ("timestamp", "time", "_time")
Record = Mapping[str, object]


def is_tagged(records: Sequence[Record]) -> bool:
    """Whether all records are of fields and tags: ``{"fields": {..}, "name": .., "tags": {..}, "timestamp": ..}``."""
    return all(
        isinstance(record.get("fields"), dict)
        and "tags" in record
        and isinstance(record["tags"], (dict, type(None)))
        and isinstance(_time_of(record)[1], (str, int, float))
        for record in records
    )


def of_one_time(records: Sequence[Record], places: Sequence[int]) -> tuple[list[dict[str, object]], list[int]]:
    """A record for each time: fields named after the tags that differ from record to record (``winding.temp_c``).

    What a record calls itself (``motor`` of a measurement) stands before them where several of other names have such a
    field.

    Parameters
    ----------
    records
        For which :func:`is_tagged`; or none of them tells a time, and each name that comes again begins a new record.
    places
        Where each stands.

    Returns
    -------
    records, places
        In the order of the log; what comes again at the same time begins a new record.
    """
    told = [tags_of(record) for record in records]
    differing = differing_tags(told)
    tagged = [".".join(tags[name] for name in differing if name in tags) for tags in told]
    whose = _measurements(records, tagged)
    made: dict[object, dict[str, object]] = {}
    every: list[tuple[int, dict[str, object]]] = []
    for record, before, place in zip(records, tagged, places, strict=True):
        key, at = _time_of(record)
        named = {_called(record, before, field, whose): value for field, value in _fields(record).items()}
        row = made.get(at)
        if row is None or any(name in row for name in named):
            row = made[at] = {} if at is None else {key: at}
            every.append((place, row))
        row |= named
    return [row for _, row in every], [place for place, _ in every]


def _measurements(records: Sequence[Record], tagged: Sequence[str]) -> dict[tuple[str, str], set[str]]:
    """The measurements that have each field below its tags, and (without any) below all of them."""
    found: dict[tuple[str, str], set[str]] = {}
    for record, before in zip(records, tagged, strict=True):
        name = _measurement(record)
        for field in _fields(record):
            found.setdefault((before, field), set()).add(name)
            # one that says nothing is told apart from all others, whatever these measure
            found.setdefault(("", "" if field.casefold() in CARRIERS else field), set()).add(name)
        found.setdefault(("", ""), set()).add(name)
    return found


def _called(record: Record, before: str, field: str, whose: Mapping[tuple[str, str], set[str]]) -> str:
    """A field below what tells it apart: its measurement where others have it, too, and no tag says of what it is."""
    alike = whose[before, "" if not before and field.casefold() in CARRIERS else field]
    return ".".join(filter(None, (_measurement(record) if len(alike) > 1 else "", before, field)))


def _measurement(record: Record) -> str:
    name = record.get("name")
    return name if isinstance(name, str) else ""


def _fields(record: Record) -> dict[str, object]:
    fields = record["fields"]
    assert isinstance(fields, dict)
    return fields


def differing_tags(told: Sequence[Mapping[str, str]]) -> list[str]:
    """Tags that are not the same in all records: what is the same in all is no name.

    Parameters
    ----------
    told
        The tags of each record.
    """
    telling = [key for tags in told for key in tags]
    return [key for key in dict.fromkeys(telling) if len({tags.get(key) for tags in told}) > 1]


def tags_of(record: Record) -> dict[str, str]:
    """What a record says of what it measured; nothing of ``null``."""
    tags = record["tags"]
    return {key: str(value) for key, value in tags.items()} if isinstance(tags, dict) else {}


def _time_of(record: Record) -> tuple[str, object]:
    """A record's time and what it is called; None without one. 0 is a time."""
    return next(((name, record[name]) for name in _TIMES if record.get(name) not in (None, "")), (_TIMES[0], None))
