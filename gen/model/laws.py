"""Heat flows that are not proportional to the difference of two temperatures: natural convection and radiation.

A path with a law carries G * law(one, other), where the law is a difference in K: the one that would drive as much heat
if the path were an ordinary one of conductance G. It grows with the first temperature and falls with the second, so a
network with laws is monotone as one without them is (Smith, Monotone Dynamical Systems, chapter 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gen.arrays import FloatArray

ZERO_C = 273.15
"""0 degC in K."""


@dataclass(frozen=True)
class Convection:
    """Natural convection: ``d f(|d|)``, d the difference of both ends, f a polynomial.

    Parameters
    ----------
    polynomial
        f over |d| in K, highest power first, of degree 3 at most.
    """

    polynomial: tuple[float, ...]

    def driving(self, one: ArrayLike, other: ArrayLike) -> FloatArray:
        """The difference in K that counts, of two temperatures in degC, any shape."""
        difference = np.asarray(one, dtype=np.float64) - np.asarray(other, dtype=np.float64)
        return np.asarray(difference * _value(self.polynomial, np.abs(difference)), dtype=np.float64)

    def slope(self, one: ArrayLike, other: ArrayLike) -> FloatArray:
        """Its derivative by the first temperature; by the second it is the same with the other sign."""
        difference = np.asarray(one, dtype=np.float64) - np.asarray(other, dtype=np.float64)
        return np.asarray(_value(self.slopes, np.abs(difference)), dtype=np.float64)

    @property
    def slopes(self) -> tuple[float, ...]:
        """(x f(x))' as a polynomial, highest power first."""
        return tuple((power + 1) * c for power, c in zip(_powers(self.polynomial), self.polynomial, strict=True))

    @property
    def curvatures(self) -> tuple[float, ...]:
        """(x f(x))'' as a polynomial, highest power first."""
        return tuple(power * c for power, c in zip(_powers(self.polynomial), self.slopes, strict=True))[:-1] or (0.0,)

    def slope_ends(self, low: float, high: float) -> tuple[float, float]:
        """Least and largest slope between any two temperatures of a range, degC."""
        values = self.slope(_turning(self.slopes, high - low), 0.0)
        return float(values.min()), float(values.max())

    def steepest(self, low: float, high: float) -> float:
        """Largest magnitude of the slope's own slope there, 1/K."""
        return float(np.abs(np.polyval(np.asarray(self.curvatures), _turning(self.curvatures, high - low))).max())


@dataclass(frozen=True)
class Radiation:
    """Radiation: ``(one^4 - other^4) / (4 reference^3)``, in kelvin.

    Parameters
    ----------
    reference
        degC; at this temperature of both ends the conductance is that of the path.
    """

    reference: float

    def driving(self, one: ArrayLike, other: ArrayLike) -> FloatArray:
        """The difference in K that counts, of two temperatures in degC, any shape."""
        warm, cold = (np.asarray(end, dtype=np.float64) + ZERO_C for end in (one, other))
        mean = (warm + cold) * (warm * warm + cold * cold)
        return np.asarray((warm - cold) * (mean / (4.0 * (self.reference + ZERO_C) ** 3)), dtype=np.float64)

    def slope(self, one: ArrayLike, other: ArrayLike) -> FloatArray:
        """Its derivative by the first temperature, whatever the second one."""
        warm, _ = np.broadcast_arrays(np.asarray(one, dtype=np.float64), np.asarray(other, dtype=np.float64))
        return np.asarray(((warm + ZERO_C) / (self.reference + ZERO_C)) ** 3, dtype=np.float64)

    def slope_ends(self, low: float, high: float) -> tuple[float, float]:
        """Least and largest slope in a range of temperatures, degC."""
        return float(self.slope(low, low)), float(self.slope(high, high))

    def steepest(self, low: float, high: float) -> float:
        """Largest of the slope's own slope there, 1/K."""
        del low
        return 3.0 * (high + ZERO_C) ** 2 / (self.reference + ZERO_C) ** 3


Law = Convection | Radiation


class LawsTogether:
    """Several laws at once, as integration asks for them: one for each column of both temperatures.

    Parameters
    ----------
    laws
        In the columns' order.
    """

    def __init__(self, laws: Sequence[Law]) -> None:
        longest = max((len(law.polynomial) for law in laws if isinstance(law, Convection)), default=1)
        self._polynomials = np.zeros((longest, len(laws)))
        self._radiating = np.zeros(len(laws))
        for k, law in enumerate(laws):
            if isinstance(law, Convection):
                self._polynomials[longest - len(law.polynomial) :, k] = law.polynomial
            else:
                self._radiating[k] = 0.25 * (law.reference + ZERO_C) ** -3
        self._radiates = bool(self._radiating.any())

    @property
    def arrays(self) -> tuple[FloatArray, FloatArray]:
        """Polynomials of convection, highest power first, shape (powers, laws), and factors of radiation, (laws,)."""
        return self._polynomials, self._radiating

    def driving(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """The differences in K that count, of temperatures in degC, shape (.., laws)."""
        difference = one - other
        apart = np.abs(difference)
        factor = self._polynomials[0]
        for coefficients in self._polynomials[1:]:
            factor = factor * apart + coefficients
        if self._radiates:
            warm, cold = one + ZERO_C, other + ZERO_C
            factor = factor + self._radiating * ((warm + cold) * (warm * warm + cold * cold))
        return np.asarray(difference * factor, dtype=np.float64)


def _powers(polynomial: tuple[float, ...]) -> range:
    return range(len(polynomial) - 1, -1, -1)


def _value(polynomial: tuple[float, ...], at: FloatArray) -> FloatArray:
    """By Horner's scheme, any shape: what solutions are integrated with has no time for `np.polyval`."""
    value = np.full_like(at, polynomial[0])
    for coefficient in polynomial[1:]:
        value = value * at + coefficient
    return value


def _turning(polynomial: tuple[float, ...], widest: float) -> FloatArray:
    """Where in 0 .. widest a polynomial of degree 3 at most is least and greatest, among others."""
    turns = np.roots(np.polyder(np.asarray(polynomial))) if len(polynomial) > 1 else np.zeros(0)
    return np.unique([0.0, *np.clip(turns.real, 0.0, widest), widest])
