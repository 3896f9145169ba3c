"""The worst error of the float32 recursion, for any PWM sequence of any length.

Roundings: a float operation by at most half a unit in the last place of the largest value that it can have
(:func:`half_ulp`); a word that is read lacks its accumulator's 8 low bits and is rounded to 24 bits; an addition to an
accumulator drops less than its lowest bit.  (Subnormal results would add 2^-150 at most and are left out; NaN and
infinities cannot occur.)  The invariant polytope bounds the values, and what the roundings can add up to.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.float32.component import CARRY, LOW_BITS, FloatComponent
from gen.lowering.float32.ranges import WIDENING, Magnitudes, Reachable
from gen.lowering.float32.start import ambient_error, start_error
from gen.lowering.recursion import bounds, increments
from gen.lowering.recursion.bounds import WorstError
from gen.lowering.recursion.dynamics import Dynamics
from gen.lowering.recursion.guarantee import Proof
from gen.lowering.recursion.no_proof import NoProofError

#: A computed magnitude may exceed the exact one's bound by its own rounding; this covers that generously.
INFLATION = 1.0 + 1e-5
#: Largest relative rounding of one float32 operation.
_RELATIVE = 2.0**-24


def half_ulp(magnitude: FloatArray | float) -> FloatArray:
    """Largest rounding error of one float32 operation whose exact result is at most ``magnitude``."""
    inflated = np.maximum(np.asarray(magnitude, dtype=np.float64) * INFLATION, 1e-37)
    result: FloatArray = 2.0 ** (np.floor(np.log2(inflated)) - 24.0)
    return result


def word_ranges(exact: Dynamics, sizes: Magnitudes) -> FloatArray:
    """Largest magnitude that the words of x1 .. xn must hold, with S and S - x1, shape (n,), in K per sample^k."""
    needed: FloatArray = (sizes.state + sizes.added()) * INFLATION
    needed[0] = max(needed[0], float(sizes.inner[:, 0].max()) * INFLATION, _largest_steady(exact))
    return needed


def _largest_steady(exact: Dynamics) -> float:
    """Largest magnitude of what x1 settles to, whatever the ambient, in K."""
    return max(float(np.abs(exact.steady + end).max()) for end in exact.over)


def prove(lowered: FloatComponent, reachable: Reachable, sizes: Magnitudes) -> Proof:
    """Proof of ranges and error.

    Raises
    ------
    NoProofError
        If a range does not fit its word, if the recursion has no invariant polytope, or if the error is too large for
        the ranges that it rests on.
    """
    exact = reachable.exact
    n = exact.order
    units = 2.0 ** -np.array(lowered.fraction_bits, dtype=np.float64)
    held = word_ranges(exact, sizes) + units * (1 << LOW_BITS)  # S is rounded to 256 units
    if np.any(held >= (2.0**31 - 1.0) * units):
        raise NoProofError("the ranges that its states can reach do not fit their words")
    board_c = increments.from_rates(lowered.rates.astype(np.float64))
    q_error = reachable.functional(board_c - exact.c) + _rounding_of_q(lowered, exact, sizes, units)
    chain_error = np.tile(_chain_error(n, sizes, units), (len(q_error), 1))
    carried = np.zeros_like(chain_error)
    if n > 1:
        share, most, lowest = np.maximum(board_c, exact.c)[:, n - 2], sizes.carried, units[n - 2] / 2**LOW_BITS
        # What one change carries: both q's errors, 1/12, three operations, and the implicit factor.
        changed = np.abs(board_c - exact.c)[:, n - 2]  # one of both q is of a state without its share of the carry
        wrong = q_error + float(q_error.max()) + (changed + changed.max()) * most
        wrong = (wrong + half_ulp(12.0 * most)) * float(CARRY) * INFLATION
        carried[:, n - 2] = wrong + half_ulp(most) + most * _RELATIVE + share * most / 12.0 + lowest
        # The correction of q for it: two products and a difference, and the carry's own last bit.
        q_error = q_error + changed * most + half_ulp(sizes.q)
        q_error += share * (2.0 * _RELATIVE * most + lowest)
    error = _worst_error(
        reachable, q_error, chain_error, carried, start_error(lowered.fraction_bits[0], lowered.start_range_mK)
    )
    return Proof(
        rise_range_K=sizes.rise,
        increment_range_K=tuple(float(v) for v in sizes.state[1:]),
        bound_K=error.bound_K + float(units[0]),  # what is read out lacks the low bits
        invariant=bounds.invariant(reachable.recursion, exact, error.reach),
    )


def _chain_error(order: int, sizes: Magnitudes, units: FloatArray) -> FloatArray:
    """Rounding of one sample's additions into each state but the carry's own, shape (n,)."""
    lowest = units / 2**LOW_BITS
    error: FloatArray = lowest.copy()
    for i in range(1, order):  # x[i] is read before it is added; the last addition is q's
        error[i - 1] += units[i] + half_ulp(sizes.state[i])
    if order == 2:  # q/2 apart
        error[0] += lowest[0]
    if order == 4:  # x3/2 apart
        error[0] += lowest[0] + (units[2] + half_ulp(sizes.state[2])) / 2.0
    return error


def _rounding_of_q(lowered: FloatComponent, exact: Dynamics, sizes: Magnitudes, units: FloatArray) -> FloatArray:
    """Rounding of q's operations and of S, shape (rows,)."""
    n = lowered.order
    rates = np.maximum(lowered.rates.astype(np.float64), exact.rates)
    error: FloatArray = half_ulp(sizes.inner[:, 0]) + units[0] + np.abs(lowered.steady * units[0] - exact.steady)
    error = error + ambient_error(lowered.fraction_bits[0], exact.over_range_mK)
    for i in range(n):
        error = rates[:, i] * error + half_ulp(rates[:, i] * sizes.inner[:, i])
        if i + 1 < n:
            error = error + units[i + 1] + half_ulp(sizes.state[i + 1]) + half_ulp(sizes.inner[:, i + 1])
    return error


def _worst_error(
    reachable: Reachable, q_error: FloatArray, chain_error: FloatArray, carried: FloatArray, start_error: float
) -> WorstError:
    """Largest ``|x1 - T|`` in K, as :func:`gen.lowering.recursion.bounds.worst_error` with per-functional ranges."""
    exact = reachable.exact
    n, rows = exact.order, len(exact.steady)
    form_error = np.abs(increments.mismatch(exact.form, exact.exact, reachable.maps))
    form_rows = np.einsum("pij,pj->pi", form_error, reachable.true_distance())
    disturbance = np.zeros((rows, n + 2, n))
    disturbance[:, 0, :] = q_error[:, None] * increments.injection(n)
    for i in range(n):
        disturbance[:, 1 + i, i] = chain_error[:, i] + form_rows[:, i]
    start = np.zeros((1, n))
    start[0, 0] = start_error
    from_board: FloatArray = np.asarray(np.linalg.inv(reachable.maps), dtype=np.float64)
    generators = np.einsum("pij,pkj->pki", from_board, disturbance)
    generators[:, -1] = bounds.carried_over(exact, from_board, carried)
    error = reachable.recursion.bound(generators, start)
    extents = error.axes
    if np.any(extents > reachable.extents * WIDENING):
        raise NoProofError(bounds.TOO_LARGE)
    return WorstError.of(error, bounds.output_error(reachable.recursion, exact, reachable.maps))
