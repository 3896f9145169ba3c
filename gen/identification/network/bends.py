"""How a smooth factor over speed bends: its logarithm is a cubic spline through six knots.

The knots' values are a Gaussian process, so any smooth curve is within reach and none is wilder than the runs ask for.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from gen.identification.network.bins import FloatArray

KNOTS = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
"""Speeds w, |PWM| over full scale."""
BEND, SMOOTH = 0.8, 0.35
"""Standard deviation of the logarithm of the bend, and the share of full speed over which it stays alike."""

_SPLINE = CubicSpline(KNOTS, np.eye(KNOTS.size), bc_type="natural")


def spline(speed: FloatArray) -> FloatArray:
    """Give the cubic splines that are 1 at one knot, shape (L, knots)."""
    return np.asarray(_SPLINE(np.clip(speed, 0.0, 1.0)), dtype=np.float64)


def bend_precision() -> FloatArray:
    """Give the inverse of the bends' covariance at the knots, shape (knots, knots)."""
    gap = (KNOTS[:, None] - KNOTS) / SMOOTH
    return np.asarray(np.linalg.inv(BEND**2 * (np.exp(-0.5 * gap**2) + 0.01 * np.eye(KNOTS.size))), dtype=np.float64)
