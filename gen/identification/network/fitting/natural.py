"""Natural convection: still air takes the more from a surface, for each kelvin, the warmer the surface is.

Along a wall in still air the coefficient goes with the fourth root of the difference (laminar; Churchill and Chu,
International Journal of Heat and Mass Transfer 18, 1975). A surface at rest loses a share of its heat in this way; the
rest, radiation above all, goes about with the difference. The share is one number for all surfaces of a motor. Where
the motor moves the air both combine as the third root of the sum of their cubes (Churchill, AIChE Journal 23, 1977): of
a conductance G, G0 at rest, still air's part by its own slope is (G0 / G)^2, so what the difference changes is

    share * G0 * (G0 / G)^2 * d * (f(d) - 1),    f(d) about (d / 20 K)^(1/4)

f is a polynomial, the one that the coefficient file holds and the board evaluates.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.marching import excess_of
from gen.identification.network.fitting.partial import Partial

USUAL_K = 20.0
"""The difference at which conductances are what their curves over speed say."""
FOURTH_ROOT = (1.4366, -2.7230, 1.9512, 0.3746)
"""x^(1/4) from 0 to 1: within 4 % from 0.05 on."""
FARTHEST = 1.5
"""Of the widest difference: what a search tries beyond it counts as this."""


@dataclass(frozen=True, eq=False)
class Natural:
    """What goes by natural convection at L distinct inputs.

    Attributes
    ----------
    conductance
        Of each node to the ambient, by natural convection, at the usual difference, shape (L, n), W/K.
    by_conductance
        Its derivatives, W/K.
    widest
        The largest difference that occurs, K.
    """

    conductance: FloatArray
    by_conductance: Partial
    widest: float

    def excess(self, difference: FloatArray) -> FloatArray:
        """What drives heat beyond the difference itself, any shape, K."""
        return np.asarray(excess_of(difference, self.factors, self.limit))

    def slope(self, difference: FloatArray) -> FloatArray:
        """Its derivative by the difference."""
        held, (a, b, c, d) = np.minimum(np.abs(difference), self.limit), self.factors
        inside = np.abs(difference) <= self.limit
        by_held = (3.0 * a * held + 2.0 * b) * held + c
        return np.asarray(((a * held + b) * held + c) * held + (d - 1.0) + inside * held * by_held)

    @cached_property
    def factors(self) -> FloatArray:
        """Of the polynomial, highest power first, shape (4,)."""
        return polynomial(self.widest)

    @property
    def limit(self) -> float:
        """What all beyond it counts as, K."""
        return FARTHEST * self.widest


def polynomial(widest: float) -> FloatArray:
    """Give f over |d| in K up to the widest difference, highest power first, shape (4,)."""
    powers = np.arange(len(FOURTH_ROOT))[::-1]
    return np.asarray(np.array(FOURTH_ROOT) * (widest / USUAL_K) ** 0.25 / widest**powers, dtype=np.float64)
