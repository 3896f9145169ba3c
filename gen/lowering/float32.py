"""Lower a component to float32: split states, thresholds, and the proof of its error.

Plain float32 accumulation stagnates: near 45 K an addition rounds by up to 2e-6 K, which a slow pole of 1.25e-4 per
sample turns into 0.015 K.  The board therefore keeps every state of the increment form
(:mod:`gen.lowering.increments`) as an unevaluated sum of two float32 words of which only the small one is
accumulated:

* x1 = S - base + low.  S (the steady rise at the present PWM) and base lie on a grid of 2^(b-24) K with
  ``|base| < 2^b`` proven, so every sum and difference among them is exact, also when S jumps with the PWM.  The
  difference that drives the component costs one operation, S - x1 = base - low.
* x2 .. xn = high + low, with high on a grid as well.

When ``|low|`` reaches its threshold, low is folded: its leading 8 significant bits (the upper half of the word, taken
by a mask) move to base or high.  That they are multiples of the grid is a condition on the threshold, so folding is
exact; and comparing the upper halves of the words with the threshold's replaces a float comparison.

Order 1 needs neither q nor its chain: low + R (base - low) = D low + R base with D = fl(1 - R), where R base is
computed only when base or R changes, so a sample is one product and one sum.

So only the accumulation into low, the sum high + low, and q's own operations round, each by at most half a unit in
the last place of the largest value that it can have (:func:`half_ulp`), and the invariant polytope bounds those
values.  (Subnormal results would add 2^-150 at most and are left out; NaN and infinities cannot occur.)

At a change of PWM, x[n-1] += (q_new - q_old)/12 with q_new taken *after* the carry (:func:`increments.state_map`
demands that).  The board carries with q_new from before, and then corrects q_new by -C[n-2] times what was carried,
which leaves a factor of 1 + C[n-2]/12 on the carry for the proof to count.

Where no range can be proven, float32 words cannot wrap round, but base and the high words are limited to stated
values when low is folded into them, and every limiting is counted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.lowering import bounds, increments
from gen.lowering.dynamics import Dynamics, LoweringError, dynamics
from gen.lowering.program import Proof
from gen.lowering.reach import NoProofError, ReachSet, SwitchedRecursion
from gen.lowering.substeps import fewest_substeps
from gen.model import Component, ThermalModel

Array = NDArray[np.float64]
Singles = NDArray[np.float32]

#: Shares of the error limit that accumulating one state may spend on rounding.  The largest with which the bound holds
#: is taken: larger thresholds fold less often.
_ROUNDING_SHARES = (0.03, 0.06, 0.12, 0.25, 0.5)
_UNPROVEN_SHARE = 0.25
#: Significant bits that folding moves: those of a float32's upper half.
_LEADING_BITS = 8
#: No threshold of x1 is larger, in K.
_LARGEST_THRESHOLD = 1.0
#: The error itself may widen the ranges by this share; checked when the error is known.
_WIDENING = 1e-3
#: A computed magnitude may exceed the exact one's bound by its own rounding; this covers that generously.
_INFLATION = 1.0 + 1e-5
#: 1/12 in float32, the share of q that x[n-1] carries.
CARRY = np.float32(1.0 / 12.0)


@dataclass(frozen=True)
class FloatComponent:
    """One component in float32.

    Attributes
    ----------
    name, order
        From the coefficient file.
    substeps
        How many times the recursion runs in one sample (its rates are for Ts / substeps).
    rates
        R0 .. R[n-1] for each row of the domain, shape (rows, n), dimensionless.
    steady
        S in K for each row, multiples of ``grid``, shape (rows,).
    range_bits
        b: base and x1 stay below 2^b K.
    thresholds
        Where the low word of x1 .. xn is folded, length n, in K per sample^k; at most 8 significant bits.
    limits
        Largest magnitude of base and of the high words of x2 .. xn, length n.  With a proof it is never reached (and
        not checked); without one the words are limited to it when they are folded.
    start_range
        Lowest and highest rise to start from, in K; others are clamped and flagged.
    proof
        None if no range could be proven.
    """

    name: str
    order: int
    substeps: int
    rates: Singles
    steady: Singles
    range_bits: int
    thresholds: tuple[float, ...]
    limits: tuple[float, ...]
    start_range: tuple[float, float]
    proof: Proof | None

    @property
    def saturates(self) -> bool:
        """Whether folding limits the high words because no range could be proven."""
        return self.proof is None

    @property
    def start_range_mK(self) -> tuple[int, int]:
        """Lowest and highest rise to start from, in thousandths of a kelvin."""
        return ceil(self.start_range[0] * 1000.0), floor(self.start_range[1] * 1000.0)

    def describe(self) -> dict[str, Any]:
        """Formats and proof for the manifest."""
        return {
            "name": self.name,
            "order": self.order,
            "substeps": self.substeps,
            "steady_grid_K": self.grid,
            "fold_thresholds": list(self.thresholds),
            "start_range_mK": list(self.start_range_mK),
            "proof": self.proof.describe() if self.proof else None,
        }

    @property
    def grid(self) -> float:
        """Spacing of S and base, in K."""
        return float(2.0 ** (self.range_bits - 24))

    @property
    def start_constant(self) -> float:
        """C of (v + C) - C, which rounds a start value v to a multiple of 4 grids for every ``|v|`` up to 2^b."""
        return float(1.5 * 2.0 ** (self.range_bits + 1))

    @property
    def steady_constant(self) -> float:
        """The same for S: rounds to 2 grids from 0 on and to 1 grid from -2^(b-1) to 0."""
        return float(2.0**self.range_bits)

    @property
    def threshold_words(self) -> tuple[int, ...]:
        """The upper 16 bits of the thresholds; the lower ones are 0, so comparing these compares magnitudes."""
        return tuple(int(np.float32(t).view(np.uint32)) >> 16 for t in self.thresholds)

    @staticmethod
    def literal(value: float) -> str:
        """A float32 in C++ source: 9 significant digits determine it (gnu++11 has no hexadecimal floats)."""
        text = f"{np.float32(value):.9g}"
        return f"{text if set(text) & set('.e') else text + '.0'}f"


@dataclass(frozen=True)
class FloatProgram:
    """The whole model in float32; row r of every table is ``|PWM|`` = domain_pwm[0] + r."""

    domain_pwm: tuple[int, int]
    components: tuple[FloatComponent, ...]


@dataclass(frozen=True)
class _Magnitudes:
    """Bounds on what the board computes with.

    ``rise`` is the range of x1 in K; ``state`` holds max ``|x|`` over all rows, shape (n,); ``inner`` the magnitudes of
    S - x1, of R0 times it less x2, .. before each product, shape (rows, n); ``q`` the increment, shape (rows,);
    ``carried`` the most that one change of PWM adds to x[n-1], in K.
    """

    rise: tuple[float, float]
    state: Array
    inner: Array
    q: Array
    carried: float


class _Reachable:
    """What the board's state can reach, read through linear functionals of x - s."""

    def __init__(self, recursion: SwitchedRecursion, exact: Dynamics) -> None:
        n = exact.order
        self.exact = exact
        self.recursion = recursion
        self.maps = increments.state_map(exact.c)
        towards = (np.eye(n) - exact.exact)[:, :, 0] * (exact.steady - exact.centre)[:, None]
        start = np.zeros((1, n))
        start[0, 0] = max(exact.start[1] - exact.centre, exact.centre - exact.start[0])
        self._reach: ReachSet = recursion.bound(towards[:, None, :], start)
        self.extents = np.array([self._reach.extent(axis) for axis in np.eye(n)])

    def true_distance(self) -> Array:
        """Largest ``|y - s|`` of the disturbed copy y of the true state, shape (rows, n)."""
        distance: Array = np.tile(self.extents * (1.0 + _WIDENING), (len(self.exact.steady), 1))
        distance[:, 0] += np.abs(self.exact.steady - self.exact.centre)
        return distance

    def functional(self, weights: Array) -> Array:
        """Bound of ``|weights . (x - s)|`` at every row, for weights of shape (rows, n)."""
        mapped = np.einsum("pi,pij->pj", weights, self.maps)
        settled: Array = np.abs(mapped[:, 0] * (self.exact.centre - self.exact.steady))
        result: Array = self._around_centre(mapped) + settled
        return result

    def rise(self) -> tuple[float, float]:
        """Range of x1, in K."""
        mapped = self.maps[:, 0, :]
        off = np.abs((mapped[:, 0] - 1.0) * (self.exact.centre - self.exact.steady))
        reach = float((self._around_centre(mapped) + off).max())
        return self.exact.centre - reach, self.exact.centre + reach

    def _around_centre(self, mapped: Array) -> Array:
        unique, place = np.unique(mapped, axis=0, return_inverse=True)
        extent = np.array([self._reach.extent(row) for row in unique])[place.ravel()]
        widened: Array = extent + _WIDENING * np.abs(mapped) @ self.extents
        return widened


