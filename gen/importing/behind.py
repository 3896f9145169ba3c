"""Units behind numbers: the one of a column, and what is told in another brought into it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gen.arrays import IntArray
from gen.importing.numbers import Parsed
from gen.importing.units import Unit, unit_of

_DIGITS = 12
"""Behind the point: a conversion leaves no tails of doubles."""


def commonest(columns: Sequence[Parsed]) -> Unit | None:
    """The unit behind most numbers, or the plain one (A, not mA) where it is behind some; None where most have none."""
    found: Counter[Unit | None] = Counter()
    for parsed in columns:
        if parsed.unit_at is None:
            found[None] += int(np.isfinite(parsed.values).sum())
            continue
        found[None] += alone(parsed).size
        for k, written in enumerate(parsed.units):
            found[unit_of(written)] += int((parsed.unit_at == k).sum())
    most = found.most_common(1)[0][0] if found.total() else None
    if most is None:
        return None
    plain = (unit for unit in found if unit and unit.target == most.target and (unit.scale, unit.offset) == (1.0, 0.0))
    return next(plain, most)


def brought(parsed: Parsed, own: Unit | None) -> Parsed:
    """Bring all numbers into one unit.

    Parameters
    ----------
    parsed
        As written.
    own
        The column's. What is told in a unit of another quantity is text then; without one, all that has a unit is.
    """
    if parsed.unit_at is None:
        return parsed
    values, text, converted = parsed.values.copy(), parsed.text.copy(), np.zeros_like(parsed.text)
    for k, written in enumerate(parsed.units):
        rows = np.flatnonzero(parsed.unit_at == k)
        unit = unit_of(written)
        if own is None or unit is None or unit.target != own.target:
            values[rows], text[rows] = np.nan, True
        elif (unit.scale, unit.offset) != (own.scale, own.offset):
            there = values[rows] * unit.scale + unit.offset
            values[rows], converted[rows] = np.round((there - own.offset) / own.scale, _DIGITS), True
    return replace(parsed, values=values, text=text, converted=converted)


def alone(parsed: Parsed) -> IntArray:
    """Rows whose number has no unit behind it, where others have one."""
    if parsed.unit_at is None:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(np.isfinite(parsed.values) & (parsed.unit_at < 0))
