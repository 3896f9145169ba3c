"""Numbers as polynomials: affine in temperatures, of any degree in factors, and a radius for everything else.

A temperature is middle + half t, a factor middle + half p, with |t| <= 1 and |p| <= 1. So a form ranges over its
constant +- the sum of its other coefficients' magnitudes. Coefficients are float64, at all |PWM| of the domain side by
side; what that rounds goes into the radius, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.exact import ROUGHLY
from gen.certificate.refuted import Refuted

#: A sum of k terms or products is right to (k + 1) 2^-53 of their magnitudes: this for each of them.
_UNIT = 2.0**-52
#: Share of the radius below which a power of factors is not worth to be kept.
_SHARE = 1e-4
Powers = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Form:
    """A number.

    Attributes
    ----------
    terms
        By powers of the factors' p: coefficients of 1 and of every t, shape (symbols + 1, P).
    radius
        How far it may lie from that, shape (P,).
    """

    terms: Mapping[Powers, FloatArray]
    radius: FloatArray

    @cached_property
    def magnitude(self) -> FloatArray:
        """A bound of the sum of its terms' magnitudes, without the radius, shape (P,)."""
        total: FloatArray = sum((np.abs(c).sum(axis=0) for c in self.terms.values()), np.zeros_like(self.radius))
        return total * (1.0 + ROUGHLY)

    @cached_property
    def scalar(self) -> bool:
        """Whether no temperature has a part in it."""
        return not any(c[1:].any() for c in self.terms.values())

    @cached_property
    def known(self) -> bool:
        """Whether it is one number at each |PWM|."""
        return not self.radius.any() and self.scalar and all(not any(powers) for powers in self.terms)

    @property
    def constant(self) -> FloatArray:
        """Its middle, shape (P,)."""
        found: FloatArray = next(
            (c[0] for powers, c in self.terms.items() if not any(powers)), np.zeros_like(self.radius)
        )
        return found

    @cached_property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """The least and the largest that it can be, shape (P,) each, rounded outward."""
        middle = self.constant
        half = (self.magnitude - np.abs(middle)) + self.radius + ROUGHLY * (self.magnitude + self.radius)
        return (middle, middle) if self.known else (middle - half, middle + half)

    @property
    def largest(self) -> FloatArray:
        """A bound of its magnitude, shape (P,)."""
        low, high = self.ends
        found: FloatArray = np.maximum(np.abs(low), np.abs(high))
        return found

    def __add__(self, other: Form) -> Form:
        terms = dict(self.terms)
        for powers, coefficients in other.terms.items():
            terms[powers] = terms[powers] + coefficients if powers in terms else coefficients
        radius = self.radius + other.radius
        return Form(terms, (radius + _UNIT * (self.magnitude + other.magnitude)) * (1.0 + ROUGHLY))

    def __sub__(self, other: Form) -> Form:
        return self + other.times(-1.0)

    def times(self, factor: float | FloatArray) -> Form:
        """The product with a number, the same or one for each |PWM|."""
        terms = {powers: coefficients * factor for powers, coefficients in self.terms.items()}
        if np.all(np.frexp(np.abs(factor))[0] == 0.5):  # a power of two: nothing is rounded
            return Form(terms, self.radius * np.abs(factor))
        return Form(terms, (self.radius + _UNIT * self.magnitude) * np.abs(factor) * (1.0 + ROUGHLY))

    def product(self, other: Form) -> Form:
        """The product of two of which temperatures have a part in one at most.

        Raises
        ------
        Refuted
            If they have in both.
        """
        one, many = (self, other) if self.scalar else (other, self)
        if not one.scalar:
            raise Refuted("a product of two temperatures")
        terms: dict[Powers, FloatArray] = {}
        for powers, factor in one.terms.items():
            for others, coefficients in many.terms.items():
                key = tuple(a + b for a, b in zip(powers, others, strict=True))
                made = factor[0][None, :] * coefficients
                terms[key] = terms[key] + made if key in terms else made
        rounded = _UNIT * (len(one.terms) + 1) * one.magnitude * many.magnitude
        radius = one.magnitude * many.radius + one.radius * many.magnitude + one.radius * many.radius
        return Form(terms, (radius + rounded) * (1.0 + ROUGHLY))

    def within(self, radius: float | FloatArray) -> Form:
        """The number give or take something."""
        return Form(self.terms, (self.radius + radius) * (1.0 + ROUGHLY))

    def trimmed(self, least: float = 0.0) -> Form:
        """The same with small powers of factors counted as part of the radius: `least`, or a share of the radius."""
        kept, radius = dict(self.terms), self.radius
        for powers, coefficients in self.terms.items():
            size = np.abs(coefficients).sum(axis=0) * (1.0 + ROUGHLY)
            if sum(powers) > 1 and np.all(size <= np.maximum(least, _SHARE * self.radius)):
                del kept[powers]
                radius = (radius + size) * (1.0 + ROUGHLY)
        return Form(kept, radius)


class Space:
    """What temperatures and factors range over.

    Parameters
    ----------
    temperatures
        Ends of each, in any unit.
    factors
        Ends of each.
    rows
        How many |PWM| there are.
    """

    def __init__(
        self, temperatures: Sequence[tuple[float, float]], factors: Sequence[tuple[float, float]], rows: int
    ) -> None:
        self._temperatures, self._factors, self.rows = temperatures, factors, rows
        self._none: Powers = (0,) * len(factors)

    def number(self, value: float | FloatArray, radius: float | FloatArray = 0.0) -> Form:
        """A number, the same or one for each |PWM|."""
        coefficients = np.zeros((len(self._temperatures) + 1, self.rows))
        coefficients[0] = value
        return Form({self._none: coefficients}, np.zeros(self.rows) + radius)

    def temperature(self, place: int) -> Form:
        """One of the temperatures."""
        middle, half = _about(*self._temperatures[place])
        coefficients = np.zeros((len(self._temperatures) + 1, self.rows))
        coefficients[0], coefficients[place + 1] = middle, half
        return Form({self._none: coefficients}, np.zeros(self.rows))

    def factor(self, place: int) -> Form:
        """One of the factors."""
        middle, half = _about(*self._factors[place])
        made = self.number(middle)
        powers = tuple(int(k == place) for k in range(len(self._factors)))
        return Form({**made.terms, powers: self.number(half).terms[self._none]}, made.radius)


def _about(low: float, high: float) -> tuple[float, float]:
    """Middle and half width, that hold both ends."""
    middle = (low + high) / 2.0
    return middle, max(high - middle, middle - low) * (1.0 + ROUGHLY) + abs(middle) * ROUGHLY
