"""Polytopes { u : |c_j . u| <= h_j }, read from outside and proven invariant, in whole numbers.

Everything rests on one fact. If d = sum_l w_l c_l + r with w >= 0, then over the polytope

    |d . u|  <=  sum_l w_l h_l + sum_i |r_i| b_i          b_i >= |u_i|, read off the directions along the axes.

Which w to take is a guess made in float64, as good as any: what it misses is r, and r is exact.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from gen.certificate.exact import BITS, Floats, Integers, Ratios, floats, units, whole
from gen.certificate.refuted import Refuted

Places = NDArray[np.intp]

#: A guess that leaves a weight below this looks further than the direction's own neighbours.
_ENOUGH = -1e-9
#: Bits of a weight.
_WEIGHT_BITS = 64
#: Bits after the binary point of what :meth:`Images.largest` gives.
IMAGE_BITS = BITS + _WEIGHT_BITS
#: Share by which float64 results are rounded up: some ten operations, each right to 2^-53 of its terms.
_ROUGHLY = 1e-13
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
        self.exact = units(directions)
        if np.any(self.exact * Fraction(1, 1 << BITS) != directions):
            raise Refuted("a direction is finer than 2^-BITS")
        self.order = directions.shape[1]
        self._axes = [self._along(i) for i in range(self.order)]
        approximate = directions.astype(np.float64)
        self._round = shape
        points = approximate @ self._round
        self._length = np.linalg.norm(points, axis=1)
        unit = points / self._length[:, None]
        both = np.vstack([unit, -unit])
        self._facets = (
            np.array([[0], [1]], dtype=np.intp) if self.order == 1 else ConvexHull(both).simplices.astype(np.intp)
        )
        self._inverse = np.linalg.inv(np.transpose(both[self._facets], (0, 2, 1)))
        count = len(approximate)
        self._touching: list[Places] = [np.nonzero((self._facets == j).any(axis=1))[0] for j in range(count)]

    def box(self, heights: Ratios) -> Ratios:
        """b_i of :mod:`gen.certificate.polytope`, shape (n,), for heights in any unit, shape (J,)."""
        found = [heights[j] / abs(Fraction(int(self.exact[j, i]), 1 << BITS)) for i, j in enumerate(self._axes)]
        return np.array(found, dtype=object)

    def guess(self, targets: Floats, near: int | None = None) -> tuple[Places, Integers]:
        """Which directions combine to targets, shape (k, n), and their weights in units of 2^-64, each (k, n).

        The signs of the directions are in the weights. ``near`` is the direction in whose neighbourhood they lie.
        """
        goals = targets @ self._round
        among = np.arange(len(self._facets)) if near is None else self._touching[near]
        places, weights = self._search(goals, among)
        if near is not None and (poor := weights.min(axis=1) < _ENOUGH * np.abs(weights).max(axis=1)).any():
            places[poor], weights[poor] = self._search(goals[poor], np.arange(len(self._facets)))
        count = len(self.exact)
        found = places % count
        scaled = np.maximum(weights, 0.0) / self._length[found] * np.where(places < count, 1.0, -1.0)
        return found, whole(scaled, _WEIGHT_BITS)

    def _search(self, goals: Floats, among: Places) -> tuple[Places, Floats]:
        places = np.empty((len(goals), self.order), dtype=np.intp)
        weights = np.empty((len(goals), self.order))
        for first in range(0, len(goals), _TOGETHER):
            part = slice(first, first + _TOGETHER)
            found = self._inverse[among] @ goals[part].T  # (facets, n, k)
            best = found.min(axis=1).argmax(axis=0)
            weights[part] = found[best, :, np.arange(len(best))]
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
    signed = weights * Fraction(1, 1 << _WEIGHT_BITS)
    chosen = directions.exact[places] * Fraction(1, 1 << BITS)  # (k, n, n)
    rest = targets - (signed[:, :, None] * chosen).sum(axis=1)
    found: Ratios = (np.abs(signed) * heights[places]).sum(axis=1) + (np.abs(rest) * box).sum(axis=1)
    return found


def largest_roughly(directions: Directions, heights: Ratios, targets: Floats) -> Floats:
    """:func:`largest` in float64, rounded up by far more than its own errors."""
    places, weights = directions.guess(targets)
    signed = floats(weights) * 2.0**-_WEIGHT_BITS
    chosen = floats(directions.exact[places]) * 2.0**-BITS
    terms = np.abs(signed[:, :, None] * chosen).sum(axis=1) + np.abs(targets)
    rest = np.abs(targets - (signed[:, :, None] * chosen).sum(axis=1)) + _ROUGHLY * terms
    found: Floats = (np.abs(signed) * floats(heights)[places]).sum(axis=1) + rest @ floats(directions.box(heights))
    return found * (1.0 + _ROUGHLY)


class Images:
    """The images E^T c_j of all directions under all P matrices, as combinations of directions."""

    def __init__(self, directions: Directions, transition: Integers) -> None:
        self._directions = directions
        self.exact: Integers = np.matmul(directions.exact[None], transition)  # (P, J, n), in 2^-2 BITS
        approximate = self.exact.astype(np.float64) * 2.0 ** (-2 * BITS)
        count = len(directions.exact)
        self._places = np.empty((len(transition), count, directions.order), dtype=np.intp)
        self._weights = np.empty((len(transition), count, directions.order), dtype=object)
        for j in range(count):
            self._places[:, j], self._weights[:, j] = directions.guess(approximate[:, j], near=j)

    def largest(self, row: int, heights: Integers, box: Integers) -> Integers:
        """Bounds of ``|c_j . E u|`` over a polytope at one PWM, shape (J,), in units of 2^-IMAGE_BITS.

        Parameters
        ----------
        row
            Which matrix.
        heights, box
            h_j and b_i in units of 2^-BITS.
        """
        places, weights = self._places[row], self._weights[row]
        chosen = self._directions.exact[places]  # (J, n, n), in 2^-BITS
        # In units of 2^-(2 BITS): the weights' 64 bits are taken up to BITS.
        rest = self.exact[row] - ((weights << BITS - _WEIGHT_BITS)[:, :, None] * chosen).sum(axis=1)
        inside = (np.abs(weights) * heights[places]).sum(axis=1)
        found: Integers = inside + ((np.abs(rest) * box).sum(axis=1) >> 2 * BITS - _WEIGHT_BITS) + 1
        return found
