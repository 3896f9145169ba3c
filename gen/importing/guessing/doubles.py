"""A temperature that a log tells twice, in two units: `temp_c` and `temp_f`."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.importing.guessing.evidence import Facts
from gen.importing.units import DEGC

_ROUNDED_K = 1.0
"""By which whole numbers of two units differ at most."""


def told_twice(temperatures: Sequence[Facts], told: Collection[str]) -> dict[str, str]:
    """The columns of one name that hold the same in another unit than degC, and each one's in degC.

    Parameters
    ----------
    temperatures
        The columns that are temperatures.
    told
        Columns of which the user says something: none of them.
    """
    found: dict[str, str] = {}
    for facts in temperatures:
        unit = facts.named[1]
        if unit is None or unit == DEGC or facts.name in told:
            continue
        for other in temperatures:
            same = other.named[1] == DEGC and other.named[0].casefold() == facts.named[0].casefold()
            if same and _agree(facts, other):
                found[facts.name] = other.name
    return found


def _agree(facts: Facts, other: Facts) -> bool:
    unit = facts.named[1]
    if unit is None:
        return False
    here, there = (_all(entry) for entry in (facts, other))
    both = np.isfinite(here) & np.isfinite(there)
    return bool(both.any() and (np.abs(here[both] * unit.scale + unit.offset - there[both]) <= _ROUNDED_K).all())


def _all(facts: Facts) -> FloatArray:
    """Every row's number, NaN where it is missing."""
    return np.concatenate([entry.values for entry in facts.parsed])
