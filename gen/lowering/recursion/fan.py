"""Directions spread over the sphere of states, and the simplices between them: what polytopes are read by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, solve_continuous_lyapunov
from scipy.spatial import ConvexHull

from gen.arrays import FloatArray
from gen.lowering.recursion.no_proof import NoProofError

#: Number of directions on the half sphere by order; the bound tightens slowly with more.
DIRECTIONS = {1: 1, 2: 90, 3: 900, 4: 1600}
#: A weight in a simplex that is below 0 by less is taken for one that is 0.
WEIGHT_TOLERANCE = 1e-11
#: Over how many facets an image is followed from those that touch its direction.
_LONGEST_WALK = 400


@dataclass(frozen=True)
class Fan:
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

    directions: FloatArray
    shape: FloatArray
    facets: NDArray[np.intp]
    neighbours: NDArray[np.intp]
    inverse: FloatArray
    vertices: FloatArray
    any_facet: NDArray[np.intp]

    @classmethod
    def of(cls, order: int, shape: FloatArray) -> Fan:
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

    def rest(self, targets: FloatArray, weights: FloatArray, vertices: NDArray[np.intp]) -> FloatArray:
        """What weights at facets' vertices leave of targets, in the state's coordinates; all of shape (k, n)."""
        count = len(self)
        signed = np.where(vertices < count, weights, -weights)
        rest: FloatArray = targets - np.einsum("kl,kln->kn", signed, self.directions[vertices % count])
        return rest

    def located(self, targets: FloatArray) -> NDArray[np.intp]:
        """The facets that hold round targets, shape (k, n), each found from a facet at the nearest direction."""
        return self.walked(targets, self.any_facet[(targets @ self.vertices.T).argmax(axis=1)])

    def walked(self, targets: FloatArray, facet: NDArray[np.intp]) -> NDArray[np.intp]:
        """The facets that hold round targets, shape (k, n), by steps over the worst face from those given.

        The facets are a regular triangulation of the sphere, in which such a walk visits none twice.
        """
        facet = facet.copy()
        for _ in range(_LONGEST_WALK):
            weights = np.einsum("kij,kj->ki", self.inverse[facet], targets)
            worst = weights.argmin(axis=1)
            outside = np.flatnonzero(weights[np.arange(len(facet)), worst] < -WEIGHT_TOLERANCE)
            if not len(outside):
                break
            facet[outside] = self.neighbours[facet[outside], worst[outside]]
        return facet


def round_shape(step: FloatArray) -> FloatArray:
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
    shaped: FloatArray = scale[:, None] * factor
    return shaped


def _directions(order: int, shape: FloatArray) -> FloatArray:
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


def _spread(order: int, count: int) -> FloatArray:
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
    half: FloatArray = points[points[:, 0] > 0.0]
    return half


def _facets(points: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The facets of the points' convex hull, and the neighbour beyond each vertex's opposite face."""
    if points.shape[1] == 1:
        return np.array([[0], [1]], dtype=np.intp), np.array([[1], [0]], dtype=np.intp)
    hull = ConvexHull(points)
    return hull.simplices.astype(np.intp), hull.neighbors.astype(np.intp)


def incidence(facets: NDArray[np.intp], count: int) -> list[NDArray[np.intp]]:
    """Give the facets that touch each of the directions, the opposites left out."""
    touching: list[list[int]] = [[] for _ in range(count)]
    for number, facet in enumerate(facets):
        for vertex in facet:
            if vertex < count:
                touching[vertex].append(number)
    return [np.array(numbers, dtype=np.intp) for numbers in touching]
