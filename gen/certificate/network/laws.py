"""Paths on which heat does not go with the difference of both temperatures: what counts instead, and how it bends.

Natural convection, d f(|d|) with a polynomial f, and radiation, (T^4 - T_other^4) / (4 T_reference^3) in kelvin. Ends
are enclosed: polynomials on many short pieces by their middles and the largest of their derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.exact import ROUGHLY
from gen.certificate.network.document import NetworkCertificate, Path
from gen.certificate.network.forms import Form, Space

ZERO_C = 273.15
_PIECES = 1 << 15
Ends = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Law:
    """One path's law.

    Attributes
    ----------
    path
        Its path's position.
    first, second
        States at its ends; None for the ambient.
    polynomial
        Of natural convection, over a magnitude in K, highest power first; empty for radiation.
    reference
        Of radiation, in kelvin.
    scale
        What drives counts as that much less, and the path's rates as that much more.
    """

    path: int
    first: int
    second: int | None
    polynomial: tuple[float, ...]
    reference: float
    scale: float

    @property
    def slopes(self) -> tuple[float, ...]:
        """(x f(x))' as a polynomial."""
        return tuple((len(self.polynomial) - k) * c for k, c in enumerate(self.polynomial))

    def driving(self, one: float, other: float) -> tuple[float, float]:
        """What counts of two temperatures in degC, K, and a magnitude that its error is a share of."""
        if self.polynomial:
            d = one - other
            size = (abs(one) + abs(other)) * float(np.polyval(np.abs(self.slopes), abs(d)))
            return d * float(np.polyval(self.polynomial, abs(d))) / self.scale, size / self.scale
        warm, cold = ((end + ZERO_C) / self.reference for end in (one, other))
        share = self.reference / (4.0 * self.scale)
        return (warm**4 - cold**4) * share, 8.0 * (warm**4 + cold**4) * share

    def driving_ends(self, one: Ends, other: Ends) -> Ends:
        """The least and the largest that counts between two ranges: it grows with one end and falls with the other."""
        (low, size), (high, more) = self.driving(one[0], other[1]), self.driving(one[1], other[0])
        return low - ROUGHLY * size, high + ROUGHLY * more

    def slope_ends(self, one: Ends, other: Ends) -> Ends:
        """The least and the largest of its slope by the first temperature."""
        if self.polynomial:
            low, high = enclosed(self.slopes, _widest(one, other))
            if min(self.slopes) >= 0.0:  # then it is not negative anywhere, also where the enclosure reaches below 0
                low = max(low, 0.0)
        else:
            low, high = (((end + ZERO_C) / self.reference) ** 3 for end in one)
        return low / self.scale * (1.0 - ROUGHLY), high / self.scale * (1.0 + ROUGHLY)

    def steepest(self, one: Ends, other: Ends) -> float:
        """Largest magnitude of the slope's own slope, 1/K."""
        if self.polynomial:
            low, high = enclosed(_derivative(self.slopes), _widest(one, other))
            most = max(-low, high)
        else:
            most = 3.0 * ((max(map(abs, one)) + ZERO_C) / self.reference) ** 2 / self.reference
        return most / self.scale * (1.0 + ROUGHLY)

    def driving_form(self, space: Space, one: Form, other: Form | None) -> Form:
        """What counts as a form of two temperatures in degC, or of a difference that is not negative alone."""
        if self.polynomial:
            return _polynomial(space, (*self.polynomial, 0.0), one).times(1.0 / self.scale)
        assert other is not None
        parts = [self._share(space, end) for end in (one, other)]
        warm, cold = (part.product(part).product(part).product(part) for part in parts)
        return (warm - cold).times(self.reference / (4.0 * self.scale))

    def slope_form(self, space: Space, one: Form) -> Form:
        """Its slope likewise."""
        if self.polynomial:
            return _polynomial(space, self.slopes, one).times(1.0 / self.scale)
        part = self._share(space, one)
        return part.product(part).product(part).times(1.0 / self.scale)

    def _share(self, space: Space, one: Form) -> Form:
        return (one + space.number(ZERO_C)).times(1.0 / self.reference)


def laws(certificate: NetworkCertificate) -> list[Law]:
    """The laws of all paths that carry heat at any |PWM|."""
    found = []
    for number, path in enumerate(certificate.equations.paths):
        if path.has_law and any(path.conductance_W_per_K):
            found.append(_law(number, path))
    return found


def _law(number: int, path: Path) -> Law:
    first, second = path.between
    reference = 0.0 if path.radiation_degC is None else path.radiation_degC + ZERO_C
    return Law(number, first, second, tuple(path.convection or ()), reference, path.scale)


def enclosed(polynomial: Sequence[float], widest: float) -> Ends:
    """Ends of a polynomial over 0 .. widest, outward."""
    half = widest / (2 * _PIECES)
    middles = (2.0 * np.arange(_PIECES) + 1.0) * half
    values = np.polyval(np.asarray(polynomial), middles)
    steep = _derivative(polynomial)
    # Along each piece it moves from its middle's value by its largest slope there at most.
    steepest = np.abs(np.polyval(np.asarray(steep), middles)) + half * float(
        np.polyval(np.abs(_derivative(steep)), widest)
    )
    size: FloatArray = np.asarray(np.polyval(np.abs(polynomial), middles + half))
    moved = steepest * half * (1.0 + ROUGHLY) + size * ROUGHLY
    return float((values - moved).min()), float((values + moved).max())


def _derivative(polynomial: Sequence[float]) -> list[float]:
    powers = range(len(polynomial) - 1, 0, -1)
    return [power * float(c) for power, c in zip(powers, polynomial, strict=False)] or [0.0]


def _widest(one: Ends, other: Ends) -> float:
    return max(one[1] - other[0], other[1] - one[0]) * (1.0 + ROUGHLY)


def _polynomial(space: Space, coefficients: Sequence[float], x: Form) -> Form:
    total = space.number(coefficients[0])
    for coefficient in coefficients[1:]:
        total = total.product(x) + space.number(coefficient)
    return total
