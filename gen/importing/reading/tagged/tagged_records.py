"""Readings that come one by one, as records of fields that are measured, below tags that say of what.

So Telegraf and InfluxDB write them; what other programs write is brought into this form.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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
    made: dict[object, dict[str, object]] = {}
    every: list[tuple[int, dict[str, object]]] = []
    for record, tags, place in zip(records, told, places, strict=True):
        key, at = _time_of(record)
        before = ".".join(tags[name] for name in differing if name in tags)
        fields = record["fields"]
        assert isinstance(fields, dict)
        named = {f"{before}.{field}" if before else field: value for field, value in fields.items()}
        row = made.get(at)
        if row is None or any(name in row for name in named):
            row = made[at] = {} if at is None else {key: at}
            every.append((place, row))
        row |= named
    return [row for _, row in every], [place for place, _ in every]


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
