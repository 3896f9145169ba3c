"""The exact solution in integers of 2^-200 K: matrix exponentials by their power series, one product a sample.

The state is (T, Ts T', Ts^2 T'', ..): continuous when PWM changes, and the only thing that the differential equation
has a memory of.  Each operation rounds by less than 2^-200 K, so that a hundred thousand samples leave 50 digits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.attack import schedules

BITS = 200
_ONE = 1 << BITS

Matrix = list[list[int]]


class ExactComponent:
    """One component's exact steps over the domain.

    Parameters
    ----------
    document
        The coefficient file, as JSON has it.
    index
        Which of its components.

    Attributes
    ----------
    order
        n.
    growth
        exp(A Ts) - I at each row of the domain, float64, shape (rows, n, n).
    steady
        Steady rises in K, shape (rows,).
    """

    def __init__(self, document: Mapping[str, Any], index: int) -> None:
        component = document["components"][index]
        self.order: int = component["order"]
        step = Fraction(float(document["sample_time_s"]))
        self._steps: list[Matrix] = []
        self._steady: list[int] = []
        for pwm in schedules.domain(document):
            found = schedules.coefficients(document, component, pwm)
            scaled = [_integer(Fraction(a) * step ** (k + 1)) for k, a in enumerate(found.denominator)]
            self._steps.append(_growth(scaled))
            self._steady.append(_integer(Fraction(found.steady)))
        self.growth: NDArray[np.float64] = np.array(
            [[[kelvins(v) for v in row] for row in matrix] for matrix in self._steps]
        )
        self.steady: NDArray[np.float64] = np.array([kelvins(v) for v in self._steady])

    def rises(self, start_mK: int, rows: Sequence[int]) -> list[int]:
        """Rise before the first sample and after each, in 2^-200 K, from rest."""
        n = self.order
        state = [_integer(Fraction(start_mK, 1000))] + [0] * (n - 1)
        rises = [state[0]]
        for row in rows:
            away = [state[0] - self._steady[row], *state[1:]]
            state = [
                value + (sum(g * a for g, a in zip(line, away, strict=True)) >> BITS)
                for value, line in zip(state, self._steps[row], strict=True)
            ]
            rises.append(state[0])
        return rises


def kelvins(value: int) -> float:
    """An integer of 2^-200 K in K."""
    return float(Fraction(value, _ONE))


def _growth(alpha: Sequence[int]) -> Matrix:
    """exp(M) - I for the companion matrix of s^n + alpha1 s^(n-1) + .., all in 2^-200."""
    n = len(alpha)
    companion = [[_ONE if j == i + 1 else 0 for j in range(n)] for i in range(n - 1)]
    companion.append([-a for a in reversed(alpha)])
    total = [[0] * n for _ in range(n)]
    term = [[_ONE if i == j else 0 for j in range(n)] for i in range(n)]
    k = 0
    while any(abs(v) > 1 for row in term for v in row):  # floors end at -1, not at 0
        k += 1
        term = [[(sum(row[m] * companion[m][j] for m in range(n)) >> BITS) // k for j in range(n)] for row in term]
        total = [[t + v for t, v in zip(a, b, strict=True)] for a, b in zip(total, term, strict=True)]
    return total


def _integer(value: Fraction) -> int:
    return round(value * _ONE)
