"""Proven bounds on a linear recursion whose matrix switches arbitrarily from sample to sample.

The recursion is y -> F(p) y + r(p), where p may be any PWM at any sample and r(p) lies in a set that is symmetric
about 0.  Everything that can be reached from a symmetric start set is enclosed in a polytope

    { y : |c_j . y| <= h_j for all directions c_j },

which is invariant if for every direction j and every PWM p

    F(p)^T c_j = sum_l w_jpl c_l   with w_jpl >= 0,        h_j >= reach_p(c_j) + sum_l w_jpl h_l,        (*)

with reach_p(c) = max over r(p) of c . r(p).  (A support function is convex and homogeneous, so interpolating it
between directions can only overestimate.)  The weights are the barycentric coordinates of F^T c_j in the simplex of
neighbouring directions that it falls into; the h_j are the fixed point of (*), found by policy iteration (one
sparse linear system per policy) and then checked against (*) at *every* PWM, with a margin, in plain float64.

A quadratic (ellipsoidal) Lyapunov function would do the same job with a semidefinite program, but much less tightly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError, solve_continuous_lyapunov
from scipy.sparse.linalg import splu
from scipy.spatial import ConvexHull

Array = NDArray[np.float64]

#: Number of directions on the half sphere by order; the bound tightens slowly with more.
DIRECTIONS = {1: 1, 2: 90, 3: 900, 4: 1600}
#: Added to every reward, relative to the largest height, so that (*) holds strictly in float64.
_SLACK = 1e-10
#: A policy that improves a height by less than this, relative to the largest, is not worth another round.
_SETTLED = 1e-12
_WEIGHT_TOLERANCE = 1e-11
#: With how many PWM the fixed point is sought first.
_FIRST_MODES = 24


#: With how many directions the facets are compared at once.
_TOGETHER = 128


class NoProofError(Exception):
    """No invariant polytope was found: the switching may be unstable, or the directions too coarse."""


@dataclass(frozen=True)
class ReachSet:
    """An invariant polytope; :meth:`extent` reads it in any direction."""

    _directions: Array
    _inverse_shape: Array
    _facets: NDArray[np.intp]
    _facet_inverse: Array
    height: Array

    @property
    def directions(self) -> Array:
        """The polytope's directions c_j in the state's own coordinates, shape (J, n)."""
        found: Array = self._directions @ np.linalg.inv(self._inverse_shape.T)
        return found

    @property
    def shape(self) -> Array:
        """What makes :attr:`directions` unit vectors, shape (n, n)."""
        return self._inverse_shape.T

    def extent(self, direction: Array) -> float:
        """Upper bound of ``|direction . y|`` over everything that can be reached."""
        return float(self.extents(np.asarray(direction, dtype=np.float64)[None, :])[0])

    def extents(self, directions: Array) -> Array:
        """:meth:`extent` of many directions, shape (k, n); the result has shape (k,)."""
        found = np.zeros(len(directions))
        for first in range(0, len(directions), _TOGETHER):
            targets = directions[first : first + _TOGETHER] @ self._inverse_shape.T
            weights = self._facet_inverse @ targets.T  # (facets, n, k)
            best = weights.min(axis=1).argmax(axis=0)
            every = np.arange(len(targets))
            full = self._facets[best] % len(self.height)
            values = (np.maximum(weights[best, :, every], 0.0) * self.height[full]).sum(axis=1)
            found[first : first + _TOGETHER] = np.where(targets.any(axis=1), values, 0.0)
        return found


@dataclass
class _Policy:
    """Which PWM each direction's height comes from: a place in ``modes``, or the start set (``stopped``)."""

    modes: NDArray[np.intp]
    choice: NDArray[np.intp]
    stopped: NDArray[np.bool_]

    @classmethod
    def first(cls, reward: Array) -> _Policy:
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

    def __init__(self, matrices: Array) -> None:
        m, n, _ = matrices.shape
        step = matrices - np.eye(n)
        self._shape = _shape(step)  # y = shape @ (round coordinates)
        round_matrices = np.linalg.solve(self._shape, matrices @ self._shape)
        self._directions = _directions(n, self._shape)
        count = len(self._directions)
        both = np.vstack([self._directions, -self._directions])
        self._facets = _facets(both)
        self._facet_inverse = np.linalg.inv(np.transpose(both[self._facets], (0, 2, 1)))
        self._index = np.zeros((count, m, n), dtype=np.intp)
        self._weight = np.zeros((count, m, n))
        touching = _incidence(self._facets, count)
        images = np.tensordot(self._directions, round_matrices, axes=(1, 1)).transpose(0, 2, 1)  # (j, a, p)
        every = np.arange(m)
        for j in range(count):
            inverse = self._facet_inverse[touching[j]]
            weights = (inverse.reshape(-1, n) @ images[j]).reshape(len(inverse), n, m)
            best = weights.min(axis=1).argmax(axis=0)
            self._weight[j] = weights[best, :, every]
            self._index[j] = self._facets[touching[j][best]] % count
        if self._weight.min() < -_WEIGHT_TOLERANCE:
            raise NoProofError("a direction leaves its neighbourhood within one sample")
        self._weight = np.maximum(self._weight, 0.0)
        self._known: dict[bytes, ReachSet] = {}

    def bound(self, disturbance: Array, start: Array | None = None) -> ReachSet:
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

    def _bound(self, disturbance: Array, start: Array | None) -> ReachSet:
        to_round = np.linalg.inv(self._shape)
        generators = disturbance @ to_round.T
        reward = np.abs(np.einsum("pkn,jn->jpk", generators, self._directions)).sum(axis=2)
        floor = np.zeros(len(self._directions))
        if start is not None:
            floor = np.abs(self._directions @ (start @ to_round.T).T).sum(axis=1)
        policy = _Policy.first(reward)
        height = self._fixed_point(reward, floor, policy)
        if not height.any():
            return ReachSet(self._directions, self._shape.T, self._facets, self._facet_inverse, height)
        height = self._fixed_point(reward + _SLACK * height.max(), floor, policy)
        image = reward + (self._weight * height[self._index]).sum(axis=2)
        if np.any(image.max(axis=1) > height) or np.any(floor > height):
            raise NoProofError("the polytope fails its own check")
        return ReachSet(self._directions, self._shape.T, self._facets, self._facet_inverse, height)

    def _fixed_point(self, reward: Array, floor: Array, policy: _Policy) -> Array:
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

    def _policy_iteration(self, reward: Array, floor: Array, policy: _Policy) -> Array:
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


