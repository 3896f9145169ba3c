"""How far a known curve over speed may be off: by a smooth factor.

The logarithm of the factor is a sum of known functions of the speed w (|PWM| over full scale) times free numbers: its
level, and what bends it (`gen.identification.network.fitting.bends`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.bends import KNOTS, bend_precision, spline
from gen.identification.network.fitting.inputs import Levels

SLOW = 0.2
"""Speed to which the conductance at rest is compared."""


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


@lru_cache(maxsize=16)
def turning_at(form: Form, levels: Levels) -> FloatArray:
    """Give a form's functions at inputs, shape (L, k): a search asks for those of the same ones many hundred times."""
    return form.turning(levels.speed)


def _last(size: int, block: FloatArray) -> FloatArray:
    made = np.zeros((size, size))
    made[size - len(block) :, size - len(block) :] = block
    return made


_BENDS = tuple(f"bend at {knot:g}" for knot in KNOTS)
_PRECISION = bend_precision()

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
