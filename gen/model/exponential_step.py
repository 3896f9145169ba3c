"""One interval of equations that are nearly linear: the linear part exact, the rest by a polynomial over the interval.

A run is thousands of rows, a few seconds each, over which a network's temperatures move little: by its derivatives
where it was some rows ago the right side is linear but for a small rest. That is found at a third, two thirds and the
end of a row, each time from where the thirds before it lead, and laid through them as a polynomial, of which the
exponential of the linear part is integrated exactly (exponential Runge-Kutta methods: Hochbruck and Ostermann, Acta
Numerica 19, 2010, section 2.3).
"""

from __future__ import annotations

from math import factorial

import numpy as np

from gen.arrays import FloatArray
from gen.model.law_solution import LawFlow
from gen.model.law_steps import exponential

_LARGEST_OFF = 2e-11
"""K, by which the end may move from a polynomial of degree 2, extrapolated, to one of degree 3: what rows err by
adds up over as many of them as temperatures take to settle."""
_WAIT = 16
"""Rows before steps of a length are tried again that were too long by the derivatives of their own beginning."""
_APART_K = 1e-2
"""What derivatives are differences over."""


class ExponentialStep:
    """Steps of one length, by the derivatives at one state.

    Parameters
    ----------
    rate
        One lane.
    states
        Where the derivatives are taken, shape (n,).
    length
        s.
    """

    def __init__(self, rate: LawFlow, states: FloatArray, length: float) -> None:
        moved = rate(states + _APART_K * np.eye(states.size)) - rate(states)
        self._jacobian = moved.T / _APART_K
        size = states.size
        self._linear, self._rest = np.empty((3, size, size)), np.zeros((3, size, 2 * size))
        for row, thirds in enumerate((1, 2, 3)):
            functions = _phi(self._jacobian, length * thirds / 3.0, thirds)
            self._linear[row] = functions[0]
            self._rest[row, :, : row * size] = _through(thirds - 1, functions, thirds)
        self._last = _through(3, _phi(self._jacobian, length, 4), 3)

    def __call__(self, rate: LawFlow, states: FloatArray) -> tuple[FloatArray, bool]:
        """Step.

        Parameters
        ----------
        rate
            One lane; it need not be that of the derivatives.
        states
            At the beginning, degC, shape (n,).

        Returns
        -------
        states, good
            At the end; and whether the rest was smooth enough.
        """
        made = np.empty_like(states)
        off = exponential(states, self._jacobian, self._linear, self._rest, self._last, rate.arrays, made)
        return made, off <= _LARGEST_OFF


class RowSteps:
    """Steps of a run's rows, one after another: derivatives of one row serve for rows like it, while they are good."""

    def __init__(self) -> None:
        self._known: dict[tuple[float, float], ExponentialStep | None] = {}
        self._waits: dict[tuple[float, float], int] = {}

    def __call__(self, rate: LawFlow, counts: float, states: FloatArray, length: float) -> FloatArray | None:
        """Step, or give nothing where it takes another method: a length that never came before, or one too long.

        Parameters
        ----------
        rate
            One lane.
        counts
            |PWM|, by which rows are alike; channels may differ, as they change derivatives by little.
        states
            At the beginning, degC, shape (n,).
        length
            s.
        """
        key = (counts, length)
        if key not in self._known:
            self._known[key] = None  # what comes once is not worth its matrices
            return None
        if self._waits.get(key, 0):
            self._waits[key] -= 1
            return None
        step = self._known[key]
        if step is not None:
            made, good = step(rate, states)
            if good:
                return made
        step = self._known[key] = ExponentialStep(rate, states, length)
        made, good = step(rate, states)
        if not good:
            self._waits[key] = _WAIT
        return made if good else None


def _through(count: int, functions: list[FloatArray], thirds: int) -> FloatArray:
    """What values at so many first thirds, 0 at the beginning, do until the last of `thirds`, shape (n, n * count).

    The polynomial through them is the sum of d_k (t / s)^k, s the interval; of each the integral against the
    exponential is k! s phi_(k+1)(s M).
    """
    powers = np.arange(1, count + 1)
    coefficients = np.linalg.inv((np.arange(1, count + 1)[:, None] / thirds) ** powers) if count else np.zeros((0, 0))
    scaled = np.array([factorial(k) * functions[k] for k in powers]).reshape(count, *functions[0].shape)
    by_value = np.einsum("kv,kij->ivj", coefficients, scaled)
    return np.asarray(by_value.reshape(len(functions[0]), -1))


def _phi(matrix: FloatArray, length: float, most: int) -> list[FloatArray]:
    """h phi_1(h M) .. h phi_k(h M): blocks of one exponential (Al-Mohy and Higham, SIAM J. Sci. Comp. 33, 2011)."""
    from scipy.linalg import expm  # slow to import, and of no use where no path has a law

    n = len(matrix)
    grown = np.zeros((n * (most + 1), n * (most + 1)))
    grown[:n, :n] = length * matrix
    for k in range(most):
        grown[n * k : n * (k + 1), n * (k + 1) : n * (k + 2)] = np.eye(n)
    made = expm(grown)
    return [length * made[:n, n * (k + 1) : n * (k + 2)] for k in range(most)]
