"""Proven bounds on a linear recursion whose matrix switches arbitrarily from sample to sample.

The recursion is y -> F(p) y + r(p), where p may be any PWM at any sample and r(p) lies in a set that is symmetric
about 0.  Everything that can be reached from a symmetric start set is enclosed in a polytope

    { y : |c_j . y| <= h_j for all directions c_j },

which is invariant if for every direction j and every PWM p

    F(p)^T c_j = sum_l w_jpl c_l   with w_jpl >= 0,        h_j >= reach_p(c_j) + sum_l w_jpl h_l,        (*)

with reach_p(c) = max over r(p) of c . r(p).  (A support function is convex and homogeneous, so interpolating it
between directions can only overestimate.)  The weights are the barycentric coordinates of F^T c_j in the simplex of
directions that it falls into; the h_j are the fixed point of (*), found by policy iteration (one sparse linear system
per policy) and then checked against (*) at *every* PWM in float64.

The check does not trust the weights: what they leave, rho = F^T c_j - sum_l w_jpl c_l, adds sum_k |rho_k| E_k to the
right-hand side of (*), E_k being the polytope's own extent along the state's coordinate k, and so does every rounding
of float64, bounded term by term.

A quadratic (ellipsoidal) Lyapunov function would do the same job with a semidefinite program, but much less tightly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu

from gen.arrays import BoolArray, FloatArray
from gen.lowering.recursion.fan import WEIGHT_TOLERANCE, Fan, incidence, round_shape
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.reach_set import ROUNDING, ReachSet, support

#: Added to every reward, relative to the largest height, so that (*) holds strictly in float64.
_SLACK = 1e-10
#: A policy that improves a height by less than this, relative to the largest, is not worth another round.
_SETTLED = 1e-12
#: With how many PWM the fixed point is sought first.
_FIRST_MODES = 24


@dataclass
class _Policy:
    """Which PWM each direction's height comes from: a place in ``modes``, or the start set (``stopped``)."""

    modes: NDArray[np.intp]
    choice: NDArray[np.intp]
    stopped: BoolArray

    @classmethod
    def first(cls, reward: FloatArray) -> _Policy:
        """A few PWM over the domain, and the largest reward of each direction among them."""
        count, all_modes = reward.shape
        modes = np.unique(np.linspace(0, all_modes - 1, min(all_modes, _FIRST_MODES)).round().astype(np.intp))
        return cls(modes, reward[:, modes].argmax(axis=1), np.zeros(count, dtype=bool))

    def add(self, modes: NDArray[np.intp]) -> None:
        """Let more PWM be chosen."""
        merged = np.union1d(self.modes, modes)
        self.choice = np.searchsorted(merged, self.modes[self.choice])
        self.modes = merged


