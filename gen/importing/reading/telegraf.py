"""Records of Telegraf and InfluxDB: fields that are measured, below tags that say of what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

_TIMES = ("timestamp", "time", "_time")


def is_tagged(records: Sequence[Mapping[str, object]]) -> bool:
    """Whether all records are of fields and tags: ``{"fields": {..}, "name": .., "tags": {..}, "timestamp": ..}``."""
    return all(
        isinstance(record.get("fields"), dict) and isinstance(record.get("tags"), dict) and any(map(record.get, _TIMES))
        for record in records
    )


def of_one_time(
    records: Sequence[Mapping[str, object]], places: Sequence[int]
) -> tuple[list[dict[str, object]], list[int]]:
    """A record for each time: fields named after the tags that differ from record to record (``winding.temp_c``).

    Parameters
    ----------
    records
        For which :func:`is_tagged`.
    places
        Where each stands.

    Returns
    -------
    records, places
        In the order of the log; what comes again at the same time begins a new record.
    """
    told = [_tags(record) for record in records]
    telling = [key for tags in told for key in tags]
    differing = [key for key in dict.fromkeys(telling) if len({tags.get(key) for tags in told}) > 1]
    made: dict[object, dict[str, object]] = {}
    every: list[tuple[int, dict[str, object]]] = []
    for record, tags, place in zip(records, told, places, strict=True):
        key, at = next((name, record[name]) for name in _TIMES if record.get(name))
        before = ".".join(tags[name] for name in differing if name in tags)
        fields = record["fields"]
        assert isinstance(fields, dict)
        named = {f"{before}.{field}" if before else field: value for field, value in fields.items()}
        row = made.get(at)
        if row is None or any(name in row for name in named):
            row = made[at] = {key: at}
            every.append((place, row))
        row |= named
    return [row for _, row in every], [place for place, _ in every]


def _tags(record: Mapping[str, object]) -> dict[str, str]:
    tags = record["tags"]
    assert isinstance(tags, dict)
    return {key: str(value) for key, value in tags.items()}
