"""Arrays of whole numbers and of ratios, none of which is ever rounded but where it says so."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from math import floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Arrays of Python's int and of Fraction: numpy's object arrays.
Integers = NDArray[Any]
Ratios = NDArray[Any]
Floats = NDArray[np.float64]

#: Share by which float64 results are rounded up: at most a hundred operations, each right to 2^-53 of its terms.
ROUGHLY = 1e-12
#: Bits after the binary point of what is held as a whole number.
BITS = 192


def rounded(value: Fraction) -> int:
    """A ratio in units of 2^-BITS, off by less than one unit."""
    return floor(value * (1 << BITS))


def units(values: Ratios) -> Integers:
    """:func:`rounded` of an array."""
    found: Integers = np.asarray(np.frompyfunc(rounded, 1, 1)(values), dtype=object)
    return found


def floats(values: Ratios) -> Floats:
    """The nearest float64 of each."""
    return values.astype(np.float64)


def ratios(values: Iterable[Any]) -> Ratios:
    """An array of Fraction from numbers, or rows of them, each taken exactly."""
    found: Ratios = np.asarray(np.frompyfunc(Fraction, 1, 1)(np.array(list(values), dtype=object)), dtype=object)
    return found


def zeros(*shape: int) -> Ratios:
    """Fraction(0) everywhere."""
    return np.full(shape, Fraction(0), dtype=object)


def inverse(matrix: Ratios) -> Ratios:
    """The inverse of a matrix of ratios, shape (n, n).

    Raises
    ------
    ZeroDivisionError
        If it has none.
    """
    n = len(matrix)
    rows = [[*map(Fraction, row), *(Fraction(int(i == j)) for j in range(n))] for i, row in enumerate(matrix)]
    for i in range(n):
        pivot = next((k for k in range(i, n) if rows[k][i] != 0), None)
        if pivot is None:
            raise ZeroDivisionError("a singular matrix")
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for k in range(n):
            if k != i:
                rows[k] = [a - rows[k][i] * b for a, b in zip(rows[k], rows[i], strict=True)]
    return ratios(row[n:] for row in rows)
