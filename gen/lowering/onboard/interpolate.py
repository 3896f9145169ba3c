"""A sum of exponentials as one polynomial in |PWM|: a dozen numbers instead of tables for every factor of every term.

The terms of a fitted pole cancel in part; a polynomial of their sum has no digits to lose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from math import cos, pi

from gen.model.dynamics import MAX_PWM
from gen.model.schedules import EXACT

#: The board's argument is in units of 2^-8, so that it stays below 1.
SCALE_BITS = 8
_LAST = MAX_PWM
#: Error that is allowed anywhere, in parts of the largest value: half a unit of 32 bits.
_RESOLUTION = Decimal(2) ** -33
#: Places are fractions of a count, so that they are the same on every machine.
_PLACES = 256
_MOST_DEGREE = 120


class NoPolynomialError(ValueError):
    """No polynomial of a reasonable degree follows a schedule."""


@dataclass(frozen=True)
class PowerSeries:
    """A polynomial in u = x / 2^8, or in u = (255 - x) / 2^8.

    Attributes
    ----------
    reflected
        Whether it is in 255 - x.
    coefficients
        Highest power first.
    """

    reflected: bool
    coefficients: tuple[Decimal, ...]

    @classmethod
    def of_powers(cls, coefficients: Sequence[Decimal]) -> PowerSeries:
        """The same polynomial, given by its coefficients of the powers of x, highest first."""
        last = len(coefficients) - 1
        with localcontext(EXACT):
            scaled = tuple(c * 2 ** (SCALE_BITS * (last - k)) for k, c in enumerate(coefficients))
        return cls(False, scaled)

    def argument(self, x: Decimal) -> Decimal:
        """u at x."""
        return (Decimal(_LAST) - x if self.reflected else x) / Decimal(2**SCALE_BITS)

    def sums(self, x: Decimal) -> list[Decimal]:
        """What Horner's rule computes at x on its way; the last is the polynomial's value."""
        u, total, result = self.argument(x), Decimal(0), []
        for coefficient in self.coefficients:
            total = total * u + coefficient
            result.append(total)
        return result


def power_series(function: Callable[[Decimal], Decimal], inputs: Sequence[int], tolerance: float) -> PowerSeries:
    """The interpolation of lowest degree, at nearly Chebyshev's places, that is exact enough at all inputs.

    Of the two arguments it takes the one whose sums stay smaller on their way: in the direction in which the function
    grows, the terms have one sign.

    Parameters
    ----------
    function
        What to interpolate; smooth.
    inputs
        Where it is needed, whole numbers 0..255.
    tolerance
        Relative error that is allowed; an error below the resolution of 32 bits is allowed in any case.

    Raises
    ------
    NoPolynomialError
        If no reasonable degree suffices.
    """
    with localcontext(EXACT):
        values = {Decimal(x): function(Decimal(x)) for x in sorted(set(inputs))}
        floor = _RESOLUTION * max(map(abs, values.values()))
        allowed = {x: max(floor, Decimal(tolerance) * abs(v)) for x, v in values.items()}
        for degree in range(_MOST_DEGREE + 1):
            found = _interpolation(function, min(values), max(values), degree, reflected=False)
            if all(abs(found.sums(x)[-1] - values[x]) <= allowed[x] for x in values):
                other = _interpolation(function, min(values), max(values), degree, reflected=True)
                return min(found, other, key=lambda series: largest_sum(series, inputs))
    raise NoPolynomialError(
        f"no polynomial of degree {_MOST_DEGREE} or less follows a schedule over |PWM| {min(inputs)}..{max(inputs)}"
    )


def largest_sum(series: PowerSeries, inputs: Sequence[int]) -> Decimal:
    """The largest magnitude that Horner's rule meets at any of the inputs."""
    with localcontext(EXACT):
        return max(abs(total) for x in set(inputs) for total in series.sums(Decimal(x)))


def _interpolation(
    function: Callable[[Decimal], Decimal], low: Decimal, high: Decimal, degree: int, *, reflected: bool
) -> PowerSeries:
    half = float(max(high - low, Decimal(1))) / 2
    middle = float(low + high) / 2
    places = [
        Decimal(round(_PLACES * (middle + half * cos(pi * (k + 0.5) / (degree + 1))))) / _PLACES
        for k in range(degree + 1)
    ]
    nodes = [PowerSeries(reflected, ()).argument(p) for p in places]
    # Newton's divided differences, then his form multiplied out from the inside.
    differences = [function(p) for p in places]
    for order in range(1, degree + 1):
        for k in range(degree, order - 1, -1):
            differences[k] = (differences[k] - differences[k - 1]) / (nodes[k] - nodes[k - order])
    result = [differences[degree]]
    for k in range(degree - 1, -1, -1):
        result = [
            left - nodes[k] * right for left, right in zip([*result, Decimal(0)], [Decimal(0), *result], strict=True)
        ]
        result[-1] += differences[k]
    return PowerSeries(reflected, tuple(result))
