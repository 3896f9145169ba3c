"""SenML (RFC 8428) to tagged records: readings below base fields that hold until they are told anew."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from gen.importing.reading.tagged.tagged_records import Record
from gen.importing.reading.tagged.tails import without_shared

_LABELS = {"bver", "bn", "bt", "bu", "bv", "bs", "n", "u", "v", "vs", "vb", "vd", "s", "t", "ut", "l"}
_UNITS = {"Cel": "degC", "/": "duty", "%EL": "%", "%RH": "%", "beat/min": "1/min"}
"""As they are called elsewhere; the others are called so everywhere."""


def is_senml(records: Sequence[object]) -> bool:
    """Whether all of an array are records of SenML, with names and values.

    Parameters
    ----------
    records
        Of a JSON text.
    """
    if not records or not all(isinstance(e, dict) and all(k in _LABELS or k.endswith("_") for k in e) for e in records):
        return False
    keys = {key for record in records if isinstance(record, dict) for key in record}
    return bool(keys & {"n", "bn"}) and bool(keys & {"v", "vb", "vs", "bv"})


def resolved(packs: Sequence[Sequence[Mapping[str, object]]]) -> list[Record]:
    """Tagged records of packs, each of which begins without base fields.

    Parameters
    ----------
    packs
        For each of which :func:`is_senml`. Times that no reading tells are left out.
    """
    found = [reading for pack in packs for reading in _readings(pack)]
    names = without_shared([name for name, _, _ in found], ":/.")
    timed = any(at is not None for _, at, _ in found)
    return [
        {"fields": {names[name]: value}, "tags": {}} | ({"time": at or 0.0} if timed else {})
        for name, at, value in found
    ]


def _readings(pack: Sequence[Mapping[str, object]]) -> Iterator[tuple[str, float | None, str]]:
    """Name, time and value with its unit of each reading."""
    base: dict[str, object] = {}
    for record in pack:
        base |= {key: value for key, value in record.items() if key.startswith("b")}
        value = next((record[key] for key in ("v", "vb", "vs") if key in record), None)
        if value is None and not ("n" in record and "bv" in base):
            continue  # base fields only
        if isinstance(value, bool):
            value = int(value)
        elif not isinstance(value, str):
            value = _number(value) + _number(base.get("bv"))
        at = _number(base.get("bt")) + _number(record.get("t")) if "bt" in base or "t" in record else None
        unit = str(record.get("u") or base.get("bu") or "")
        shown = value if isinstance(value, str) else f"{value!r} {_UNITS.get(unit, unit)}".strip()
        yield f"{base.get('bn') or ''}{record.get('n') or ''}", at, shown


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) else 0.0
