"""How conductances and heats go with speed: a sum of powers whose shares are free, and a smooth factor on it.

With w, |PWM| over full scale, a path to the ambient is still air and moved air; a heat is what a current against dry
friction gives at any speed, friction and iron, and what grows with the square. What no run shows, rest above all,
follows from the same law: still air is what is left of a conductance as w goes to 0. The smooth factor, a cubic spline
through six knots whose values are a Gaussian process, takes what such a law cannot follow (a sudden change to
turbulence, a Stribeck curve).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gen.arrays import FloatArray
from gen.compiled import compiled
from gen.identification.network.fitting.bends import BEND, KNOTS, bend_precision, spline

MOVED_POWER = 1.0
"""Of moved air. Along a wall it goes with w^0.5 (laminar) to w^0.8 (turbulent), but still and moved air combine as the
third root of the sum of their cubes (Churchill, AIChE Journal 23, 1977): near rest, where still air is the larger, next
to nothing is added, and the power is near 2. A straight line from rest stands between both."""
MOVED = (-0.5, 2.0)
"""Logarithm of what moved air adds at full speed over still air, mean and standard deviation: a motor without a fan of
its own has 5 to 10 W/m2K in still air, radiation included, and 10 to 30 in the air that it moves; one that drives a
propeller has ten times as much."""
AT_REST = 0.4
"""Standard deviation of the logarithm of one conductance at rest over what its law leaves there."""
ALL_AT_REST = 0.3
"""The same of what all conductances at rest have in common: still air gives 5 to 10 W/m2K, a factor of two, and what it
is by depends on how warm the whole motor is."""
STEADY, SQUARE = (-1.0, 1.5), (0.0, 1.5)
"""Logarithms of a heat's constant and of its quadratic part over its linear one, at full speed."""
SLOPE = 0.5
"""Standard deviation of the change of a path's logarithm from rest to full speed, within the motor: most of them are
metal, which does not know of speed; air gaps do."""
SLOWEST = 1e-3


class Basis(NamedTuple):
    """What the curves of one kind are made of at L speeds.

    Attributes
    ----------
    powers
        Terms of the sum, shape (L, P).
    factor
        Terms of the smooth factor's logarithm, shape (L, F).
    """

    powers: FloatArray
    factor: FloatArray


