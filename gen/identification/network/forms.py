"""How far a known curve over speed may be off: by a smooth factor.

The logarithm of the factor is a sum of known functions of the speed w (|PWM| over full scale) times free numbers: its
level, and what bends it. Bends are a cubic spline through six knots whose values are a Gaussian process, so any smooth
curve is within reach and none is wilder than the runs ask for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from gen.identification.network.bins import FloatArray

KNOTS = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
BEND, SMOOTH = 0.8, 0.35
"""Standard deviation of the logarithm of the bend, and the share of full speed over which it stays alike."""
SLOW = 0.2
"""Speed to which the conductance at rest is compared."""

_SPLINE = CubicSpline(KNOTS, np.eye(KNOTS.size), bc_type="natural")


@dataclass(frozen=True, eq=False)
class Form:
    """One kind of factor over speed, k free numbers.

    Attributes
    ----------
    name
        For people.
    terms
        What the numbers are.
    at_rest
        Functions at rest, shape (k,); empty where the curve is zero there.
    precision
        Of the bends, the other entries 0, shape (k, k).
    level
        Which of them is the level.
    """

    name: str
    terms: tuple[str, ...]
    at_rest: FloatArray
    precision: FloatArray
    level: int

    @property
    def size(self) -> int:
        """How many."""
        return len(self.terms)

    def turning(self, speed: FloatArray) -> FloatArray:
        """Give the functions while it turns, shape (L, k)."""
        w = np.asarray(speed, dtype=np.float64)
        if self is WITHIN:
            return np.column_stack([np.ones_like(w), w - 0.5])
        first = [np.zeros_like(w)] if self is OUTSIDE else []
        return np.column_stack([*first, np.ones_like(w), spline(w)])


def spline(speed: FloatArray) -> FloatArray:
    """Give the cubic splines that are 1 at one knot, shape (L, knots)."""
    return np.asarray(_SPLINE(np.clip(speed, 0.0, 1.0)), dtype=np.float64)


def bend_covariance(deviation: float) -> FloatArray:
    """Give the covariance of the bends at the knots, shape (knots, knots).

    Parameters
    ----------
    deviation
        Standard deviation at each knot.
    """
    gap = (KNOTS[:, None] - KNOTS) / SMOOTH
    return np.asarray(deviation**2 * (np.exp(-0.5 * gap**2) + 0.01 * np.eye(KNOTS.size)))


def _last(size: int, block: FloatArray) -> FloatArray:
    made = np.zeros((size, size))
    made[size - len(block) :, size - len(block) :] = block
    return made


_BENDS = tuple(f"bend at {knot:g}" for knot in KNOTS)
_PRECISION: FloatArray = np.asarray(np.linalg.inv(bend_covariance(BEND)), dtype=np.float64)

OUTSIDE = Form(
    name="to the ambient",
    terms=("at rest", "level", *_BENDS),
    at_rest=np.concatenate([[1.0, 1.0], spline(np.array([SLOW]))[0]]),
    precision=_last(2 + KNOTS.size, _PRECISION),
    level=1,
)
WITHIN = Form(
    name="within the motor",
    terms=("level", "slope"),
    at_rest=np.array([1.0, -0.5]),
    precision=np.zeros((2, 2)),
    level=0,
)
HEAT = Form(
    name="heat",
    terms=("level", *_BENDS),
    at_rest=np.zeros(0),
    precision=_last(1 + KNOTS.size, _PRECISION),
    level=0,
)
