"""Arrays of whole numbers and of ratios, none of which is ever rounded but where it says so."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypeAlias

import gmpy2
import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray

if TYPE_CHECKING:
    from fractions import Fraction

    Ratio: TypeAlias = Fraction  # which it is like, in all that is asked of it here
else:
    #: A ratio of two whole numbers, exactly: GMP's, with which a proof takes about a third of the time.
    Ratio = gmpy2.mpq

#: Arrays of Python's int and of `Ratio`: numpy's object arrays.
Integers = NDArray[Any]
Ratios = NDArray[Any]

#: Share by which float64 results are rounded up: at most a hundred operations, each right to 2^-53 of its terms.
ROUGHLY = 1e-12
#: Bits after the binary point of what is held as a whole number.
BITS = 192


def rounded(value: Ratio) -> int:
    """A ratio in units of 2^-BITS, off by less than one unit."""
    return int(value.numerator << BITS) // int(value.denominator)


def units(values: Ratios) -> Integers:
    """:func:`rounded` of an array."""
    found: Integers = np.asarray(np.frompyfunc(rounded, 1, 1)(values), dtype=object)
    return found


def floats(values: Ratios) -> FloatArray:
    """The nearest float64 of each."""
    return values.astype(np.float64)


def ratios(values: Iterable[Any]) -> Ratios:
    """An array of Ratio from numbers, or rows of them, each taken exactly."""
    found: Ratios = np.asarray(np.frompyfunc(Ratio, 1, 1)(np.array(list(values), dtype=object)), dtype=object)
    return found


def zeros(*shape: int) -> Ratios:
    """Ratio(0) everywhere."""
    return np.full(shape, Ratio(0), dtype=object)


def inverse(matrix: Ratios) -> Ratios:
    """The inverse of a matrix of ratios, shape (n, n).

    Raises
    ------
    ZeroDivisionError
        If it has none.
    """
    n = len(matrix)
    rows = [[*map(Ratio, row), *(Ratio(int(i == j)) for j in range(n))] for i, row in enumerate(matrix)]
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
