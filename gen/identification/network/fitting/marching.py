"""The recursions from bin to bin, and what each parameter adds within one: loops over small matrices, compiled.

Bins lie as in `inputs`: at step k the rows ``first[k]`` to ``first[k + 1]``, one for each run that still goes on, the
longest run first. Arrays are contiguous; what a function fills comes last.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray, SingleArray
from gen.compiled import compiled

ROUNDS = 4
"""Of what natural convection takes within a bin: each leaves a quarter of the error of the one before, or less."""


def excess_of(difference: FloatArray, factors: FloatArray, limit: float) -> FloatArray:
    """What drives heat beyond the difference itself, K: of an array or, compiled, of a number.

    Parameters
    ----------
    difference
        To the ambient, K.
    factors
        Of the polynomial over |d|, highest power first, shape (4,).
    limit
        What all beyond it counts as, K.
    """
    held = np.minimum(np.abs(difference), limit)
    a, b, c, d = factors
    excess: FloatArray = difference * (((a * held + b) * held + c) * held + (d - 1.0))
    return excess


# Here, and not with natural convection: what is kept of a function is made anew when its own file changes, not another.
_excess_of = compiled(excess_of)


@compiled
def _step(matrix: FloatArray, added: FloatArray, state: FloatArray, made: FloatArray) -> None:
    """Fill in ``matrix @ state + added``: matrices are small, so a loop does."""
    for i in range(state.size):
        total = added[i]
        for j in range(state.size):
            total += matrix[i, j] * state[j]
        made[i] = total


@compiled
def march(
    first: IntArray,
    level: IntArray,
    matrix: FloatArray,
    driven: FloatArray,
    start: FloatArray,
    before: FloatArray,
    after: FloatArray,
) -> None:
    """Fill in the temperatures at the beginning and at the end of each bin.

    Parameters
    ----------
    first, level
        See `Inputs`.
    matrix
        T -> T at each distinct input, shape (L, n, n).
    driven
        What ambient and heat add, shape (N, n), K.
    start
        In the order of the runs, shape (R, n), degC.
    before, after
        Shape (N, n), degC.
    """
    current = start.copy()
    for step in range(first.size - 1):
        for row in range(first[step], first[step + 1]):
            run = row - first[step]
            before[row] = current[run]
            _step(matrix[level[row]], driven[row], before[row], after[row])
            current[run] = after[row]


@compiled
def march_in_still_air(
    first: IntArray,
    level: IntArray,
    matrix: FloatArray,
    driven: FloatArray,
    start: FloatArray,
    gain: FloatArray,
    conductance: FloatArray,
    ambient: FloatArray,
    factors: FloatArray,
    limit: float,
    before: FloatArray,
    after: FloatArray,
) -> None:
    """Fill in the same with natural convection: a heat that goes with the mean of both ends of the bin.

    Parameters
    ----------
    first, level, matrix, driven, start, before, after
        As for `march`.
    gain
        Heat in W -> T at each distinct input, shape (L, n, n).
    conductance
        Of each node by natural convection, shape (L, n), W/K.
    ambient
        Shape (N,), degC.
    factors, limit
        Of `excess_of`; shape (4,).
    """
    nodes = start.shape[1]
    current, without, heat = start.copy(), np.empty(nodes), np.empty(nodes)
    for step in range(first.size - 1):
        for row in range(first[step], first[step + 1]):
            run, at = row - first[step], level[row]
            before[row] = current[run]
            _step(matrix[at], driven[row], before[row], without)
            after[row] = without
            for _ in range(ROUNDS):
                for i in range(nodes):
                    difference = 0.5 * (before[row, i] + after[row, i]) - ambient[row]
                    heat[i] = -conductance[at, i] * _excess_of(difference, factors, limit)
                _step(gain[at], without, heat, after[row])
            current[run] = after[row]


@compiled
def march_slopes(
    first: IntArray,
    level: IntArray,
    matrix: SingleArray,
    sources: SingleArray,
    share: SingleArray,
    lagging: IntArray,
    start: SingleArray,
    shown: SingleArray,
    changes: SingleArray,
) -> None:
    """Fill in the derivatives of the sensed nodes' temperatures at the readings' time.

    Parameters
    ----------
    first, level
        As for `march`; `level` says which matrix holds.
    matrix
        Shape (L, n, n).
    sources
        What each parameter adds within a bin, shape (N, n, p).
    share
        Where in the bin the readings' time lies, shape (N, S).
    lagging
        Sensed nodes of which the changes are wanted, shape (k,).
    start
        In the order of the runs, shape (R, n, p).
    shown
        Shape (N, S, p).
    changes
        From the beginning to the end of each bin, shape (N, k, p).
    """
    nodes, count = start.shape[1], start.shape[2]
    sensors = share.shape[1]
    current, old = start.copy(), np.empty((nodes, count), dtype=np.float32)
    for step in range(first.size - 1):
        for row in range(first[step], first[step + 1]):
            at = level[row]
            new = current[row - first[step]]
            old[:] = new
            new[:] = sources[row]
            for i in range(nodes):
                for j in range(nodes):
                    each = matrix[at, i, j]
                    for c in range(count):
                        new[i, c] += each * old[j, c]
            for s in range(sensors):
                late = share[row, s]
                early = np.float32(1.0) - late
                for c in range(count):
                    shown[row, s, c] = early * old[s, c] + late * new[s, c]
            for k in range(lagging.size):
                changes[row, k] = new[lagging[k]] - old[lagging[k]]


@compiled
def units(
    level: IntArray,
    vectors: SingleArray,
    first: SingleArray,
    second: SingleArray,
    phi: SingleArray,
    root: SingleArray,
    ends: IntArray,
    modal: SingleArray,
    forced: SingleArray,
    rate: SingleArray,
    ambient: SingleArray,
    stored: SingleArray,
    flow: SingleArray,
    warmed: SingleArray,
    warmth: SingleArray,
) -> None:
    """Fill in what a unit of each capacity (its logarithm), conductance and heat adds to the temperatures in each bin.

    Parameters
    ----------
    level
        Shape (N,).
    vectors, phi
        Of the modes at each distinct input, shapes (L, n, n) and (L, n).
    first, second
        Divided differences of e^(lh) and of phi, shape (L, n, n).
    root
        Of the capacities, shape (n,).
    ends
        Both nodes of each path, -1 for the ambient, which stands second; shape (Q, 2).
    modal, forced, rate
        Temperatures at the beginning, what drives, and the change there, in modes, shape (N, n).
    ambient
        Shape (N,), degC.
    stored, flow, warmed
        By capacity, conductance (W/K) and heat (W), shapes (N, n, n), (N, n, Q) and (N, n, n).
    warmth
        By what a node's heat grows by with its temperature (W/K), shape (N, n, n), or (0, n, n): not wanted.
    """
    nodes, paths = root.size, ends.shape[0]
    zero = np.float32(0.0)
    own = np.empty((nodes, nodes), dtype=np.float32)
    inner, moved = np.empty_like(own), np.empty_like(own)
    along = np.empty(nodes, dtype=np.float32)
    for row in range(level.size):
        at = level[row]
        for i in range(nodes):
            for m in range(nodes):
                own[i, m] = vectors[at, i, m] / root[i]
                inner[i, m] = moved[i, m] = zero
            for j in range(nodes):
                state, drive = vectors[at, i, j] * modal[row, j], vectors[at, i, j] * forced[row, j]
                change = vectors[at, i, j] * rate[row, j]
                for m in range(nodes):
                    inner[i, m] += state * first[at, j, m] + drive * second[at, j, m]
                    moved[i, m] += change * first[at, j, m]
        for i in range(nodes):
            for x in range(nodes):
                a, b, c = zero, zero, zero
                for m in range(nodes):
                    each = own[x, m] * vectors[at, i, m]
                    a += each * moved[i, m]
                    b += each * phi[at, m]
                    c += each * inner[i, m]
                stored[row, x, i] = -a
                warmed[row, x, i] = b / root[i]
                if warmth.shape[0]:
                    warmth[row, x, i] = c / (root[i] * root[i])
        # A path takes heat where it is warmer; from the ambient it gives some back.
        for q in range(paths):
            i, j = ends[q]
            for m in range(nodes):
                if j < 0:
                    along[m] = own[i, m] * (phi[at, m] * ambient[row] - inner[i, m] / root[i])
                else:
                    along[m] = (own[j, m] - own[i, m]) * (inner[i, m] / root[i] - inner[j, m] / root[j])
            for x in range(nodes):
                total = zero
                for m in range(nodes):
                    total += own[x, m] * along[m]
                flow[row, x, q] = total
