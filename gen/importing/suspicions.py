"""Temperatures that are possible as they stand, but that a wrong unit or a sensor read wrongly explains better."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gen.arrays import FloatArray

_WARM_ROOM = (60.0, 95.0)
"""degC of no room in which a motor is tried, but degF of one."""
_ROOM = (14.0, 32.0)
"""degC of a room, but degF of frost."""
_ALIKE_K = 2.5
_FEW = 5


def suspicions(
    temps: Mapping[str, FloatArray], ambient: FloatArray | None, units: Mapping[str, str]
) -> dict[str, tuple[str, str]]:
    """What is suspicious of a run's temperatures.

    Parameters
    ----------
    temps
        By the column of the run file, degC, NaN where missing.
    ambient
        The ambient's, likewise.
    units
        What each was told in.

    Returns
    -------
    dict
        Column -> what is said, and the unit that would correct it.
    """
    starts = {
        name: float(np.median(values[np.isfinite(values)][:_FEW])) for name, values in temps.items() if _any(values)
    }
    room = float(np.nanmedian(ambient)) if ambient is not None and _any(ambient) else None
    found: dict[str, tuple[str, str]] = {}
    if room is not None and _WARM_ROOM[0] <= room <= _WARM_ROOM[1]:
        found["ambient_degC"] = (
            f"an ambient of {room:.4g} degC is rather {_celsius(room):.3g} degC told in degF",
            "degF",
        )
    for name, begin in starts.items():
        others = [value for other, value in starts.items() if other != name]
        if room is not None:
            others.append(room)
        said = _celsius_after_all(begin, units.get(name, "")) or _fahrenheit(begin, others) or _half(begin, others)
        if said:
            found[name] = said
    return found


def _celsius_after_all(begin: float, unit: str) -> tuple[str, str] | None:
    """A motor below freezing that would be in a room, were its numbers in degC."""
    number = begin * 1.8 + 32.0
    if unit != "degF" or not _ROOM[0] <= number <= _ROOM[1]:
        return None
    return f"begins at {begin:.3g} degC, told as {number:.3g} degF, which would be a room's in degC", "degC"


def _fahrenheit(begin: float, others: list[float]) -> tuple[str, str] | None:
    if not _WARM_ROOM[0] <= begin <= _WARM_ROOM[1]:
        return None
    as_celsius = _celsius(begin)
    if others and abs(as_celsius - float(np.median(others))) <= _ALIKE_K:
        return (
            f"begins at {begin:.4g}, where the others begin as {as_celsius:.3g} degC, which is the same in degF",
            "degF",
        )
    if all(abs(begin - value) <= 2 * _ALIKE_K for value in others) and begin <= 86.0:
        said = "it and all others begin" if others else "begins"
        return f"{said} at about {begin:.3g} degC: a motor that ran, or a cold one told in degF", "degF"
    return None


def _half(begin: float, others: list[float]) -> tuple[str, str] | None:
    if not others:
        return None
    common = float(np.median(others))
    if max(abs(value - common) for value in others) > 2 * _ALIKE_K or common < 12.0:
        return None
    if abs(begin - common / 2.0) <= 0.1 * common / 2.0 + 0.25:
        return f"begins at {begin:.3g} degC, half of the others' {common:.3g}: a MAX31855 read as a MAX6675?", "2degC"
    return None


def _any(values: FloatArray) -> bool:
    return bool(np.isfinite(values).any())


def _celsius(value: float) -> float:
    return (value - 32.0) / 1.8