def half_ulp(magnitude: Array | float) -> Array:
    """Largest rounding error of one float32 operation whose exact result is at most ``magnitude``."""
    inflated = np.maximum(np.asarray(magnitude, dtype=np.float64) * _INFLATION, 1e-37)
    result: Array = 2.0 ** (np.floor(np.log2(inflated)) - 24.0)
    return result


def lower_component(model: ThermalModel, component: Component, limit_K: float) -> FloatComponent:
    """Find thresholds, float32 tables and proof for one component.

    Parameters
    ----------
    model, component
        What to lower.
    limit_K
        The error bound to aim for; more substeps are tried until it holds.

    Raises
    ------
    LoweringError
        If the poles do not fit the sample time.
    """
    return fewest_substeps(
        component.order,
        limit_K,
        lambda substeps: _lower(component, dynamics(model, component, substeps), substeps, limit_K),
    )


def with_rows(lowered: FloatComponent, exact: Dynamics, rates: Singles, steady: Singles) -> FloatComponent:
    """The same component with given float32 rows, such as an onboard schedule computes, and their own proof.

    Parameters
    ----------
    lowered
        Gives thresholds, range and substeps.
    exact
        ``dynamics(model, component, lowered.substeps)``.
    rates, steady
        Shapes (rows, n) and (rows,); ``steady`` must lie on ``lowered.grid`` and below 2^b.

    Raises
    ------
    LoweringError
        If ``steady`` is off the grid, which would make base inexact.
    """
    scaled = steady.astype(np.float64) / lowered.grid
    if np.any(scaled != np.rint(scaled)) or np.any(np.abs(scaled) >= 2.0**24):
        raise LoweringError(f"component {lowered.name}: a steady rise lies off the grid of {lowered.grid} K")
    given = replace(lowered, rates=rates.astype(np.float32), steady=steady.astype(np.float32), proof=None)
    try:
        reachable = _Reachable(SwitchedRecursion(exact.exact), exact)
        changed = _changed_rates(given, reachable)
        return replace(given, proof=_prove(given, reachable, _magnitudes(reachable), changed))
    except NoProofError:
        return given


