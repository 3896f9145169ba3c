"""How large everything gets that the board computes with in float32."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.recursion import bounds, increments
from gen.lowering.recursion.dynamics import Dynamics
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.lowering.recursion.reach_set import ReachSet

#: The error itself may widen the ranges by this share; checked when the error is known.
WIDENING = 1e-3


class Reachable:
    """What the board's state can reach, read through linear functionals of x - s."""

    def __init__(self, recursion: SwitchedRecursion, exact: Dynamics) -> None:
        n = exact.order
        self.exact = exact
        self.recursion = recursion
        self.maps = increments.state_map(exact.c)
        towards = (np.eye(n) - exact.exact)[:, :, 0] * exact.away[:, None]  # of either sign
        start = np.zeros((1, n))
        start[0, 0] = max(exact.start[1] - exact.centre, exact.centre - exact.start[0])
        self._reach: ReachSet = recursion.bound(towards[:, None, :], start)
        self.extents = self._reach.axes

    def true_distance(self) -> FloatArray:
        """Largest ``|y - s|`` of the disturbed copy y of the true state, shape (rows, n)."""
        distance: FloatArray = np.tile(self.extents * (1.0 + WIDENING), (len(self.exact.steady), 1))
        distance[:, 0] += self.exact.away
        return distance

    def functional(self, weights: FloatArray) -> FloatArray:
        """Bound of ``|weights . (x - s)|`` at every row, for weights of shape (rows, n)."""
        mapped = np.einsum("pi,pij->pj", weights, self.maps)
        settled: FloatArray = np.abs(mapped[:, 0]) * self.exact.away
        result: FloatArray = self._around_centre(mapped) + settled
        return result

    def rise(self) -> tuple[float, float]:
        """Range of x1, in K."""
        mapped = self.maps[:, 0, :]
        off = np.abs(mapped[:, 0] - 1.0) * self.exact.away
        reach = float((self._around_centre(mapped) + off).max())
        return self.exact.centre - reach, self.exact.centre + reach

    def _around_centre(self, mapped: FloatArray) -> FloatArray:
        unique, place = np.unique(mapped, axis=0, return_inverse=True)
        extent = self._reach.extents(unique)[place.ravel()]
        widened: FloatArray = extent + WIDENING * np.abs(mapped) @ self.extents
        return widened


@dataclass(frozen=True)
class Magnitudes:
    """Bounds on what the board computes with.

    Attributes
    ----------
    rise
        Range of x1, in K.
    state
        Largest ``|x|`` over all rows, shape (n,), in K per sample^k.
    inner
        Magnitudes of S - x1, of R0 times it less x2, .. before each product, shape (rows, n).
    q
        Of the increment, shape (rows,).
    carried
        The most that one change of PWM adds to x[n-1], in K.
    """

    rise: tuple[float, float]
    state: FloatArray
    inner: FloatArray
    q: FloatArray
    carried: float = 0.0

    def added(self) -> FloatArray:
        """Most that one step adds to each state, shape (n,)."""
        order = len(self.state)
        result = np.append(self.state[1:], float(self.q.max()))
        if order == 2:
            result[0] += float(self.q.max()) / 2.0
        if order == 4:
            result[0] += self.state[2] / 2.0
        if order > 1:
            result[order - 2] += self.carried
        return result


def proven_magnitudes(reachable: Reachable) -> Magnitudes:
    """Magnitudes for every sequence of PWM."""
    exact = reachable.exact
    n, rows = exact.order, len(exact.steady)
    rise = reachable.rise()
    state = np.array([reachable.functional(np.tile(axis, (rows, 1))).max() for axis in np.eye(n)])
    state[0] = max(abs(rise[0]), abs(rise[1]))
    inner = np.stack([reachable.functional(_partial(exact.rates, k)) for k in range(n)], axis=1)
    return _with_carry(exact, Magnitudes(rise, state, inner, reachable.functional(exact.c)))


def unproven_magnitudes(exact: Dynamics) -> Magnitudes:
    """Magnitudes with room, for a component whose ranges cannot be proven."""
    ranges = bounds.unproven_ranges(exact)
    inner = np.stack(
        [np.einsum("pj,pj->p", _partial(exact.rates, k), ranges.distance) for k in range(exact.order)],
        axis=1,
    )
    q = np.einsum("pj,pj->p", exact.c, ranges.distance)
    return _with_carry(exact, Magnitudes(ranges.rise, ranges.magnitude, inner, q))


def _with_carry(exact: Dynamics, sizes: Magnitudes) -> Magnitudes:
    """Add what the state may lack of its carry while q is first computed after a change of PWM."""
    n = exact.order
    if n == 1:
        return sizes
    share = exact.c[:, n - 2]
    carried = float(sizes.q.max()) / 6.0 * (1.0 + float(share.max()))
    inner, state = sizes.inner.copy(), sizes.state.copy()
    state[n - 2] += carried
    for k in range(n - 2, n):
        inner[:, k] += carried * _partial(exact.rates, k)[:, n - 2]
    return replace(sizes, state=state, inner=inner, q=sizes.q + share * carried, carried=carried)


def _partial(rates: FloatArray, stage: int) -> FloatArray:
    """Weights on x - s of what enters product ``stage``; stage n gives q (all up to sign), shape (rows, n)."""
    n = rates.shape[1]
    weights = np.zeros_like(rates)
    for j in range(min(stage, n - 1) + 1):
        weights[:, j] = np.prod(rates[:, j:stage], axis=1)
    return weights
