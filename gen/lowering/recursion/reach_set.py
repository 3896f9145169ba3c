"""An invariant polytope, read in any direction without trust in float64."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.recursion.fan import Fan
from gen.lowering.recursion.no_proof import NoProofError

#: A sum of n products in float64 is off by at most n + 1 of these, relative to the sum of their magnitudes.
ROUNDING = 2.0**-52
#: With how many directions a facet is sought at once.
_TOGETHER = 1024


@dataclass(frozen=True)
class ReachSet:
    """An invariant polytope; :meth:`extent` reads it in any direction.

    Attributes
    ----------
    height
        h_j, shape (J,).
    """

    _fan: Fan
    height: FloatArray

    @property
    def directions(self) -> FloatArray:
        """The polytope's directions c_j in the state's coordinates, shape (J, n)."""
        return self._fan.directions

    @cached_property
    def axes(self) -> FloatArray:
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
    def shape(self) -> FloatArray:
        """What makes :attr:`directions` unit vectors, shape (n, n)."""
        return self._fan.shape

    def extent(self, direction: FloatArray) -> float:
        """Upper bound of ``|direction . y|`` over everything that can be reached."""
        return float(self.extents(np.asarray(direction, dtype=np.float64)[None, :])[0])

    def extents(self, directions: FloatArray) -> FloatArray:
        """:meth:`extent` of many directions, shape (k, n); the result has shape (k,)."""
        if not self.height.any():
            return np.zeros(len(directions))
        values, rest = self._combined(directions)
        found: FloatArray = values + (np.abs(rest) + self._rounded(directions)) @ self.axes
        return found

    def _combined(self, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
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
        return values * (1.0 + 8.0 * ROUNDING), rests

    def _rounded(self, directions: FloatArray) -> FloatArray:
        """What float64 may hide of a direction's rest, shape (k, n): no term is much larger than the direction."""
        n = directions.shape[1]
        largest = np.abs(self._fan.directions).max(axis=0) * np.abs(directions @ self._fan.shape).sum(axis=1)[:, None]
        hidden: FloatArray = 8.0 * (n + 1) * ROUNDING * (np.abs(directions) + n * largest)
        return hidden


def support(directions: FloatArray, generators: FloatArray) -> FloatArray:
    """Sums over k of ``|c_j . g_pk|``, not below them, shape (J, p), for generators of shape (p, k, n)."""
    found = np.abs(np.einsum("pkn,jn->jpk", generators, directions)).sum(axis=2)
    hidden = np.abs(directions) @ np.abs(generators).sum(axis=1).T
    result: FloatArray = found * (1.0 + generators.shape[1] * ROUNDING) + (directions.shape[1] + 1) * ROUNDING * hidden
    return result
