"""Units that messages tell beside their numbers: ``{"value": 70.8, "unit": "F"}``, ``"winding_unit": "degF"``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache

from gen.importing.guessing.names import TIME
from gen.importing.numbers import plain_number
from gen.importing.units import unit_of

_SAYS = re.compile(
    r"(?P<of>.*?)[_ ]?(?:units?|uom|unit_?of_?meas(?:urement|ure)?|eng(?:ineering)?_?units?|measurement_?unit|einheit)"
    r"|u",
    re.IGNORECASE,
)
_VALUE = re.compile(r"value|val|v|wert|state|reading|measured|last|raw|min|max|mean|avg|average|median", re.IGNORECASE)
"""What the number is called beside which a unit stands, or what was made of several such numbers."""
_BESIDE = re.compile(r"(?:(.*)\.)?attributes\.")
"""Home Assistant's: the unit is an attribute of the state."""


def with_told_units(record: dict[str, str]) -> dict[str, str]:
    """A flat record with the units behind its numbers that stand beside them.

    Parameters
    ----------
    record
        Values by name, inner objects as ``outer.inner``. A unit that nobody knows stays what it is, as does one beside
        several numbers, of which nobody knows which it is meant for.
    """
    saying = [name for name in record if _says(name)]
    if not saying:
        return record
    made = dict(record)
    for name in saying:
        unit = record[name].strip()
        told = _meant(name, record) if unit_of(unit) else []
        for number in told:
            made[number] = f"{record[number]} {unit}"
        if told:
            del made[name]
    return made


def units_within(tree: object) -> dict[str, str]:
    """Objects that say units by name beside a table, flat: ``{"units": {"winding": "degF"}}`` as ``units.winding``.

    Parameters
    ----------
    tree
        A JSON text.
    """
    if not isinstance(tree, dict):
        return {}
    found: dict[str, str] = {}
    for key, value in tree.items():
        if isinstance(value, dict) and _SAYS.fullmatch(key):
            found |= {f"{key}.{name}": unit for name, unit in value.items() if isinstance(unit, str)}
        else:
            found |= units_within(value)
    return found


@lru_cache(maxsize=4096)
def _says(name: str) -> bool:
    """Whether a name is that of a unit, or of what lies within an object of units."""
    *outer, last = name.split(".")
    return bool(_SAYS.fullmatch(last)) or bool(outer and _lists_units(outer[-1]))


def _lists_units(name: str) -> bool:
    found = _SAYS.fullmatch(name)
    return found is not None and not found["of"]


def _meant(name: str, record: Mapping[str, str]) -> list[str]:
    """The numbers that a unit stands beside."""
    *outer, last = name.split(".")
    if outer and _lists_units(outer[-1]):
        before = "".join(f"{part}." for part in outer[:-1])
        within = [other for other in record if other.startswith(before) and other.split(".")[-1] == last]
        return [other for other in within if other != name and _is_number(record[other])]
    before = "".join(f"{part}." for part in outer)
    of = _SAYS.fullmatch(last)
    if of is not None and of["of"]:
        number = before + of["of"]
        return [number] if _is_number(record.get(number, "")) else []
    attribute = _BESIDE.fullmatch(before)
    before = before if attribute is None else f"{attribute[1]}." if attribute[1] else ""
    beside = [
        other
        for other in record
        if other.startswith(before) and "." not in other[len(before) :] and _is_number(record[other])
    ]
    values = [other for other in beside if _VALUE.fullmatch(other[len(before) :])]
    if values or attribute is not None:
        return values
    beside = [other for other in beside if not TIME.fullmatch(other[len(before) :].casefold())]
    return beside if len(beside) == 1 else []


def _is_number(text: str) -> bool:
    return plain_number(text) is not None