def _lower(component: Component, exact: Dynamics, substeps: int, limit_K: float) -> FloatComponent:
    reachable: _Reachable | None
    try:
        reachable = _Reachable(SwitchedRecursion(exact.exact), exact)
        sizes = _magnitudes(reachable)
    except NoProofError:
        reachable, sizes = None, _unproven_magnitudes(exact)
    lowered = _tabulate(component, exact, substeps, sizes)
    if reachable is None:
        thresholds, _ = _thresholds(exact, sizes, lowered, limit_K * _UNPROVEN_SHARE)
        return replace(lowered, thresholds=thresholds)
    choices = [_thresholds(exact, sizes, lowered, limit_K * share) for share in _ROUNDING_SHARES]
    return _with_thresholds(lowered, reachable, sizes, choices, limit_K)


def _with_thresholds(
    lowered: FloatComponent,
    reachable: _Reachable,
    sizes: _Magnitudes,
    choices: list[tuple[tuple[float, ...], float]],
    limit_K: float,
) -> FloatComponent:
    """Take the last choice of thresholds (in order of cost) whose bound holds; estimates save most proofs."""
    changed = _changed_rates(lowered, reachable)
    first, least = choices[0]
    lowered = replace(lowered, thresholds=first)
    try:
        lowered = replace(lowered, proof=_prove(lowered, reachable, sizes, changed))
        for thresholds, cost in reversed(choices[1:]):
            if lowered.proof is None or lowered.proof.bound_K + cost - least > limit_K:
                continue
            tried = replace(lowered, thresholds=thresholds)
            proof = _prove(tried, reachable, sizes, changed)
            if proof is not None and proof.bound_K <= limit_K:
                return replace(tried, proof=proof)
    except NoProofError:
        pass
    return lowered


