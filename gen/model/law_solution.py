"""A network's differential equations where some paths have a law: integrated with control of the error, in float64.

Between two changes of the inputs the equations are smooth but where two ends of a path of natural convection have the
same temperature. The modified midpoint rule is extrapolated (Gragg, Bulirsch, Stoer; Hairer, Norsett and Wanner,
Solving Ordinary Differential Equations I, section II.9), over pieces of an interval that are as short as that needs.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gen.model.laws import Law
from gen.model.schedules import FloatArray

_HALVES = (2, 4, 6)
"""Parts of a piece in each row of the extrapolation."""
_LARGEST_ERROR = 2e-9
"""K, by which the last two columns of the extrapolation may differ; the last one is better by some 1e-2 at least."""
_FAR_BELOW = 1e-3
_SHORTEST = 2.0**-40
Rate = Callable[[FloatArray], FloatArray]


class LawFlow:
    """dT/dt of many lanes.

    Parameters
    ----------
    matrix, constant
        Of everything but the paths with a law: shapes (L, n, n) in 1/s, (L, n) in K/s, the ambient's part counted in.
    laws
        Of each path: its ends' positions among the states, None for the ambient, and its law.
    rates
        Of each path, at its first and its second end: conductance by capacity, 1/s, shape (L, paths, 2).
    ambient
        degC, shape (L,).
    """

    def __init__(
        self,
        matrix: FloatArray,
        constant: FloatArray,
        laws: list[tuple[int, int | None, Law]],
        rates: FloatArray,
        ambient: FloatArray,
    ) -> None:
        self._matrix, self._constant, self._laws, self._rates, self._ambient = matrix, constant, laws, rates, ambient

    def __call__(self, states: FloatArray) -> FloatArray:
        """K/s of states in degC, shape (L, n)."""
        made = np.matmul(self._matrix, states[..., None])[..., 0] + self._constant
        for k, (first, second, law) in enumerate(self._laws):
            other = self._ambient if second is None else states[:, second]
            driving = law.driving(states[:, first], other)
            made[:, first] -= self._rates[:, k, 0] * driving
            if second is not None:
                made[:, second] += self._rates[:, k, 1] * driving
        return np.asarray(made, dtype=np.float64)


def advanced(rate: Rate, states: FloatArray, length: NDArray[np.float64]) -> FloatArray:
    """Integrate every lane over its own interval.

    Parameters
    ----------
    rate
        K/s of states, shape (L, n) both.
    states
        At the beginning, degC.
    length
        s, shape (L,).

    Raises
    ------
    ValueError
        If no piece is short enough: the states run away.
    """
    at, piece = 0.0, 1.0
    while at < 1.0:
        piece = min(piece, 1.0 - at)
        with np.errstate(all="ignore"):  # too long a piece may overflow, and is halved
            made, off = _extrapolated(rate, states, length[:, None] * piece)
        if off <= _LARGEST_ERROR:
            states, at = made, at + piece
            piece *= 2.0 if off <= _LARGEST_ERROR * _FAR_BELOW else 1.0
        elif piece < _SHORTEST:
            raise ValueError("the network's temperatures run away")
        else:
            piece /= 2.0
    return states


def _extrapolated(rate: Rate, states: FloatArray, length: FloatArray) -> tuple[FloatArray, float]:
    """The change over one piece, and how far the last two columns are apart, K."""
    begin = rate(states)
    rows: list[FloatArray] = []
    apart = np.inf
    for row, parts in enumerate(_HALVES):
        one = _midpoint(rate, begin, states, length / parts, parts)
        made = [one]
        for column in range(row):
            share = (parts / _HALVES[row - 1 - column]) ** 2 - 1.0
            made.append(made[-1] + (made[-1] - rows[column]) / share)
        rows, apart = made, float(np.abs(made[-1] - made[-2]).max()) if row else np.inf
    return states + rows[-1], apart if np.isfinite(apart) else np.inf


def _midpoint(rate: Rate, begin: FloatArray, states: FloatArray, step: FloatArray, parts: int) -> FloatArray:
    """The change by the modified midpoint rule: increments, which keep their own relative precision."""
    before, change = np.zeros_like(states), step * begin
    for _ in range(parts - 1):
        before, change = change, before + 2.0 * step * rate(states + change)
    return np.asarray(0.5 * (before + change + step * rate(states + change)), dtype=np.float64)