class SwitchedRecursion:
    """The directions and interpolation weights for one set of matrices, used for several bounds.

    Parameters
    ----------
    matrices
        F(p), shape (m, n, n), one for each PWM; each must be stable.

    Raises
    ------
    NoProofError
        If no shape for the directions is found, or no direction's image can be enclosed.
    """

    def __init__(self, matrices: FloatArray) -> None:
        m, n, _ = matrices.shape
        self._fan = fan = Fan.of(n, round_shape(matrices - np.eye(n)))
        self._magnitudes = np.abs(matrices)
        count = len(fan)
        self._index = np.zeros((count, m, n), dtype=np.intp)
        self._weight = np.zeros((count, m, n))
        self._rest = np.zeros((count, m, n))
        touching = incidence(fan.facets, count)
        every = np.arange(m)
        for j in range(count):
            image = np.einsum("k,pki->pi", fan.directions[j], matrices)
            rounded = image @ fan.shape
            weights = (fan.inverse[touching[j]].reshape(-1, n) @ rounded.T).reshape(len(touching[j]), n, m)
            best = weights.min(axis=1).argmax(axis=0)
            facet, weight = touching[j][best], weights[best, :, every]
            far = np.flatnonzero(weight.min(axis=1) < -WEIGHT_TOLERANCE)
            if len(far):
                facet[far] = fan.walked(rounded[far], facet[far])
                weight[far] = np.einsum("kij,kj->ki", fan.inverse[facet[far]], rounded[far])
                if weight[far].min() < -WEIGHT_TOLERANCE:
                    raise NoProofError("no facet holds what one sample makes of a direction")
            vertices = fan.facets[facet]
            self._weight[j] = np.maximum(weight, 0.0)
            self._index[j] = vertices % count
            self._rest[j] = np.abs(fan.rest(image, self._weight[j], vertices))
        self._known: dict[bytes, ReachSet] = {}

    def bound(self, disturbance: FloatArray, start: FloatArray | None = None) -> ReachSet:
        """Enclose everything that can be reached.

        Parameters
        ----------
        disturbance
            Generators of r(p), shape (m, k, n): r(p) = sum_k t_k disturbance[p, k] with any |t_k| <= 1.
        start
            Generators of the start set, shape (k, n); ``None`` starts from 0.

        Raises
        ------
        NoProofError
            If the fixed point does not exist (it would be negative or infinite).
        """
        key = np.ascontiguousarray(disturbance).tobytes() + (b"" if start is None else start.tobytes())
        if key not in self._known:
            self._known[key] = self._bound(disturbance, start)
        return self._known[key]

    def _bound(self, disturbance: FloatArray, start: FloatArray | None) -> ReachSet:
        directions = self._fan.directions
        reward = support(directions, disturbance)
        floor = np.zeros(len(directions))
        if start is not None:
            floor = support(directions, start[None])[:, 0]
        policy = _Policy.first(reward)
        height = self._fixed_point(reward, floor, policy)
        if not height.any():
            return ReachSet(self._fan, height)
        slack = _SLACK * height.max()
        for _ in range(2):
            found = ReachSet(self._fan, self._fixed_point(reward + slack, floor, policy))
            lacking = self._right_hand_side(reward, found) - found.height[:, None]
            if np.all(lacking <= 0.0) and np.all(floor <= found.height):
                return found
            slack += 2.0 * float(lacking.max()) + slack
        raise NoProofError("the polytope fails its own check")

    def _right_hand_side(self, reward: FloatArray, found: ReachSet) -> FloatArray:
        """Of (*), with what weights and float64 leave out, shape (J, m)."""
        n = self._weight.shape[2]
        sizes = np.abs(self._fan.directions) @ found.axes
        combined = (self._weight * found.height[self._index]).sum(axis=2)
        hidden = np.abs(self._fan.directions) @ (self._magnitudes @ found.axes).T
        hidden += (self._weight * sizes[self._index]).sum(axis=2)
        result: FloatArray = (reward + combined) * (1.0 + (n + 2) * ROUNDING) + self._rest @ found.axes
        result += (n + 2) * ROUNDING * hidden
        return result

    def _fixed_point(self, reward: FloatArray, floor: FloatArray, policy: _Policy) -> FloatArray:
        """Solve (*) for a few PWM and add those at which it does not hold yet, until it holds at all."""
        while True:
            height = self._policy_iteration(reward, floor, policy)
            value = reward + (self._weight * height[self._index]).sum(axis=2)
            lacking = (value > height[:, None] + _SETTLED * np.abs(height).max()).any(axis=0)
            lacking[policy.modes] = False
            if not lacking.any():
                return height
            worst = np.unique(value.argmax(axis=1))
            policy.add(worst[lacking[worst]])

    def _policy_iteration(self, reward: FloatArray, floor: FloatArray, policy: _Policy) -> FloatArray:
        """The fixed point for the PWM of a policy, which is left at what it came to."""
        count, _, n = self._weight.shape
        rows = np.repeat(np.arange(count), n)
        every = np.arange(count)
        weights, indices = self._weight[:, policy.modes], self._index[:, policy.modes]
        rewards = reward[:, policy.modes]
        height = floor.copy()
        for _ in range(200):
            weight = np.where(policy.stopped[:, None], 0.0, weights[every, policy.choice])
            columns = indices[every, policy.choice]
            system = sparse.csc_matrix((weight.ravel(), (rows, columns.ravel())), shape=(count, count))
            try:
                height = splu(sparse.eye(count, format="csc") - system).solve(
                    np.where(policy.stopped, floor, rewards[every, policy.choice])
                )
            except RuntimeError as error:
                raise NoProofError("the policy's linear system is singular") from error
            if not np.all(np.isfinite(height)) or height.min() < -1e-9 * np.abs(height).max():
                raise NoProofError("arbitrary switching between these PWM values is not contractive")
            value = rewards + (weights * height[indices]).sum(axis=2)
            best = value.max(axis=1)
            improved = np.maximum(best, floor) > height + _SETTLED * np.abs(height).max()
            if not improved.any():
                return np.maximum(height, floor)
            policy.choice = np.where(improved, value.argmax(axis=1), policy.choice)
            policy.stopped = np.where(improved, floor >= best, policy.stopped)
        raise NoProofError("policy iteration did not settle")