def _tabulate(component: Component, exact: Dynamics, substeps: int, sizes: _Magnitudes) -> FloatComponent:
    """Tables and grids, without thresholds or proof."""
    largest = max(float(sizes.inner[:, 0].max()) + _LARGEST_THRESHOLD, abs(sizes.rise[0]), abs(sizes.rise[1]))
    bits = int(np.ceil(np.log2(largest * _INFLATION)))
    grid = 2.0 ** (bits - 24)
    return FloatComponent(
        name=component.name,
        order=component.order,
        substeps=substeps,
        rates=exact.rates.astype(np.float32),
        steady=(np.rint(exact.steady / grid) * grid).astype(np.float32),
        range_bits=bits,
        thresholds=(),
        limits=(2.0**bits - 4.0 * grid, *(float(np.float32(2.0 * x)) for x in sizes.state[1:])),
        start_range=_inward(exact.start),
        proof=None,
    )


def _inward(ends: tuple[float, float]) -> tuple[float, float]:
    """A range's ends in float32, not outside it."""
    low, high = np.float32(ends[0]), np.float32(ends[1])
    if float(low) < ends[0]:
        low = np.nextafter(low, np.float32(np.inf))
    if float(high) > ends[1]:
        high = np.nextafter(high, np.float32(-np.inf))
    return float(low), float(high)


def _partial(rates: Array, stage: int) -> Array:
    """Weights on x - s of what enters product ``stage``; stage n gives q (all up to sign), shape (rows, n)."""
    n = rates.shape[1]
    weights = np.zeros_like(rates)
    for j in range(min(stage, n - 1) + 1):
        weights[:, j] = np.prod(rates[:, j:stage], axis=1)
    return weights


def _magnitudes(reachable: _Reachable) -> _Magnitudes:
    exact = reachable.exact
    n, rows = exact.order, len(exact.steady)
    axes = [np.tile(axis, (rows, 1)) for axis in np.eye(n)]
    rise = reachable.rise()
    state = np.array([reachable.functional(axis).max() for axis in axes])
    state[0] = max(abs(rise[0]), abs(rise[1]))
    inner = np.stack([reachable.functional(_partial(exact.rates, k)) for k in range(n)], axis=1)
    q = reachable.functional(exact.c)
    return _with_carry(exact, _Magnitudes(rise, state, inner, q, 0.0))


def _unproven_magnitudes(exact: Dynamics) -> _Magnitudes:
    """Magnitudes with room, for a component whose ranges cannot be proven."""
    ranges = bounds.unproven_ranges(exact)
    inner = np.stack(
        [np.einsum("pj,pj->p", _partial(exact.rates, k), ranges.distance) for k in range(exact.order)],
        axis=1,
    )
    q = np.einsum("pj,pj->p", exact.c, ranges.distance)
    return _with_carry(exact, _Magnitudes(ranges.rise, ranges.magnitude, inner, q, 0.0))


def _with_carry(exact: Dynamics, sizes: _Magnitudes) -> _Magnitudes:
    """Add what the state may lack of its carry while q is first computed after a change of PWM."""
    n = exact.order
    if n == 1:
        return sizes
    carried = float(sizes.q.max()) / 6.0
    inner = sizes.inner.copy()
    state = sizes.state.copy()
    state[n - 2] += carried
    for k in range(n - 2, n):
        inner[:, k] += carried * _partial(exact.rates, k)[:, n - 2]
    return _Magnitudes(sizes.rise, state, inner, sizes.q + exact.c[:, n - 2] * carried, carried)


