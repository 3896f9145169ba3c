"""A network's differential equations where some paths have a law: integrated with control of the error, in float64.

Between two changes of the inputs the equations are smooth but where two ends of a path of natural convection have the
same temperature. The modified midpoint rule is extrapolated (Gragg, Bulirsch, Stoer; Hairer, Norsett and Wanner,
Solving Ordinary Differential Equations I, section II.9), over pieces of an interval that are as short as that needs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.model.lane import Lane
from gen.model.laws import Law, LawsTogether

_HALVES = (2, 4, 6)
"""Parts of a piece in each row of the extrapolation."""
_LARGEST_ERROR = 2e-9
"""K, by which the last two columns of the extrapolation may differ; the last one is better by some 1e-2 at least."""
_FAR_BELOW = 1e-3
_SHORTEST = 2.0**-40
Rate = Callable[[FloatArray], FloatArray]


class LawFlow:
    """dT/dt of many lanes; the ambient is the last state, and stays.

    Parameters
    ----------
    matrix, constant
        Of everything but the paths with a law: shapes (L, n, n) in 1/s and (L, n) in K/s, the ambient's row zeros.
    paths
        Those with a law.
    rates
        What a path's heat does to each state: conductance by capacity, negative at its first end, 1/s, shape
        (L, n, paths).
    """

    def __init__(self, matrix: FloatArray, constant: FloatArray, paths: LawPaths, rates: FloatArray) -> None:
        self._matrix, self._constant, self._paths, self._rates = matrix, constant, paths, rates

    def lane(self, number: int) -> LawFlow:
        """One of the lanes, for states of shape (n,) or (.., n)."""
        return LawFlow(self._matrix[number], self._constant[number], self._paths, self._rates[number])

    @property
    def arrays(self) -> Lane:
        """What compiled steps need of one lane."""
        return Lane(self._matrix, self._constant, self._rates, *self._paths.arrays)

    def __call__(self, states: FloatArray) -> FloatArray:
        """K/s of states in degC, shape (L, n), or (.., n) of one lane."""
        driving = self._paths.driving(states)
        made = self._matrix @ states[..., None] + self._rates @ driving[..., None]
        return np.asarray(made[..., 0] + self._constant, dtype=np.float64)


class LawPaths:
    """Paths with a law: between which states, and which law.

    Parameters
    ----------
    first, second
        Of each path: its ends' positions among the states.
    laws
        Of each path.
    """

    def __init__(self, first: Sequence[int], second: Sequence[int], laws: Sequence[Law]) -> None:
        self._first, self._second = np.array(first, dtype=np.int64), np.array(second, dtype=np.int64)
        self._laws = LawsTogether(laws)

    @property
    def arrays(self) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Both ends' positions, and the laws as in `LawsTogether.arrays`."""
        return self._first, self._second, *self._laws.arrays

    def driving(self, states: FloatArray) -> FloatArray:
        """What drives heat through each path, K, of states in degC, shape (.., n) to (.., paths)."""
        return self._laws.driving(states[..., self._first], states[..., self._second])


def advanced(rate: Rate, states: FloatArray, length: FloatArray) -> FloatArray:
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

    def piece(states: FloatArray, share: float) -> tuple[FloatArray, float]:
        with np.errstate(all="ignore"):  # too long a piece may overflow, and is halved
            return _extrapolated(rate, states, length[:, None] * share)

    return _in_pieces(piece, states)


def advanced_alone(rate: LawFlow, states: FloatArray, length: float) -> FloatArray:
    """Integrate one lane, states of shape (n,), over an interval of so many s, compiled; else as :func:`advanced`."""
    from gen.model.law_steps import extrapolated  # slow to import

    def piece(states: FloatArray, share: float) -> tuple[FloatArray, float]:
        change = np.empty_like(states)
        off = extrapolated(states, length * share, np.array(_HALVES), rate.arrays, change)
        return states + change, off

    return _in_pieces(piece, states)


def _in_pieces(piece: Callable[[FloatArray, float], tuple[FloatArray, float]], states: FloatArray) -> FloatArray:
    """Go on by shares of an interval that are as short as the error needs; `piece` gives the states and that, K."""
    at, share = 0.0, 1.0
    while at < 1.0:
        share = min(share, 1.0 - at)
        made, off = piece(states, share)
        if off <= _LARGEST_ERROR:
            states, at = made, at + share
            share *= 2.0 if off <= _LARGEST_ERROR * _FAR_BELOW else 1.0
        elif share < _SHORTEST:
            raise ValueError("the network's temperatures run away")
        else:
            share /= 2.0
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
