"""Polytopes { u : |c_j . u| <= h_j }, read from outside and proven invariant.

Everything rests on one fact. If d = sum_l w_l c_l + r with w >= 0, then over the polytope

    |d . u|  <=  sum_l w_l h_l + sum_i |r_i| b_i          b_i >= |u_i|, read off the directions along the axes.

Which w to take is a guess, as good as any: what it misses is r, and r is what it is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from gen.arrays import FloatArray
from gen.certificate.exact import ROUGHLY, Ratios, floats, ratios
from gen.certificate.refuted import Refuted

Places = NDArray[np.intp]

#: A guess that leaves a weight below this looks further.
_ENOUGH = -1e-12
#: Facets that a guess looks at, at most.
_LONGEST_WALK = 200


class Directions:
    """The directions c_j, shape (J, n), and guesses how others combine from them.

    Parameters
    ----------
    directions
        Exact.
    shape
        Makes them unit vectors, shape (n, n). Only the guesses are made with it.

    Raises
    ------
    Refuted
        If an axis is not among them, or a guess cannot be made.
    """

    def __init__(self, directions: Ratios, shape: FloatArray) -> None:
        self.exact, self.nearest = directions, floats(directions)
        if np.any(ratios(self.nearest) != directions):
            raise Refuted("a direction is no float64")
        self.order = directions.shape[1]
        self._axes = [self._along(i) for i in range(self.order)]
        self._round = shape
        points = self.nearest @ self._round
        self._length = np.linalg.norm(points, axis=1)
        self._unit = points / self._length[:, None]
        both = np.vstack([self._unit, -self._unit])
        self._facets, self._neighbours = _facets(both)
        self._inverse = np.linalg.inv(np.transpose(both[self._facets], (0, 2, 1)))
        self._at = np.zeros(len(both), dtype=np.intp)  # a facet at each vertex
        self._at[self._facets] = np.arange(len(self._facets))[:, None]

    def box(self, heights: Ratios) -> Ratios:
        """b_i of :mod:`gen.certificate.polytope`, shape (n,), for heights in any unit, shape (J,)."""
        found = [heights[j] / abs(self.exact[j, i]) for i, j in enumerate(self._axes)]
        return np.array(found, dtype=object)

    def guess(self, targets: FloatArray, near: int | None = None) -> tuple[Places, FloatArray]:
        """Which directions combine to targets, shape (k, n), and their weights, each (k, n).

        The signs of the directions are in the weights. ``near`` is the direction in whose neighbourhood they lie.
        """
        goals = targets @ self._round
        if near is None:
            along = goals @ self._unit.T
            near_by = np.abs(along).argmax(axis=1)
            behind = along[np.arange(len(goals)), near_by] < 0.0
            facet = self._at[near_by + len(self._unit) * behind]
        else:
            facet = np.full(len(goals), self._at[near])
        for _ in range(_LONGEST_WALK):  # from facet to facet over the face that is most in the way
            weights = np.einsum("kij,kj->ki", self._inverse[facet], goals)
            worst = weights.argmin(axis=1)
            outside = np.flatnonzero(weights[np.arange(len(facet)), worst] < _ENOUGH * np.abs(weights).max(axis=1))
            if not len(outside):
                break
            facet[outside] = self._neighbours[facet[outside], worst[outside]]
        weights = np.einsum("kij,kj->ki", self._inverse[facet], goals)
        places, count = self._facets[facet], len(self._unit)
        chosen = places % count
        return chosen, np.maximum(weights, 0.0) / self._length[chosen] * np.where(places < count, 1.0, -1.0)

    def _along(self, axis: int) -> int:
        others = [i for i in range(self.order) if i != axis]
        alone = np.array([value != 0 for value in self.exact[:, axis]])
        for i in others:
            alone &= np.array([value == 0 for value in self.exact[:, i]])
        if not alone.any():
            raise Refuted(f"no direction lies along axis {axis + 1}")
        return int(np.argmax(alone))


def _facets(points: FloatArray) -> tuple[Places, Places]:
    """The facets of the hull of points, and the neighbour opposite to each vertex, shape (facets, n) each."""
    if points.shape[1] == 1:
        return np.array([[0], [1]], dtype=np.intp), np.array([[1], [0]], dtype=np.intp)
    hull = ConvexHull(points)
    return hull.simplices.astype(np.intp), hull.neighbors.astype(np.intp)


def largest(directions: Directions, heights: Ratios, targets: Ratios) -> Ratios:
    """Bounds of ``|d . u|`` over a polytope for the rows d of ``targets``, shape (k,).

    Parameters
    ----------
    directions, heights
        The polytope.
    targets
        Shape (k, n).
    """
    places, weights = directions.guess(targets.astype(np.float64))
    box = directions.box(heights)
    signed = ratios(weights)
    chosen = directions.exact[places]  # (k, n, n)
    rest = targets - (signed[:, :, None] * chosen).sum(axis=1)
    found: Ratios = (np.abs(signed) * heights[places]).sum(axis=1) + (np.abs(rest) * box).sum(axis=1)
    return found


def largest_roughly(directions: Directions, heights: Ratios, targets: FloatArray) -> FloatArray:
    """:func:`largest` in float64, rounded up by far more than its own errors."""
    places, weights = directions.guess(targets)
    parts = weights[:, :, None] * directions.nearest[places]
    rest = np.abs(targets - parts.sum(axis=1)) + ROUGHLY * (np.abs(parts).sum(axis=1) + np.abs(targets))
    found: FloatArray = (np.abs(weights) * floats(heights)[places]).sum(axis=1) + rest @ floats(directions.box(heights))
    return found * (1.0 + ROUGHLY)


class Images:
    """The images E^T c_j of all directions under all P matrices, as combinations of directions, in float64.

    Every sum is rounded up by :data:`ROUGHLY` of the magnitudes of its terms, which is far more than its own errors.
    """

    def __init__(self, directions: Directions, transition: FloatArray) -> None:
        along = directions.nearest
        images = np.einsum("ji,pil->pjl", along, transition)
        rows, count, n = images.shape
        self._places = np.empty((rows, count, n), dtype=np.intp)
        weights = np.empty((rows, count, n))
        for j in range(count):
            self._places[:, j], weights[:, j] = directions.guess(images[:, j], near=j)
        self._weights = np.abs(weights)
        lost = ROUGHLY * np.einsum("ji,pil->pjl", np.abs(along), np.abs(transition))
        rest = images
        for i in range(n):  # one neighbour after the other, to spare memory
            part = weights[:, :, i, None] * along[self._places[:, :, i]]
            rest, lost = rest - part, lost + ROUGHLY * np.abs(part)
        self._rest = np.abs(rest) + lost

    def largest(self, heights: FloatArray, box: FloatArray) -> FloatArray:
        """Bounds of ``|c_j . E u|`` over a polytope, shape (P, J)."""
        inside = (self._weights * heights[self._places]).sum(axis=2)
        found: FloatArray = (inside + self._rest @ box) * (1.0 + ROUGHLY)
        return found
