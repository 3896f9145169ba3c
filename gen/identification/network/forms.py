"""How conductances and heats go with speed: a usual curve, and a smooth factor on it.

The logarithm of each is a sum of known functions of the speed w (|PWM| over full scale) times free numbers: its level,
and what bends it. Bends are a cubic spline through six knots whose values are a Gaussian process, so any smooth curve
is within reach (a sudden change to turbulence, a Stribeck curve) and none is wilder than the runs ask for.
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
REST, REST_WITHIN = -0.1, 0.4
"""Logarithm of a conductance to the ambient at rest over that at `SLOW`, and its standard deviation."""
SLOPE = 0.5
"""Standard deviation of the change of a path's logarithm from rest to full speed, for paths within the motor."""

_SPLINE = CubicSpline(KNOTS, np.eye(KNOTS.size), bc_type="natural")


@dataclass(frozen=True, eq=False)
class Form:
    """One kind of curve over speed, k free numbers.

    Attributes
    ----------
    name
        For people.
    terms
        What the numbers are.
    at_rest
        Functions at rest, shape (k,); empty where the curve is zero there.
    mean, precision
        Of the numbers but the level's, whose prior is the motor's scale: shapes (k,) and (k, k), the level's entries 0.
    level
        Which of them is the level.
    """

    name: str
    terms: tuple[str, ...]
    at_rest: FloatArray
    mean: FloatArray
    precision: FloatArray
    level: int

    @property
    def size(self) -> int:
        """How many."""
        return len(self.terms)

    def turning(self, speed: FloatArray) -> FloatArray:
        """Give the functions while it turns, shape (L, k)."""
        w = np.asarray(speed, dtype=np.float64)
        if self is CONSTANT:
            return np.ones((w.size, 1))
        if self is WITHIN:
            return np.column_stack([np.ones_like(w), w - 0.5])
        bend = spline(w)
        first = [np.zeros_like(w)] if self is OUTSIDE else []
        return np.column_stack([*first, np.ones_like(w), bend])

    def usual(self, speed: FloatArray) -> FloatArray:
        """Give the usual curve's logarithm, 0 at full speed, shape (L,)."""
        w = np.maximum(np.asarray(speed, dtype=np.float64), 1e-3)
        if self in (WITHIN, CONSTANT):
            return np.zeros_like(w)
        # Natural and forced convection; friction and what grows with the square.
        curve = 0.5 + 0.5 * w**0.8 if self is OUTSIDE else 0.5 * w + 0.5 * w**2
        return np.asarray(np.log(curve))


def spline(speed: FloatArray) -> FloatArray:
    """Give the cubic splines that are 1 at one knot, shape (L, knots)."""
    return np.asarray(_SPLINE(np.clip(speed, 0.0, 1.0)), dtype=np.float64)


def _bend_precision() -> FloatArray:
    gap = (KNOTS[:, None] - KNOTS) / SMOOTH
    covariance = BEND**2 * (np.exp(-0.5 * gap**2) + 0.01 * np.eye(KNOTS.size))
    return np.asarray(np.linalg.inv(covariance))


def _block(*parts: FloatArray) -> FloatArray:
    size = sum(len(part) for part in parts)
    made = np.zeros((size, size))
    at = 0
    for part in parts:
        made[at : at + len(part), at : at + len(part)] = part
        at += len(part)
    return made


_BENDS = tuple(f"bend at {knot:g}" for knot in KNOTS)
_NONE = np.zeros((1, 1))

OUTSIDE = Form(
    name="to the ambient",
    terms=("at rest", "level", *_BENDS),
    at_rest=np.concatenate([[1.0, 1.0], spline(np.array([SLOW]))[0]]),
    mean=np.concatenate([[REST, 0.0], np.zeros(KNOTS.size)]),
    precision=_block(np.array([[REST_WITHIN**-2]]), _NONE, _bend_precision()),
    level=1,
)
WITHIN = Form(
    name="within the motor",
    terms=("level", "slope"),
    at_rest=np.array([1.0, -0.5]),
    mean=np.zeros(2),
    precision=_block(_NONE, np.array([[SLOPE**-2]])),
    level=0,
)
CONSTANT = Form(
    name="within the motor, the same at every speed",
    terms=("level",),
    at_rest=np.ones(1),
    mean=np.zeros(1),
    precision=_NONE,
    level=0,
)
HEAT = Form(
    name="heat",
    terms=("level", *_BENDS),
    at_rest=np.zeros(0),
    mean=np.zeros(1 + KNOTS.size),
    precision=_block(_NONE, _bend_precision()),
    level=0,
)
FORMS = (OUTSIDE, WITHIN, CONSTANT, HEAT)
