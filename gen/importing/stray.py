"""Readings of a temperature that no motor has: a few far from those around them, or hot where others are cold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray

_FAR_K, _COLD_C = 30.0, 45.0
_MOST = 0.2
"""Of the readings, for a stretch of them to be the stray one."""
_TOO_WARM_C = 200.0
"""At which none begins whose neighbours are cold."""
_FEW = 5


@dataclass(frozen=True)
class Stray:
    """Readings of one value, or a stretch of them, apart from those before and behind.

    Parameters
    ----------
    value
        The first one's.
    count
        How many there are in all such stretches.
    row
        The first one's, of those given.
    """

    value: float
    count: int
    row: int


def stray(values: FloatArray) -> Stray | None:
    """Stretches of equal readings that a temperature jumps to and back from; None without any.

    Parameters
    ----------
    values
        In degC, NaN where missing, shape (N,).
    """
    rows = np.flatnonzero(np.isfinite(values))
    known = values[rows]
    if known.size < _FEW:
        return None
    firsts = np.flatnonzero(np.concatenate([[True], np.diff(known) != 0.0]))
    ends = np.append(firsts[1:], known.size)
    found: list[tuple[int, int]] = []
    for first, end in zip(firsts[1:-1].tolist(), ends[1:-1].tolist(), strict=True):
        before, value, behind = known[first - 1], known[first], known[end]
        away = min(abs(value - before), abs(value - behind))
        if away > _FAR_K and abs(before - behind) < away / 2.0 and (value > before) == (value > behind):
            found.append((first, end - first))
    count = sum(length for _, length in found)
    if not found or count > _MOST * known.size:
        return None
    return Stray(float(known[found[0][0]]), count, int(rows[found[0][0]]))


def too_warm(starts: Mapping[str, float]) -> list[str]:
    """The columns that begin hot where others begin cold: a sensor that is not there reads its range's end.

    Parameters
    ----------
    starts
        Where each column begins, degC.
    """
    if not any(begin <= _COLD_C for begin in starts.values()):
        return []
    return [name for name, begin in starts.items() if begin > _TOO_WARM_C]
