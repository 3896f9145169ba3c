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
from functools import cached_property

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
#: A sum of n products in float64 is off by at most n + 1 of these, relative to the sum of their magnitudes.
_ROUNDING = 2.0**-52
#: A policy that improves a height by less than this, relative to the largest, is not worth another round.
_SETTLED = 1e-12
_WEIGHT_TOLERANCE = 1e-11
#: With how many PWM the fixed point is sought first.
_FIRST_MODES = 24


#: With how many directions a facet is sought at once.
_TOGETHER = 1024
#: Over how many facets an image is followed from those that touch its direction.
_LONGEST_WALK = 400


class NoProofError(Exception):
    """Nothing could be proven; the message says why.

    No invariant polytope was found (the switching may be unstable, or the directions too coarse), or what it gives is
    too large for the words.
    """


@dataclass(frozen=True)
class _Fan:
    """The directions and the simplices between them.

    Attributes
    ----------
    directions
        c_j in the state's coordinates, shape (J, n): by definition these very numbers.
    shape
        y = shape @ (coordinates in which the directions are unit vectors), shape (n, n).
    facets
        Simplices of the directions j and their opposites J + j, shape (facets, n).
    neighbours
        The facet beyond each vertex's opposite face, shape (facets, n).
    inverse
        Gives a round vector's weights in each facet, shape (facets, n, n).
    vertices
        The directions and their opposites as unit vectors, shape (2 J, n).
    any_facet
        A facet at each of them, shape (2 J,).
    """

    directions: Array
    shape: Array
    facets: NDArray[np.intp]
    neighbours: NDArray[np.intp]
    inverse: Array
    vertices: Array
    any_facet: NDArray[np.intp]

    @classmethod
    def of(cls, order: int, shape: Array) -> _Fan:
        """Directions spread over the half sphere."""
        found = _directions(order, shape)
        both = np.vstack([found, -found])
        facets, neighbours = _facets(both)
        inverse = np.linalg.inv(np.transpose(both[facets], (0, 2, 1)))
        any_facet = np.zeros(len(both), dtype=np.intp)
        any_facet[facets] = np.arange(len(facets))[:, None]
        return cls(found @ np.linalg.inv(shape), shape, facets, neighbours, inverse, both, any_facet)

    def __len__(self) -> int:
        return len(self.directions)

    def rest(self, targets: Array, weights: Array, vertices: NDArray[np.intp]) -> Array:
        """What weights at facets' vertices leave of targets, in the state's coordinates; all of shape (k, n)."""
        count = len(self)
        signed = np.where(vertices < count, weights, -weights)
        rest: Array = targets - np.einsum("kl,kln->kn", signed, self.directions[vertices % count])
        return rest

    def located(self, targets: Array) -> NDArray[np.intp]:
        """The facets that hold round targets, shape (k, n), each found from a facet at the nearest direction."""
        return self.walked(targets, self.any_facet[(targets @ self.vertices.T).argmax(axis=1)])

    def walked(self, targets: Array, facet: NDArray[np.intp]) -> NDArray[np.intp]:
        """The facets that hold round targets, shape (k, n), by steps over the worst face from those given.

        The facets are a regular triangulation of the sphere, in which such a walk visits none twice.
        """
        facet = facet.copy()
        for _ in range(_LONGEST_WALK):
            weights = np.einsum("kij,kj->ki", self.inverse[facet], targets)
            worst = weights.argmin(axis=1)
            outside = np.flatnonzero(weights[np.arange(len(facet)), worst] < -_WEIGHT_TOLERANCE)
            if not len(outside):
                break
            facet[outside] = self.neighbours[facet[outside], worst[outside]]
        return facet


