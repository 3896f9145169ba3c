"""Ranges and worst errors of one component's recursion, for any PWM sequence in the domain.

Let z be the true state (T, Ts T', Ts^2 T'', ..), which obeys z -> E(p) (z - s) + s with E = exp(A Ts), and x the
board's state, which obeys x -> F (x - s) + s + (rounding).  With x - s = M(p) (y - s)
(:mod:`gen.lowering.recursion.increments`) the board's state is a disturbed copy y of the true one,

    y -> E (y - s) + s + M^-1 [ (F M - M E) (y - s) + dF (x - s) + rounding ],

dF being the change of F by rounded coefficients, and nothing happens to y at a change of PWM but the carry's
rounding.  The error y - z therefore obeys z's own recursion, disturbed by the bracket, and one invariant polytope
(:mod:`gen.lowering.recursion.reach`) bounds it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.recursion import increments
from gen.lowering.recursion.dynamics import Dynamics
from gen.lowering.recursion.guarantee import Invariant
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.lowering.recursion.reach_set import ReachSet

#: The error itself may widen the ranges by this share; checked when the error is known.
_WIDENING = 1e-3
#: Why there is no proof where roundings add up to more than that share.
TOO_LARGE = "its roundings can add up to more than a thousandth of its ranges"
#: The same for the states' polytope, whose drive both derive from the same equation.
_FLOAT64 = 2.0**-20
#: By which share polytopes are wider than float64 found them: what the certificate's own derivation counts differently.
_MARGIN = 2.0**-9
#: By how much ranges are widened for a component whose ranges cannot be proven.
_UNPROVEN_HEADROOM = 4.0
#: A response is looked at every so many of its slowest time constants, and so often.
_STRIDE, _STRIDES = 0.002, 4000


@dataclass(frozen=True)
class StateRanges:
    """What the board's state can reach.

    Attributes
    ----------
    rise
        Lowest and highest x1, in K.
    magnitude
        Largest |x| of every coordinate, shape (n,), in K per sample^k.
    distance
        Largest |x - s| of every coordinate at every PWM, shape (rows, n).
    true_distance
        The same of the disturbed copy y of the true state.
    """

    rise: tuple[float, float]
    magnitude: FloatArray
    distance: FloatArray
    true_distance: FloatArray


def state_ranges(recursion: SwitchedRecursion, exact: Dynamics) -> StateRanges:
    """Ranges of the state for starts and steady rises of the domain.

    Raises
    ------
    NoProofError
        If the recursion has no invariant polytope.
    """
    reach = _state_reach(recursion, exact)
    extents = reach.axes * (1.0 + _WIDENING)
    return _ranges(exact, extents)


@dataclass(frozen=True)
class InnerRanges:
    """What the nested evaluation of q meets on its way, in K per sample^k.

    Attributes
    ----------
    sums
        Largest magnitude of what each rate multiplies, (x1 - S), x2 + R0 (x1 - S) .., shape (n,).
    products
        Largest magnitude of what each x[i] is added to, a rate times the sum before it, shape (n,); 0 for x1.
    drive
        Largest |q|.
    """

    sums: FloatArray
    products: FloatArray
    drive: float

    @property
    def largest(self) -> FloatArray:
        """The larger of sum and product at each place, shape (n,)."""
        return np.maximum(self.sums, self.products)


def inner_ranges(recursion: SwitchedRecursion, exact: Dynamics) -> InnerRanges:
    """Ranges of the nested sums, read off the polytope in each one's own direction.

    Their terms are not at their largest together: while the rise is far from S, x2 moves it there.

    Raises
    ------
    NoProofError
        If the recursion has no invariant polytope.
    """
    reach = _state_reach(recursion, exact)
    n = exact.order
    # The board's error, coordinate by coordinate: worst_error allows no more.
    error = _WIDENING * _ranges(exact, reach.axes).true_distance.min(axis=0)
    widening = np.abs(exact.state_maps()) @ error

    def largest(directions: FloatArray) -> float:
        true = np.einsum("pi,pij->pj", directions, exact.state_maps())
        away = np.abs(true[:, 0]) * exact.away
        return float((reach.extents(true) + away + np.einsum("pi,pi->p", np.abs(directions), widening)).max())

    sums, products = np.zeros(n), np.zeros(n)
    directions = np.zeros((len(exact.steady), n))
    for i in range(n):
        directions[:, i] = 1.0
        sums[i] = largest(directions)
        directions *= exact.rates[:, i : i + 1]
        if i + 1 < n:
            products[i + 1] = largest(directions)
    drive = largest(directions)
    if n > 1:  # at a change of PWM the new q is computed before x[n-1] has taken over its share of the change
        share = 2.0 * increments.CARRY
        drive /= 1.0 - share * exact.c[:, n - 2].max()
        sums[n - 2] += share * drive
        products[n - 1] += exact.rates[:, n - 2].max() * share * drive
        sums[n - 1] += exact.rates[:, n - 2].max() * share * drive
    return InnerRanges(sums, products, drive)


def _state_reach(recursion: SwitchedRecursion, exact: Dynamics) -> ReachSet:
    """What the true state, less the centre, can reach."""
    n = exact.order
    towards = (np.eye(n) - exact.exact)[:, :, 0] * exact.away[:, None]  # of either sign
    start = np.zeros((1, n))
    start[0, 0] = max(exact.start[1] - exact.centre, exact.centre - exact.start[0])
    return recursion.bound(towards[:, None, :], start)


def unproven_ranges(exact: Dynamics) -> StateRanges:
    """Ranges with room, from what each PWM alone can do, for a component that has to saturate."""
    spread = np.abs(np.subtract.outer(exact.steady, exact.start)).max(axis=1) + np.ptp(exact.steady)
    spread = spread + (exact.over[1] - exact.over[0])
    largest = (_peak_response(exact.exact) * spread[:, None]).max(axis=0)
    return _ranges(exact, largest * _UNPROVEN_HEADROOM)


@dataclass(frozen=True)
class WorstError:
    """What the board's state can be off by.

    Attributes
    ----------
    bound_K
        Largest |x1 - T|, in K.
    reach
        Encloses the error of the disturbed copy y of the true state.
    """

    bound_K: float
    reach: ReachSet

    @classmethod
    def of(cls, error: ReachSet, output_K: float) -> WorstError:
        """The error's polytope, a little wider, and the bound that follows; a wider polytope is invariant, too."""
        wider = replace(error, height=error.height * (1.0 + _MARGIN))
        return cls(float(wider.axes[0]) + output_K * (1.0 + _MARGIN), wider)


