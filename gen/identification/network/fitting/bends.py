"""How a smooth factor over speed bends: its logarithm is a cubic spline through six knots.

The knots' values are a Gaussian process, so any smooth curve is within reach and none is wilder than the runs ask for.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from gen.arrays import FloatArray

KNOTS = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
"""Speeds w, |PWM| over full scale."""
BEND, SMOOTH, ROUGH = 0.8, 0.35, 0.01
"""Standard deviation of the logarithm of the bend, the share of full speed over which it stays alike, and the share of
its variance that each knot has for itself."""


@dataclass(frozen=True, eq=False)
class Bend:
    """A smooth curve over speed: the cubic spline through knots whose values are a Gaussian process.

    Attributes
    ----------
    knots
        Speeds w, from 0 to 1.
    smooth
        Share of full speed over which it stays alike.
    rough
        Share of its variance that each knot has for itself.
    """

    knots: FloatArray
    smooth: float
    rough: float

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self.knots, np.eye(self.knots.size), bc_type="natural")

    def __call__(self, speed: FloatArray) -> FloatArray:
        """Give the splines that are 1 at one knot, shape (L, knots)."""
        return np.asarray(self._spline(np.clip(speed, 0.0, 1.0)), dtype=np.float64)

    def precision(self) -> FloatArray:
        """Give the inverse of the covariance of its values at the knots, shape (knots, knots)."""
        gap = (self.knots[:, None] - self.knots) / self.smooth
        spread = np.exp(-0.5 * gap**2) + self.rough * np.eye(self.knots.size)
        return np.asarray(np.linalg.inv(BEND**2 * spread), dtype=np.float64)


WIDE = Bend(KNOTS, SMOOTH, ROUGH)
"""As identification lets curves bend."""


def spline(speed: FloatArray) -> FloatArray:
    """Give the cubic splines that are 1 at one knot, shape (L, knots)."""
    return WIDE(speed)


def bend_precision() -> FloatArray:
    """Give the inverse of the bends' covariance at the knots, shape (knots, knots)."""
    return WIDE.precision()
