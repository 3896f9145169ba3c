"""Polytopes { u : |c_j . u| <= h_j }, read from outside and proven invariant.

Everything rests on one fact. If d = sum_l w_l c_l + r with w >= 0, then over the polytope

    |d . u|  <=  sum_l w_l h_l + sum_i |r_i| b_i          b_i >= |u_i|, read off the directions along the axes.

Which w to take is a guess, as good as any: what it misses is r, and r is what it is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from gen.certificate.exact import Floats, Ratios, floats, ratios
from gen.certificate.refuted import Refuted

Places = NDArray[np.intp]

#: A guess that leaves a weight below this looks further than the direction's own neighbours.
_ENOUGH = -1e-9
#: Share by which float64 results are rounded up: at most a hundred operations, each right to 2^-53 of its terms.
ROUGHLY = 1e-13
#: Guesses that are made at once.
_TOGETHER = 64


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

    def __init__(self, directions: Ratios, shape: Floats) -> None:
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
        self._facets = (
            np.array([[0], [1]], dtype=np.intp) if self.order == 1 else ConvexHull(both).simplices.astype(np.intp)
        )
        self._inverse = np.linalg.inv(np.transpose(both[self._facets], (0, 2, 1)))
        count = len(directions)
        # A direction's neighbourhood and the one opposite: guesses go both ways.
        self._touching: list[Places] = [np.nonzero((self._facets % count == j).any(axis=1))[0] for j in range(count)]

    def box(self, heights: Ratios) -> Ratios:
        """b_i of :mod:`gen.certificate.polytope`, shape (n,), for heights in any unit, shape (J,)."""
        found = [heights[j] / abs(self.exact[j, i]) for i, j in enumerate(self._axes)]
        return np.array(found, dtype=object)

    def guess(self, targets: Floats, near: int | None = None) -> tuple[Places, Floats]:
        """Which directions combine to targets, shape (k, n), and their weights, each (k, n).

        The signs of the directions are in the weights. ``near`` is the direction in whose neighbourhood they lie.
        """
        goals = targets @ self._round
        if near is not None:
            places, weights = self._search(goals, self._touching[near])
        else:
            nearest = np.abs(goals @ self._unit.T).argmax(axis=1)
            found = [self._search(goal[None], self._touching[j]) for goal, j in zip(goals, nearest, strict=True)]
            places, weights = (np.concatenate(parts) for parts in zip(*found, strict=True))
        poor = weights.min(axis=1) < _ENOUGH * np.abs(weights).max(axis=1)
        if poor.any():
            places[poor], weights[poor] = self._search(goals[poor], np.arange(len(self._facets)))
        count = len(self.exact)
        chosen = places % count
        return chosen, np.maximum(weights, 0.0) / self._length[chosen] * np.where(places < count, 1.0, -1.0)

    def _search(self, goals: Floats, among: Places) -> tuple[Places, Floats]:
        places = np.empty((len(goals), self.order), dtype=np.intp)
        weights = np.empty((len(goals), self.order))
        for first in range(0, len(goals), _TOGETHER):
            part = slice(first, first + _TOGETHER)
            found = [self._inverse[among, i] @ goals[part].T for i in range(self.order)]  # n times (facets, k)
            best = np.minimum.reduce(found).argmax(axis=0)
            every = np.arange(len(best))
            weights[part] = np.stack([one[best, every] for one in found], axis=1)
            places[part] = self._facets[among[best]]
        return places, weights

    def _along(self, axis: int) -> int:
        others = [i for i in range(self.order) if i != axis]
        alone = np.array([value != 0 for value in self.exact[:, axis]])
        for i in others:
            alone &= np.array([value == 0 for value in self.exact[:, i]])
        if not alone.any():
            raise Refuted(f"no direction lies along axis {axis + 1}")
        return int(np.argmax(alone))


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


def largest_roughly(directions: Directions, heights: Ratios, targets: Floats) -> Floats:
    """:func:`largest` in float64, rounded up by far more than its own errors."""
    places, weights = directions.guess(targets)
    parts = weights[:, :, None] * directions.nearest[places]
    rest = np.abs(targets - parts.sum(axis=1)) + ROUGHLY * (np.abs(parts).sum(axis=1) + np.abs(targets))
    found: Floats = (np.abs(weights) * floats(heights)[places]).sum(axis=1) + rest @ floats(directions.box(heights))
    return found * (1.0 + ROUGHLY)


class Images:
    """The images E^T c_j of all directions under all P matrices, as combinations of directions, in float64.

    Every sum is rounded up by :data:`ROUGHLY` of the magnitudes of its terms, which is far more than its own errors.
    """

    def __init__(self, directions: Directions, transition: Floats) -> None:
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

    def largest(self, heights: Floats, box: Floats) -> Floats:
        """Bounds of ``|c_j . E u|`` over a polytope, shape (P, J)."""
        inside = (self._weights * heights[self._places]).sum(axis=2)
        found: Floats = (inside + self._rest @ box) * (1.0 + ROUGHLY)
        return found
