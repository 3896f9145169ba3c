"""Ranges instead of numbers: what an effect's equation can come to, and how steeply it answers to each part's rise.

Given a :class:`Span` for what it reads, an effect's own formula gives the range of its value at every |PWM|, and the
range of its derivative with respect to every rise (forward differentiation in interval arithmetic). The ends are
float64 rounded to nearest: who compares them leaves a margin far above 1e-12.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gen.arrays import FloatArray

Ends = tuple[Any, Any]
"""Lowest and highest value: numbers, or arrays with an entry for each |PWM|."""


class Span:
    """A range of values at every |PWM|, and the range of its slope over each rise, with Python's operators.

    Parameters
    ----------
    low, high
        Numbers, or arrays with an entry for each |PWM|.
    slopes
        By name of the component whose rise is meant: lowest and highest derivative. One that is missing is 0.
    """

    __slots__ = ("high", "low", "slopes")
    __array_ufunc__ = None  # array * span asks the span, instead of making an array of spans

    def __init__(self, low: Any, high: Any, slopes: Mapping[str, Ends] | None = None) -> None:  # noqa: ANN401
        self.low, self.high, self.slopes = low, high, dict(slopes or {})

    @classmethod
    def of(cls, value: object) -> Span:
        """A number or an array over |PWM| as a span, and a span itself."""
        if isinstance(value, Span):
            return value
        array = np.asarray(value, dtype=np.float64)
        return cls(array, array)

    def slope(self, name: str) -> Ends:
        """Lowest and highest derivative with respect to a component's rise."""
        return self.slopes.get(name, (0.0, 0.0))

    def __add__(self, other: object) -> Span:
        b = Span.of(other)
        return Span(self.low + b.low, self.high + b.high, self._each(b, lambda x, y: (x[0] + y[0], x[1] + y[1])))

    def __neg__(self) -> Span:
        return Span(-self.high, -self.low, {name: (-high, -low) for name, (low, high) in self.slopes.items()})

    def __sub__(self, other: object) -> Span:
        return self + -Span.of(other)

    def __mul__(self, other: object) -> Span:
        b = Span.of(other)
        if self is b:
            return self**2
        ends = self.low, self.high
        others = b.low, b.high

        def product(x: Ends, y: Ends) -> Ends:
            left, right = _times(x, others), _times(ends, y)
            return left[0] + right[0], left[1] + right[1]

        return Span(*_times(ends, others), self._each(b, product))

    def __truediv__(self, other: object) -> Span:
        if isinstance(other, Span):
            raise TypeError("an effect's equation does not divide by what is learnt at a sample")
        return self * (1.0 / np.asarray(other, dtype=np.float64))

    def __pow__(self, exponent: int) -> Span:
        if exponent == 1:
            return self
        outer = _times((float(exponent), float(exponent)), _power((self.low, self.high), exponent - 1))
        slopes = {name: _times(outer, inner) for name, inner in self.slopes.items()}
        return Span(*_power((self.low, self.high), exponent), slopes)

    def __radd__(self, other: object) -> Span:
        return self + other

    def __rsub__(self, other: object) -> Span:
        return -self + other

    def __rmul__(self, other: object) -> Span:
        return self * other

    def _each(self, other: Span, rule: Callable[[Ends, Ends], Ends]) -> dict[str, Ends]:
        names = dict.fromkeys([*self.slopes, *other.slopes])
        return {name: rule(self.slope(name), other.slope(name)) for name in names}


def _times(a: Ends, b: Ends) -> Ends:
    products = [x * y for x in a for y in b]
    low: FloatArray = products[0]
    high: FloatArray = products[0]
    for product in products[1:]:
        low, high = np.minimum(low, product), np.maximum(high, product)
    return low, high


def _power(a: Ends, exponent: int) -> Ends:
    if exponent == 0:
        return 1.0, 1.0
    low, high = a[0] ** exponent, a[1] ** exponent
    if exponent % 2:
        return low, high
    through_zero = (np.asarray(a[0]) <= 0.0) & (np.asarray(a[1]) >= 0.0)
    return np.where(through_zero, 0.0, np.minimum(low, high)), np.maximum(low, high)