def _added(order: int, sizes: _Magnitudes) -> Array:
    """Most that one sample adds to each low word between two checks of its threshold, shape (rows, n)."""
    added = np.zeros((len(sizes.q), order))
    for i in range(1, order):
        added[:, i - 1] = sizes.state[i]
    added[:, order - 1] = sizes.q
    if order == 1:  # R base instead of R (base - low)
        added[:, 0] += _LARGEST_THRESHOLD * sizes.q / sizes.inner[:, 0]
    if order == 2:
        added[:, 0] += sizes.q / 2.0
    if order == 4:
        added[:, 0] += sizes.state[2] / 2.0
    if order > 1:
        added[:, order - 2] += sizes.carried
    return added


def _thresholds(
    exact: Dynamics, sizes: _Magnitudes, lowered: FloatComponent, tolerance: float
) -> tuple[tuple[float, ...], float]:
    """The largest thresholds with which accumulating costs no more than a tolerance in K each, and their sum.

    A rounding v of x[i+1] at every sample shifts the steady rise by v C[i+1]/C0 (C[n] = 1).  Where even the smallest
    possible threshold costs more than the tolerance, it is the largest that costs no more than that one.
    """
    n = exact.order
    after = np.hstack([exact.c[:, 1:], np.ones((len(exact.c), 1))]) / exact.c[:, :1]
    added = _added(n, sizes)
    operations = 3.0 if n == 1 else 1.0  # the product, D, and the sum
    chosen, total = [], 0.0
    for i in range(n):
        # The lowest of the leading bits must be a multiple of the grid, which is 2^-24 of the largest high word.
        finest = 2.0 ** (np.ceil(np.log2(lowered.limits[i])) - 24.0 + _LEADING_BITS - 1.0)
        above = int(np.log2(_LARGEST_THRESHOLD / finest))
        candidates = [_LARGEST_THRESHOLD * m * 2.0**-k for k in range(1, above + 1) for m in (2, 1.75, 1.5, 1.25)]
        candidates = [t for t in candidates if t >= finest] + [finest]
        cost = [operations * float((after[:, i] * half_ulp(added[:, i] + t)).max()) for t in candidates]
        allowed = max(tolerance, cost[-1])
        threshold, spent = next((t, c) for t, c in zip(candidates, cost, strict=True) if c <= allowed)
        chosen.append(threshold)
        total += spent
    return tuple(chosen), total


def _chain_error(lowered: FloatComponent, sizes: _Magnitudes) -> Array:
    """Rounding of one sample's additions into each state but the carry's own, shape (rows, n)."""
    n = lowered.order
    error = half_ulp(_added(n, sizes) + np.array(lowered.thresholds))
    if n == 1:  # D low + R base: D's own rounding and the product's
        threshold = lowered.thresholds[0]
        keep = (np.float32(1.0) - lowered.rates[:, 0]).astype(np.float64)
        off = np.abs(keep - (1.0 - lowered.rates[:, 0].astype(np.float64)))
        error[:, 0] += off * threshold + half_ulp(threshold)
    for i in range(1, n):  # x[i] = high + low is rounded before it is added
        error[:, i - 1] += half_ulp(sizes.state[i])
    if n == 2:
        error[:, 0] += half_ulp(sizes.state[1] + sizes.q / 2.0)
    if n == 4:
        error[:, 0] += half_ulp(sizes.state[2]) / 2.0 + half_ulp(sizes.state[1] + sizes.state[2] / 2.0)
    return error


