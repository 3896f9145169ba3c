"""Numbers in the input's column that no drive has: those that stand for an error, and glitches."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray

_ERRORS = (999.0, -999.0, 999.9, -999.9, 9999.0, -9999.0, 9999.9)
_WORDS = {65535.0: "0xFFFF", 32767.0: "0x7FFF", -32768.0: "0x8000", 4294967295.0: "0xFFFFFFFF"}
_ERROR = "an error's number"
_FAR_ERROR, _FAR_WORD, _FAR_GLITCH = 3.0, 50.0, 20.0
"""Of the largest of all others, by which such a number exceeds it; a word's end may be the full scale of a timer."""
_RARE, _FEW, _MOST = 0.05, 3, 0.2
"""Of the readings, or readings and then of them, at most."""
_LEAST_DRIVEN = 10
"""Readings that are not 0, which show what the others reach."""


def errors_among(values: FloatArray) -> dict[float, str]:
    """Numbers that stand for an error, and what they are: rare, and far from all others.

    Parameters
    ----------
    values
        All readings of the input, none missing, shape (N,).
    """
    suspects = [*_ERRORS, *_WORDS, -1.0]
    counts = {value: int((values == value).sum()) for value in suspects}
    rare = [value for value, count in counts.items() if 0 < count <= min(max(_FEW, _RARE * values.size), _most(values))]
    others = values[~np.isin(values, rare)]
    if not rare or not others.size:
        return {}
    reach, least = float(np.abs(others).max()), float(others.min())
    found = {}
    for value in rare:
        if value == -1.0:
            # of a share that goes up to 1 it may be all of the way back
            stands_out = least >= 0.0 and reach != 1.0
        elif value in _WORDS:
            stands_out = 0.0 < _FAR_WORD * reach < abs(value)
        else:
            stands_out = _FAR_ERROR * reach < abs(value)
        if stands_out:
            found[value] = _WORDS.get(value, _ERROR)
    return found


def glitches_among(values: FloatArray) -> list[float]:
    """One to three readings that are far beyond all others, which show well what they reach.

    Parameters
    ----------
    values
        All readings of the input, none missing, shape (N,).
    """
    size = np.abs(values)
    order = np.argsort(size, kind="stable")
    for count in range(1, _FEW + 1):
        rest = size[order[:-count]]
        if (rest > 0).sum() < _LEAST_DRIVEN or count > _most(values):
            return []
        if size[order[-count]] > _FAR_GLITCH * rest[-1]:
            return [float(value) for value in values[np.sort(order[-count:])]]
    return []


def _most(values: FloatArray) -> float:
    return _MOST * values.size