def invariant(recursion: SwitchedRecursion, exact: Dynamics, error: ReachSet) -> Invariant:
    """The polytopes of the state and of its error, for a checker."""
    constant = increments.constant_map(exact.order) if exact.constant_map is None else exact.constant_map
    reach = _state_reach(recursion, exact).height * (1.0 + _FLOAT64)
    return Invariant(error.directions, reach, error.height, exact.centre, constant, error.shape)


def worst_error(
    recursion: SwitchedRecursion,
    exact: Dynamics,
    ranges: StateRanges,
    *,
    changed_c: FloatArray,
    q_error: FloatArray,
    chain_error: FloatArray,
    start_error: float,
    carry_error: FloatArray | float = 0.0,
    carry: float = increments.CARRY,
) -> WorstError:
    """Largest |x1 - T| for any PWM sequence.

    Parameters
    ----------
    recursion, exact, ranges
        The component.
    changed_c
        Rounded minus exact C0..C[n-1], shape (rows, n).
    q_error, chain_error
        Bounds on one sample's rounding of q, shape (rows,), and of each x[i] by additions, shape (rows, n).
    start_error
        Bound on the rounding of the start value, in K.
    carry_error
        Bound on the rounding of what x[n-1] takes over at a change to each PWM, in K, shape (rows,) or one for all.
    carry
        Share of q that the board carries over at a change of PWM; 0 where nothing happens then.

    Returns
    -------
    WorstError

    Raises
    ------
    NoProofError
        If the recursion has no invariant polytope, or if the error is too large for the ranges that it rests on.
    """
    n, rows = exact.order, len(exact.steady)
    state_maps = exact.state_maps(carry)
    from_board: FloatArray = np.asarray(np.linalg.inv(state_maps), dtype=np.float64)
    disturbance = np.zeros((rows, 2 * n + 2, n))
    coefficients = np.einsum("pj,pj->p", np.abs(changed_c), ranges.distance)
    q_total = q_error + coefficients
    disturbance[:, 0, :] = q_total[:, None] * increments.injection(n)
    form_error = np.abs(increments.mismatch(exact.form, exact.exact, state_maps))
    form_rows = np.einsum("pij,pj->pi", form_error, ranges.true_distance)
    carried = np.zeros((rows, n))
    if n > 1:
        q_range = float(np.einsum("pj,pj->p", np.abs(exact.c), ranges.distance).max())
        most = 2.0 * carry * q_range / (1.0 - 2.0 * carry * exact.c[:, n - 2].max())
        # Evaluated before it acts: what it would change in itself. And both q come from the board's coefficients, at a
        # state that for one of them has not taken over its share yet.
        wrong = coefficients.max() + np.abs(changed_c[:, n - 2]).max() * most
        carried[:, n - 2] = carry_error + carry * (exact.c[:, n - 2].max() * most + 2.0 * wrong)
    for i in range(n):
        disturbance[:, 1 + i, i] = chain_error[:, i]
        disturbance[:, 1 + n + i, i] = form_rows[:, i]
    generators = np.einsum("pij,pkj->pki", from_board, disturbance)
    generators[:, -1] = carried_over(exact, from_board, carried)
    start = np.zeros((1, n))
    start[0, 0] = start_error
    error = recursion.bound(generators, start)
    extents = error.axes
    if np.any(extents > ranges.true_distance.min(axis=0) * _WIDENING / (1.0 + _WIDENING)):
        raise NoProofError(TOO_LARGE)
    return WorstError.of(error, output_error(recursion, exact, state_maps))