@dataclass(frozen=True, eq=False)
class Law:
    """One kind of curve over speed, k free numbers.

    Attributes
    ----------
    name
        For people.
    terms
        What the numbers are: at rest (paths to the ambient), the level, the shares, the factor's.
    powers
        Exponents of the sum; the shares of all but the first are free.
    level
        Place of the level: the logarithm of the sum at full speed.
    factor
        What the smooth factor is made of: `bends`, a `slope`, or nothing.
    mean, precision
        Of the numbers but the level's, whose prior is the motor's scale: shapes (k,) and (k, k), the level's entries 0.
    """

    name: str
    terms: tuple[str, ...]
    powers: tuple[float, ...]
    level: int
    factor: str
    mean: FloatArray
    precision: FloatArray

    @property
    def size(self) -> int:
        """How many."""
        return len(self.terms)

    def bending(self, by: float) -> FloatArray:
        """Give the precision where curves bend by another standard deviation, shape (k, k)."""
        made = self.precision.copy()
        if self.factor == "bends":
            made[-KNOTS.size :, -KNOTS.size :] *= (BEND / by) ** 2
        return made

    def basis(self, speed: FloatArray) -> Basis:
        """Give what every curve of this kind is made of while it turns, at |PWM| over full scale, shape (L,)."""
        w = np.asarray(speed, dtype=np.float64)
        return Basis(np.maximum(w, SLOWEST)[:, None] ** np.array(self.powers), self._factor(w))

    def evaluated(self, basis: Basis, own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give the logarithm while it turns, and its derivatives.

        Parameters
        ----------
        basis
            At L speeds.
        own
            Numbers of one curve, shape (k,), or of m, shape (m, k).

        Returns
        -------
        logarithm, derivatives
            Shapes (L,) and (L, k), or (L, m) and (L, m, k).
        """
        curves = np.ascontiguousarray(np.atleast_2d(own), dtype=np.float64)
        logs = np.empty((len(basis.powers), len(curves)))
        slopes = np.zeros((*logs.shape, self.size))
        _evaluate(basis.powers, basis.factor, curves, self.level, logs, slopes)
        return (logs, slopes) if own.ndim > 1 else (logs[:, 0], slopes[:, 0])

    def at_rest(self, own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give the logarithm of a conductance at rest, and its derivatives: of one curve, or of m (see `evaluated`)."""
        value, slopes = self.evaluated(self._resting, own)
        if self.level == 0:
            return value[0], slopes[0]
        slopes[0, ..., 0] = 1.0
        return np.asarray(value[0] + own[..., 0]), slopes[0]

    @cached_property
    def _resting(self) -> Basis:
        return Basis((np.array([self.powers]) == 0.0).astype(np.float64), self._factor(np.zeros(1)))

    def _factor(self, w: FloatArray) -> FloatArray:
        if self.factor == "bends":
            return spline(w)
        return (w - 0.5)[:, None] if self.factor == "slope" else np.empty((w.size, 0))


@compiled
def _evaluate(
    powers: FloatArray, factor: FloatArray, own: FloatArray, level: int, logs: FloatArray, slopes: FloatArray
) -> None:
    """Fill in logarithms, shape (L, m), and derivatives, shape (L, m, k); arguments as in `Basis`, and of `Law`."""
    further = powers.shape[1] - 1
    shares = np.empty(further)
    for curve in range(own.shape[0]):
        whole = 1.0
        for p in range(further):
            shares[p] = np.exp(min(max(own[curve, level + 1 + p], -30.0), 30.0))
            whole += shares[p]
        for at in range(powers.shape[0]):
            total = powers[at, 0]
            for p in range(further):
                total += powers[at, 1 + p] * shares[p]
            value = np.log(total / whole) + own[curve, level]
            slopes[at, curve, level] = 1.0
            for p in range(further):
                slopes[at, curve, level + 1 + p] = powers[at, 1 + p] * shares[p] / total - shares[p] / whole
            for f in range(factor.shape[1]):
                place = level + 1 + further + f
                value += factor[at, f] * own[curve, place]
                slopes[at, curve, place] = factor[at, f]
            logs[at, curve] = value


def _law(
    name: str, numbers: Mapping[str, tuple[float, float]], powers: tuple[float, ...] = (0.0,), factor: str = ""
) -> Law:
    """Make a law of means and standard deviations; a standard deviation of 0 marks the level."""
    own = len(numbers)
    terms = (*numbers, *(f"bend at {knot:g}" for knot in KNOTS)) if factor == "bends" else tuple(numbers)
    mean, precision = np.zeros(len(terms)), np.zeros((len(terms), len(terms)))
    mean[:own] = [middle for middle, _ in numbers.values()]
    precision[range(own), range(own)] = [deviation**-2 if deviation else 0.0 for _, deviation in numbers.values()]
    if factor == "bends":
        precision[own:, own:] = bend_precision()
    return Law(name, terms, powers, list(numbers).index("level"), factor, mean, precision)


_LEVEL = (0.0, 0.0)
OUTSIDE = _law(
    "to the ambient", {"at rest": (0.0, AT_REST), "level": _LEVEL, "moved": MOVED}, (0.0, MOVED_POWER), "bends"
)
WITHIN = _law("within the motor", {"level": _LEVEL, "slope": (0.0, SLOPE)}, factor="slope")
CONSTANT = _law("within the motor, the same at every speed", {"level": _LEVEL})
HEAT = _law("heat", {"level": _LEVEL, "steady": STEADY, "square": SQUARE}, (1.0, 0.0, 2.0), "bends")