def _rounding_of_q(lowered: FloatComponent, exact: Dynamics, sizes: _Magnitudes) -> Array:
    """Rounding of q's operations and of S, shape (rows,)."""
    n = lowered.order
    rates = np.maximum(lowered.rates.astype(np.float64), exact.rates)
    if n == 1:  # R base, and S in it
        wrong = np.abs(lowered.steady.astype(np.float64) - exact.steady)
        product: Array = rates[:, 0] * wrong
        return product + half_ulp(rates[:, 0] * (sizes.inner[:, 0] + lowered.thresholds[0]))
    error = half_ulp(sizes.inner[:, 0]) + np.abs(lowered.steady.astype(np.float64) - exact.steady)
    for i in range(n):
        error = rates[:, i] * error + half_ulp(rates[:, i] * sizes.inner[:, i])
        if i + 1 < n:
            error = error + half_ulp(sizes.state[i + 1]) + half_ulp(sizes.inner[:, i + 1])
    return error


def _changed_rates(lowered: FloatComponent, reachable: _Reachable) -> Array:
    """Most that rounding the rates changes q, shape (rows,)."""
    board_c = increments.from_rates(lowered.rates.astype(np.float64))
    return reachable.functional(board_c - reachable.exact.c)


def _prove(lowered: FloatComponent, reachable: _Reachable, sizes: _Magnitudes, changed: Array) -> Proof | None:
    """Worst error for any PWM sequence of any length, or None if it is too large for the ranges it rests on."""
    exact = reachable.exact
    n = exact.order
    board_c = increments.from_rates(lowered.rates.astype(np.float64))
    q_error = changed + _rounding_of_q(lowered, exact, sizes)
    chain_error = _chain_error(lowered, sizes)
    if n > 1:
        # What one change carries: both q's errors, 1/12, three operations, and the implicit factor.
        share, carried = np.maximum(board_c, exact.c)[:, n - 2], sizes.carried
        difference = 12.0 * carried
        wrong = (q_error + q_error.max()) * CARRY + half_ulp(difference) / 12.0
        wrong += half_ulp(carried) + carried * 2.0**-24 + share * carried / 12.0
        wrong += half_ulp(np.array(lowered.thresholds)[n - 2] + carried)
        chain_error[:, n - 2] += wrong
        # The correction of q for it: two products and a difference.
        q_error = q_error + np.abs(board_c - exact.c)[:, n - 2] * carried + share * wrong
        q_error += 2.0 * share * carried * 2.0**-24 + half_ulp(sizes.q)
    error = _worst_error(reachable, q_error, chain_error, float(half_ulp(max(np.abs(exact.start)))))
    largest = float(sizes.inner[:, 0].max()) + lowered.thresholds[0]
    if error is None or largest * _INFLATION >= 2.0**lowered.range_bits:
        return None
    return Proof(
        rise_range_K=sizes.rise,
        increment_range_K=tuple(float(v) for v in sizes.state[1:]),
        bound_K=error + float(half_ulp(sizes.state[0])),
    )


def _worst_error(reachable: _Reachable, q_error: Array, chain_error: Array, start_error: float) -> float | None:
    """Largest ``|x1 - T|`` in K, as :func:`gen.lowering.bounds.worst_error` with per-functional ranges."""
    exact = reachable.exact
    n, rows = exact.order, len(exact.steady)
    form_error = np.abs(increments.mismatch(exact.form, exact.exact, reachable.maps))
    form_rows = np.einsum("pij,pj->pi", form_error, reachable.true_distance())
    disturbance = np.zeros((rows, n + 1, n))
    disturbance[:, 0, :] = q_error[:, None] * increments.injection(n)
    for i in range(n):
        disturbance[:, 1 + i, i] = chain_error[:, i] + form_rows[:, i]
    start = np.zeros((1, n))
    start[0, 0] = start_error
    from_board = np.linalg.inv(reachable.maps)
    error = reachable.recursion.bound(np.einsum("pij,pkj->pki", from_board, disturbance), start)
    extents = np.array([error.extent(axis) for axis in np.eye(n)])
    if np.any(extents > reachable.extents * _WIDENING):
        return None
    beyond = np.abs(reachable.maps[:, 0, :] - np.eye(n)[0])
    output = np.einsum("pj,pj->p", beyond, reachable.true_distance()).max()
    return float(extents[0] + output)
