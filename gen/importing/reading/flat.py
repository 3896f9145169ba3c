"""JSON objects to flat records: inner objects become ``outer.inner``, entries of lists are called as they say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

_LABELS = ("name", "label", "sensor", "channel", "id")
LONGEST_LABEL = 40
"""Characters: what is longer is a text, and no name."""


def flat(record: Mapping[str, object], before: str = "", *, named: bool = True) -> dict[str, str]:
    """A record of texts.

    Parameters
    ----------
    record
        An object.
    before
        What its names begin with.
    named
        Whether entries of lists go by what they are called; else by their place.
    """
    made: dict[str, str] = {}
    for key, value in record.items():
        if isinstance(value, str):
            made[before + key] = value
        elif isinstance(value, float):
            made[before + key] = repr(value)
        elif isinstance(value, dict):
            made |= flat(value, f"{before}{key}.", named=named)
        elif isinstance(value, list):
            labels = _labels(value) if named else _places(value)
            made |= flat(dict(zip(labels, value, strict=True)), f"{before}{key}.", named=named)
        elif isinstance(value, bool):
            made[before + key] = str(int(value))
        else:
            made[before + key] = "" if value is None else str(value)
    return made


def _labels(entries: Sequence[object]) -> list[str]:
    """What entries of a list are called: as they say themselves, each by another name, or by their place."""
    objects = [entry for entry in entries if isinstance(entry, dict)]
    for key in _LABELS if len(objects) == len(entries) else ():
        said = [entry.get(key) for entry in objects]
        names = [name for name in said if isinstance(name, str) and 0 < len(name) <= LONGEST_LABEL]
        if len(set(names)) == len(said):
            return names
    return _places(entries)


def _places(entries: Sequence[object]) -> list[str]:
    return [str(place) for place in range(1, len(entries) + 1)]
