"""Steps of one lane of a network whose paths have laws, compiled: a run is thousands of them, one after another.

What they do is said where they are called: in :mod:`gen.model.exponential_step` and :mod:`gen.model.law_solution`.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.compiled import compiled
from gen.model.lane import Lane
from gen.model.laws import ZERO_C


@compiled
def _rate(
    states: FloatArray,
    lane: Lane,
    made: FloatArray,
) -> None:
    """Fill in dT/dt, K/s, shape (n,), of states in degC, shape (n,)."""
    matrix, constant, rates, first, second, polynomials, radiating = lane
    size = states.size
    for i in range(size):
        total = constant[i]
        for j in range(size):
            total += matrix[i, j] * states[j]
        made[i] = total
    for path in range(first.size):
        one, other = states[first[path]], states[second[path]]
        difference = one - other
        factor = 0.0
        for power in range(polynomials.shape[0]):
            factor = factor * abs(difference) + polynomials[power, path]
        if radiating[path] != 0.0:
            warm, cold = one + ZERO_C, other + ZERO_C
            factor += radiating[path] * ((warm + cold) * (warm * warm + cold * cold))
        for i in range(size):
            made[i] += rates[i, path] * (difference * factor)


@compiled
def exponential(
    states: FloatArray,
    jacobian: FloatArray,
    linear: FloatArray,
    weights: FloatArray,
    last: FloatArray,
    lane: Lane,
    made: FloatArray,
) -> float:
    """Fill in the states at the end, shape (n,), and give what the last third moved them by, K.

    Parameters
    ----------
    states
        At the beginning, degC, shape (n,).
    jacobian
        Shape (n, n), 1/s.
    linear, weights
        For each third what the rate at the beginning, and what the rest so far, do; shapes (3, n, n) and (3, n, 2 n).
    last
        The same of the rest at all thirds, shape (n, 3 n).
    lane
        What is followed.
    made
        What is filled in.
    """
    size = states.size
    begin, now, then = np.empty(size), np.empty(size), np.empty(size)
    rest, change = np.zeros(3 * size), np.empty(size)
    for place in range(4):
        if place:
            for i in range(size):
                total = 0.0
                for j in range(size):
                    total += linear[place - 1, i, j] * begin[j]
                for j in range((place - 1) * size):
                    total += weights[place - 1, i, j] * rest[j]
                change[i] = total
                now[i] = states[i] + total
        else:
            now[:] = states
        _rate(now, lane, then)
        if place == 0:
            begin[:] = then
            continue
        for i in range(size):
            total = then[i] - begin[i]
            for j in range(size):
                total -= jacobian[i, j] * change[j]
            rest[(place - 1) * size + i] = total
    off = 0.0
    for i in range(size):
        total = 0.0
        for j in range(size):
            total += linear[2, i, j] * begin[j]
        for j in range(3 * size):
            total += last[i, j] * rest[j]
        off = max(off, abs(total - change[i])) if total == total else np.inf
        made[i] = states[i] + total
    return off


@compiled
def extrapolated(
    states: FloatArray,
    length: float,
    halves: IntArray,
    lane: Lane,
    made: FloatArray,
) -> float:
    """Fill in the change over one piece, K, shape (n,), and give how far the last two columns are apart, K.

    Parameters
    ----------
    states
        At the beginning, degC, shape (n,).
    length
        s.
    halves
        Parts of the piece in each row of the extrapolation.
    lane
        What is followed.
    made
        What is filled in.
    """
    size, count = states.size, halves.size
    begin, then, now = np.empty(size), np.empty(size), np.empty(size)
    before, change = np.empty(size), np.empty(size)
    columns, old = np.empty((count, size)), np.empty((count, size))
    _rate(states, lane, begin)
    for row in range(count):
        parts = halves[row]
        step = length / parts
        before[:] = 0.0
        change[:] = step * begin
        for part in range(parts):
            now[:] = states + change
            _rate(now, lane, then)
            for i in range(size):
                if part + 1 == parts:
                    change[i] = 0.5 * (before[i] + change[i] + step * then[i])
                else:
                    before[i], change[i] = change[i], before[i] + 2.0 * step * then[i]
        old[:] = columns
        columns[0] = change
        for column in range(row):
            share = (parts / halves[row - 1 - column]) ** 2 - 1.0
            columns[column + 1] = columns[column] + (columns[column] - old[column]) / share
    made[:] = columns[count - 1]
    off = 0.0
    for i in range(size):
        apart = abs(columns[count - 1, i] - columns[count - 2, i])
        off = max(off, apart) if apart == apart else np.inf
    return off
