"""Columns that say no unit, and begin and move as temperatures do: how far a column is like those that are some."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.importing.guessing.counters import counts_rows
from gen.importing.guessing.evidence import Evidence, Facts
from gen.importing.mapping import Mapping
from gen.importing.units import Unit, unit_of

_LEAST_ROWS, _LEAST_VALUES = 20, 8
"""Readings, and different ones, that show how a column moves."""
_LEAST_MOVED_K, _HOTTEST_C, _COLDEST_C = 2.0, 200.0, -40.0
_NEAR_K, _ROOM_C = 8.0, 18.0
"""How far from the others a log may begin; a warm motor's parts lie between it and the room."""
_JUMP = 0.2
"""Of what a column moves by: a temperature does not go that far in one row, unless others do."""
_FASTER = 1.5
_ROUGH = 0.3
"""Mean square of steps over the variance, above which it is noise; white noise has 2."""
_FOLLOWS, _LEAST_SHARE = 0.4, 0.25
"""Correlation with another temperature, that moves by at least this share of what the column moves by."""
_EVEN = 0.01
"""Of the largest step, by which the steps of a counter or a clock differ."""
_PARTS_OF_A_LOG = 20
_TAIL = 0.5
"""Percent of the readings at each end that do not count: what a sensor gives when it fails."""


def temperatures(evidence: Evidence, mapping: Mapping) -> list[tuple[Facts, Unit]]:
    """Give the columns that are temperatures, and what they are told in.

    Parameters
    ----------
    evidence
        The columns.
    mapping
        What was decided of them.
    """
    return [
        (evidence.facts[entry.source], unit)
        for entry in mapping.column
        if entry.to.endswith("_degC") and (unit := unit_of(entry.unit)) is not None
    ]


def unit_alike(facts: Facts, temperatures: Sequence[tuple[Facts, Unit]]) -> Unit | None:
    """The unit of the temperatures that a column without one begins near and moves like; None where there are none.

    Parameters
    ----------
    facts
        Of numbers.
    temperatures
        Columns that are temperatures, and what they are told in.
    """
    if facts.values.size < _LEAST_ROWS or np.unique(facts.values).size < _LEAST_VALUES or counts_rows(facts):
        return None
    for unit in dict.fromkeys(unit for _, unit in temperatures):
        same = [other for other, its in temperatures if its == unit]
        if _plausible(facts, same, unit) and _begins_near(facts, same, unit) and _slow(facts, same):
            return unit
    return None


def follows(facts: Facts, temperatures: Sequence[Facts]) -> bool:
    """Whether a column rises and falls with one of the others that moves, as parts of one motor do.

    A battery's volts fall while the motor warms; what moves with a room by chance is none of a motor's parts.

    Parameters
    ----------
    facts
        Of numbers.
    temperatures
        Columns of the same tables, in one unit.
    """
    least = _LEAST_SHARE * moved(facts)
    return any(
        correlation(facts, other) > _FOLLOWS for other in temperatures if other.values.size and moved(other) >= least
    )


def correlation(first: Facts, second: Facts) -> float:
    """Of two columns, over all tables, -1..1; 0 where one stands.

    Parameters
    ----------
    first, second
        Of the same tables.
    """
    return _correlated(_side_by_side(first, second))


def correlation_of_changes(first: Facts, second: Facts) -> float:
    """The same of what both change by within a twentieth of a log: what warms all day is not what a motor warms.

    Parameters
    ----------
    first, second
        Of the same tables.
    """
    pairs = _side_by_side(first, second)
    steps = [max(1, a.size // _PARTS_OF_A_LOG) for a, _ in pairs]
    return _correlated([(a[n:] - a[:-n], b[n:] - b[:-n]) for (a, b), n in zip(pairs, steps, strict=True)])


def _side_by_side(first: Facts, second: Facts) -> list[tuple[FloatArray, FloatArray]]:
    pairs = [(_filled(a.values), _filled(b.values)) for a, b in zip(first.parsed, second.parsed, strict=True)]
    return [(a, b) for a, b in pairs if a.size and b.size]


def _correlated(pairs: Sequence[tuple[FloatArray, FloatArray]]) -> float:
    if not pairs:
        return 0.0
    one, two = (np.concatenate(values) for values in zip(*pairs, strict=True))
    if not one.size:
        return 0.0
    one, two = one - one.mean(), two - two.mean()
    size = float(np.sqrt((one @ one) * (two @ two)))
    return float(one @ two) / size if size > 0.0 else 0.0


def moved(facts: Facts) -> float:
    """By how much a column moves in all tables together, without what few readings do.

    Parameters
    ----------
    facts
        Of numbers.
    """
    low, high = np.percentile(facts.values, [_TAIL, 100.0 - _TAIL])
    return float(high - low)


def _filled(values: FloatArray) -> FloatArray:
    """A reading for each row: between two of a sensor that is read more rarely, on the line between them."""
    known = np.flatnonzero(np.isfinite(values))
    return np.interp(np.arange(values.size), known, values[known]) if known.size else np.zeros(0)


def _plausible(facts: Facts, others: Sequence[Facts], unit: Unit) -> bool:
    """Whether a machine has such temperatures, none far below what is the coldest there."""
    low, high = np.percentile(facts.values, [_TAIL, 100.0 - _TAIL]) * unit.scale + unit.offset
    coldest = min(float(np.percentile(other.values, _TAIL)) for other in others) * unit.scale + unit.offset
    least = max(min(coldest, _ROOM_C) - _NEAR_K, _COLDEST_C)
    return bool(low > least and high < _HOTTEST_C and high - low >= _LEAST_MOVED_K)


def _begins_near(facts: Facts, others: Sequence[Facts], unit: Unit) -> bool:
    """Whether it begins in each table where the others do, or between them and a room."""
    for index, own in enumerate(_begins(facts)):
        starts = [begin for other in others if np.isfinite(begin := _begins(other)[index])]
        if not np.isfinite(own) or not starts:
            continue
        degC = np.array([own, *starts]) * unit.scale + unit.offset
        if not min(degC[1:].min(), _ROOM_C) - _NEAR_K <= degC[0] <= degC[1:].max() + _NEAR_K:
            return False
    return True


def _begins(facts: Facts) -> list[float]:
    """Median of the first five readings of each table; NaN of one that has none."""
    found = [entry.values[np.isfinite(entry.values)][:5] for entry in facts.parsed]
    return [float(np.median(values)) if values.size else np.nan for values in found]


def _slow(facts: Facts, others: Sequence[Facts]) -> bool:
    """Whether it changes little from row to row, measured by how far it goes, or by what the others do."""
    steps = _steps(facts)
    if not steps.size or np.ptp(steps) <= _EVEN * np.abs(steps).max():
        return False
    fastest = max((float(np.abs(found).max()) for other in others if (found := _steps(other)).size), default=0.0)
    if np.abs(steps).max() > max(_JUMP * moved(facts), _FASTER * fastest):
        return False
    return float((steps**2).mean()) <= _ROUGH * float(facts.values.var())


def _steps(facts: Facts) -> FloatArray:
    """From reading to reading, where a single one that is far from those around it does not count."""
    found = [entry.values[np.isfinite(entry.values)] for entry in facts.parsed]
    return np.concatenate([np.diff(_median_of_three(values)) for values in found])


def _median_of_three(values: FloatArray) -> FloatArray:
    if values.size <= 2:
        return values
    return np.asarray(np.median(np.stack([values[:-2], values[1:-1], values[2:]]), axis=0))