def output_error(recursion: SwitchedRecursion, exact: Dynamics, state_maps: FloatArray) -> float:
    """How far the board's x1 is from the rise where nothing is rounded: its share of the increments, in K.

    Raises
    ------
    NoProofError
        If the recursion has no invariant polytope.
    """
    reach = _state_reach(recursion, exact)
    beside = state_maps[:, 0, :] - np.eye(exact.order)[0]
    error = _WIDENING * _ranges(exact, reach.axes).true_distance.min(axis=0)
    away = np.abs(beside[:, 0]) * exact.away
    return float((reach.extents(beside) + away + np.abs(beside) @ error).max())


def carried_over(exact: Dynamics, from_board: FloatArray, carried: FloatArray) -> FloatArray:
    """What an error of the carry is after its sample, in the true state's coordinates, shape (rows, n).

    The carry comes before the sample, and is read with the new PWM's map: y moves by M^-1 times the error, and then
    the sample moves it on.

    Parameters
    ----------
    exact, from_board
        The component, and the M^-1 of the new PWM.
    carried
        The error of the board's state, shape (rows, n).
    """
    found: FloatArray = np.einsum("pij,pjk,pk->pi", exact.exact, from_board, carried)
    return found


def _ranges(exact: Dynamics, extents: FloatArray) -> StateRanges:
    true_distance = np.tile(extents, (len(exact.steady), 1))
    true_distance[:, 0] = extents[0] + exact.away
    # The share of q that a board carries is 1/12 but for its rounding, which moves nothing by more than the widening.
    distance = np.einsum("pij,pj->pi", np.abs(exact.state_maps()), true_distance)
    excess = float((distance[:, 0] - true_distance[:, 0]).max())  # x1 is T plus a little of the increments
    rise = (exact.centre - float(extents[0]) - excess, exact.centre + float(extents[0]) + excess)
    magnitude = distance.max(axis=0)
    magnitude[0] = max(abs(rise[0]), abs(rise[1]))
    return StateRanges(rise, magnitude, distance, true_distance)


def _peak_response(matrices: FloatArray) -> FloatArray:
    """Largest magnitude of each coordinate on the way from (1, 0, ..) to 0, for matrices and result of shape (m, n)."""
    slowest = np.asarray(-np.log(np.abs(np.linalg.eigvals(matrices))).min(axis=1), dtype=np.float64)
    strides = np.maximum(1, (_STRIDE / slowest).astype(np.int64))
    turns = np.stack([np.linalg.matrix_power(*pair) for pair in zip(matrices, strides.tolist(), strict=True)])
    state = np.tile(np.eye(matrices.shape[1])[0], (len(matrices), 1))
    peak: FloatArray = np.abs(state)
    for _ in range(_STRIDES):
        state = np.einsum("pij,pj->pi", turns, state)
        peak = np.maximum(peak, np.abs(state))
    return peak
