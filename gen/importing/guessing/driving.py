"""Columns that may drive a motor by their names, where none is a PWM: what it is told first, then what heats it."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gen.importing.guessing import names
from gen.importing.guessing.evidence import Facts
from gen.importing.guessing.input_scale import pulse, worded
from gen.importing.units import SHARE

_SAYS_TEMPERATURE = re.compile(r"(?i)temp(?!o)|th?ermo|°")
_TOLD, _SPENT, _HEATS = range(3)
_FREQUENCY, _SPEED = (_TOLD, "a frequency: what the motor is told"), (_TOLD, "a speed: what the motor is told")
_TOLD_OUTRIGHT = (_FREQUENCY, _SPEED)


def drives(numbers: Sequence[Facts]) -> list[Facts]:
    """Columns that may drive it: what it is told first, then what it takes.

    Parameters
    ----------
    numbers
        Columns of numbers.
    """
    called = [entry.name for entry in numbers]
    found = [entry for entry in numbers if _may_drive(entry) and entry.span != (0.0, 0.0)]
    found = [entry for entry in found if not names.are_terms(entry.name, called)]
    had = [entry for entry in found if not names.WANTED.search(worded(entry))]  # what was wanted heats nothing
    return sorted(had or found, key=lambda entry: _kind(entry)[0])


def meaning(entry: Facts) -> str:
    """What it means to take a column for the input; empty where that is plain.

    Parameters
    ----------
    entry
        One of :func:`drives`.
    """
    return _kind(entry)[1]


def told_beside(entry: Facts, numbers: Sequence[Facts]) -> list[Facts]:
    """Frequencies and speeds beside a current that was taken for the input: what the motor is told may be among them.

    Parameters
    ----------
    entry
        The input.
    numbers
        Columns of numbers.
    """
    if _kind(entry)[0] != _HEATS:
        return []
    return [other for other in drives(numbers) if other is not entry and _kind(other) in _TOLD_OUTRIGHT]


def _may_drive(entry: Facts) -> bool:
    if entry.in_degrees or _SAYS_TEMPERATURE.search(entry.name):
        return False
    unit = entry.named[1]
    if unit is not None and unit.quantity == SHARE and not names.STORED.search(f"{entry.name} {worded(entry)}"):
        return True
    if (unit is not None and unit.target == "W") or _is_pulse(entry):
        return True
    return bool(names.DRIVES.search(worded(entry))) or _is_frequency(entry)


def _is_frequency(entry: Facts) -> bool:
    """Whether it is that of an inverter: one of the mains, or of a PWM, stays or is called so."""
    low, high = entry.span
    text = f"{worded(entry)} {entry.written_unit}"
    return low != high and bool(names.FREQUENCY.search(text)) and not names.NO_INVERTER.search(text)


def _is_pulse(entry: Facts) -> bool:
    """Whether it is how long a servo's or a speed controller's pulses are, in us."""
    unit = entry.named[1]
    return unit is not None and unit.name == "us" and entry.span[0] != entry.span[1] and bool(pulse(entry))


def _kind(entry: Facts) -> tuple[int, str]:
    text, unit = worded(entry), entry.named[1]
    if _is_pulse(entry):
        return _TOLD, "pulses: what the motor is told"
    if names.CURRENT_OF.search(text) or (unit is not None and unit.target == "A"):
        return _HEATS, "a current: what heats it; beside another input, --heat of gen identify takes it"
    if names.HEATS.search(text) or (unit is not None and unit.target == "W"):
        return _SPENT, "a power: what it takes"
    if _is_frequency(entry):
        return _FREQUENCY
    if names.SPEED_OF.search(text):
        return _SPEED
    return _TOLD, "what the motor is told" if unit is not None and unit.quantity == SHARE else ""