def _shape(step: Array) -> Array:
    """A matrix whose columns span a round picture of the recursion's typical response.

    The mean matrix's response to a constant drive has a covariance (Lyapunov equation); its Cholesky factor makes
    the reachable set roughly a ball.  Any invertible matrix is valid; this one makes the bound tight.
    """
    n = step.shape[1]
    if n == 1:
        return np.eye(1)
    rate = -np.trace(step, axis1=1, axis2=2).mean() / n
    scale = rate ** np.arange(n)
    scaled = step.mean(axis=0) / scale[:, None] * scale[None, :] / rate
    drive = -scaled[:, :1]
    try:
        covariance = solve_continuous_lyapunov(scaled, -drive @ drive.T)
        factor = np.linalg.cholesky((covariance + covariance.T) / 2.0)
    except (LinAlgError, np.linalg.LinAlgError) as error:
        raise NoProofError("the mean of the matrices over PWM is not stable") from error
    shaped: Array = scale[:, None] * factor
    return shaped


def _directions(order: int, shape: Array) -> Array:
    """Unit vectors spread over the half sphere; the coordinate axes of the state are among them."""
    if order == 1:
        return np.ones((1, 1))
    points = _spread(order, DIRECTIONS[order])
    axes = shape.T @ np.eye(order)
    axes = (axes / np.linalg.norm(axes, axis=0)).T
    spacing = 1.2 * (1.0 / DIRECTIONS[order]) ** (1.0 / (order - 1))
    far = np.ones(len(points), dtype=bool)
    for axis in axes:
        far &= np.abs(points @ axis) < np.cos(0.5 * spacing)
    return np.vstack([axes, points[far]])


def _spread(order: int, count: int) -> Array:
    index = np.arange(count) + 0.5
    if order == 2:
        angle = np.pi * index / count
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if order == 3:  # Fibonacci lattice on the upper half sphere
        height = 1.0 - index / count
        angle = np.pi * (1.0 + 5.0**0.5) * index
        radius = np.sqrt(1.0 - height**2)
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    # Super-Fibonacci spiral on the 3-sphere (Alexa, CVPR 2022); one of each antipodal pair is kept.
    count *= 2
    index = np.arange(count) + 0.5
    radius, other = np.sqrt(index / count), np.sqrt(1.0 - index / count)
    alpha, beta = 2.0 * np.pi * index / np.sqrt(2.0), 2.0 * np.pi * index / 1.533751168755204288118041
    points = np.stack(
        [radius * np.sin(alpha), radius * np.cos(alpha), other * np.sin(beta), other * np.cos(beta)], axis=1
    )
    half: Array = points[points[:, 0] > 0.0]
    return half


def _facets(points: Array) -> NDArray[np.intp]:
    if points.shape[1] == 1:
        return np.array([[0], [1]], dtype=np.intp)
    hull = ConvexHull(points)
    facets: NDArray[np.intp] = hull.simplices.astype(np.intp)
    return facets


def _incidence(facets: NDArray[np.intp], count: int) -> list[NDArray[np.intp]]:
    touching: list[list[int]] = [[] for _ in range(count)]
    for number, facet in enumerate(facets):
        for vertex in facet:
            if vertex < count:
                touching[vertex].append(number)
    return [np.array(numbers, dtype=np.intp) for numbers in touching]