@dataclass(frozen=True)
class ReachSet:
    """An invariant polytope; :meth:`extent` reads it in any direction.

    Attributes
    ----------
    height
        h_j, shape (J,).
    """

    _fan: _Fan
    height: Array

    @property
    def directions(self) -> Array:
        """The polytope's directions c_j in the state's coordinates, shape (J, n)."""
        return self._fan.directions

    @cached_property
    def axes(self) -> Array:
        """Upper bounds of ``|y_k|``, shape (n,)."""
        axes = np.eye(self._fan.shape.shape[0])
        values, rest = self._combined(axes)
        if not self.height.any():
            return np.zeros(len(axes))
        # The bounds E obey E <= values + |rest| E; |rest| is a rounding, so a few turns and a margin settle it.
        bound = values
        for _ in range(3):
            bound = values + np.abs(rest) @ bound
        bound = bound * (1.0 + 1e-9)
        if np.any(values + (np.abs(rest) + self._rounded(axes)) @ bound > bound):
            raise NoProofError("the polytope's extents along the axes are not known in float64")
        return np.asarray(bound)

    @property
    def shape(self) -> Array:
        """What makes :attr:`directions` unit vectors, shape (n, n)."""
        return self._fan.shape

    def extent(self, direction: Array) -> float:
        """Upper bound of ``|direction . y|`` over everything that can be reached."""
        return float(self.extents(np.asarray(direction, dtype=np.float64)[None, :])[0])

    def extents(self, directions: Array) -> Array:
        """:meth:`extent` of many directions, shape (k, n); the result has shape (k,)."""
        if not self.height.any():
            return np.zeros(len(directions))
        values, rest = self._combined(directions)
        found: Array = values + (np.abs(rest) + self._rounded(directions)) @ self.axes
        return found

    def _combined(self, directions: Array) -> tuple[Array, Array]:
        """Each direction's height by the weights in its facet, shape (k,), and what they leave of it, shape (k, n)."""
        values, rests = np.zeros(len(directions)), np.zeros_like(directions)
        for first in range(0, len(directions), _TOGETHER):
            part = directions[first : first + _TOGETHER]
            rounded = part @ self._fan.shape
            facet = self._fan.located(rounded / np.maximum(np.linalg.norm(rounded, axis=1), 1e-300)[:, None])
            kept = np.maximum(np.einsum("kij,kj->ki", self._fan.inverse[facet], rounded), 0.0)
            vertices = self._fan.facets[facet]
            values[first : first + _TOGETHER] = (kept * self.height[vertices % len(self.height)]).sum(axis=1)
            rests[first : first + _TOGETHER] = self._fan.rest(part, kept, vertices)
        return values * (1.0 + 8.0 * _ROUNDING), rests

    def _rounded(self, directions: Array) -> Array:
        """What float64 may hide of a direction's rest, shape (k, n): no term is much larger than the direction."""
        n = directions.shape[1]
        largest = np.abs(self._fan.directions).max(axis=0) * np.abs(directions @ self._fan.shape).sum(axis=1)[:, None]
        hidden: Array = 8.0 * (n + 1) * _ROUNDING * (np.abs(directions) + n * largest)
        return hidden


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
        self._fan = fan = _Fan.of(n, _shape(matrices - np.eye(n)))
        self._magnitudes = np.abs(matrices)
        count = len(fan)
        self._index = np.zeros((count, m, n), dtype=np.intp)
        self._weight = np.zeros((count, m, n))
        self._rest = np.zeros((count, m, n))
        touching = _incidence(fan.facets, count)
        every = np.arange(m)
        for j in range(count):
            image = np.einsum("k,pki->pi", fan.directions[j], matrices)
            rounded = image @ fan.shape
            weights = (fan.inverse[touching[j]].reshape(-1, n) @ rounded.T).reshape(len(touching[j]), n, m)
            best = weights.min(axis=1).argmax(axis=0)
            facet, weight = touching[j][best], weights[best, :, every]
            far = np.flatnonzero(weight.min(axis=1) < -_WEIGHT_TOLERANCE)
            if len(far):
                facet[far] = fan.walked(rounded[far], facet[far])
                weight[far] = np.einsum("kij,kj->ki", fan.inverse[facet[far]], rounded[far])
                if weight[far].min() < -_WEIGHT_TOLERANCE:
                    raise NoProofError("no facet holds what one sample makes of a direction")
            vertices = fan.facets[facet]
            self._weight[j] = np.maximum(weight, 0.0)
            self._index[j] = vertices % count
            self._rest[j] = np.abs(fan.rest(image, self._weight[j], vertices))
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
        directions = self._fan.directions
        reward = _support(directions, disturbance)
        floor = np.zeros(len(directions))
        if start is not None:
            floor = _support(directions, start[None])[:, 0]
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

    def _right_hand_side(self, reward: Array, found: ReachSet) -> Array:
        """Of (*), with what weights and float64 leave out, shape (J, m)."""
        n = self._weight.shape[2]
        sizes = np.abs(self._fan.directions) @ found.axes
        combined = (self._weight * found.height[self._index]).sum(axis=2)
        hidden = np.abs(self._fan.directions) @ (self._magnitudes @ found.axes).T
        hidden += (self._weight * sizes[self._index]).sum(axis=2)
        result: Array = (reward + combined) * (1.0 + (n + 2) * _ROUNDING) + self._rest @ found.axes
        result += (n + 2) * _ROUNDING * hidden
        return result

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


def _facets(points: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The facets of the points' convex hull, and the neighbour beyond each vertex's opposite face."""
    if points.shape[1] == 1:
        return np.array([[0], [1]], dtype=np.intp), np.array([[1], [0]], dtype=np.intp)
    hull = ConvexHull(points)
    return hull.simplices.astype(np.intp), hull.neighbors.astype(np.intp)


def _support(directions: Array, generators: Array) -> Array:
    """Sums over k of ``|c_j . g_pk|``, not below them, shape (J, p), for generators of shape (p, k, n)."""
    found = np.abs(np.einsum("pkn,jn->jpk", generators, directions)).sum(axis=2)
    hidden = np.abs(directions) @ np.abs(generators).sum(axis=1).T
    result: Array = found * (1.0 + generators.shape[1] * _ROUNDING) + (directions.shape[1] + 1) * _ROUNDING * hidden
    return result


def _incidence(facets: NDArray[np.intp], count: int) -> list[NDArray[np.intp]]:
    touching: list[list[int]] = [[] for _ in range(count)]
    for number, facet in enumerate(facets):
        for vertex in facet:
            if vertex < count:
                touching[vertex].append(number)
    return [np.array(numbers, dtype=np.intp) for numbers in touching]
