"""Numbers of the board as affine functions of its state: exact coefficients, and for every rounding a symbol.

A number is linear . symbols + constant + sum of noise, at every |PWM| of the domain side by side (P of them). The
symbols are what the state is made of; a noise symbol has a range and stands for one rounding, wherever it goes on to.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import ceil, frexp, isfinite
from typing import Protocol

import numpy as np

from gen.arrays import FloatArray
from gen.certificate.exact import ROUGHLY, Ratio, Ratios, floats, zeros
from gen.certificate.refuted import Refuted

#: Least positive float32.
_TINY = Ratio(1, 1 << 149)
#: Ends of the whole numbers that the C++ computes with.
_ENDS = {"int32_t": 1 << 31, "int64_t": 1 << 63}
#: Grid on which ranges of roundings are rounded up, so that their ratios stay short.
_GRID = 1 << 200


@dataclass(frozen=True)
class Affine:
    """One number.

    Attributes
    ----------
    kind
        Its C++ type: "int32_t", "int64_t", "uint32_t", "float", or "word" for a whole state word.
    linear
        Shape (symbols, P).
    constant
        Shape (P,).
    noise
        By symbol, shape (P,).
    """

    kind: str
    linear: Ratios
    constant: Ratios
    noise: dict[int, Ratios] = field(default_factory=dict)

    @property
    def known(self) -> bool:
        """Whether it is the same whatever the state."""
        return not self.noise and not self.linear.any()

    def __add__(self, other: Affine) -> Affine:
        noise = dict(self.noise)
        for symbol, factor in other.noise.items():
            noise[symbol] = noise[symbol] + factor if symbol in noise else factor
        return replace(self, linear=self.linear + other.linear, constant=self.constant + other.constant, noise=noise)

    def __sub__(self, other: Affine) -> Affine:
        return self + other.times(Ratio(-1))

    def times(self, factor: Ratio | Ratios) -> Affine:
        """The product with a known number, the same or one for each |PWM|."""
        noise = {symbol: value * factor for symbol, value in self.noise.items()}
        return replace(self, linear=self.linear * factor, constant=self.constant * factor, noise=noise)

    def as_kind(self, kind: str) -> Affine:
        """The same number as another type."""
        return replace(self, kind=kind)


class Reach(Protocol):
    """What the state's symbols range over."""

    def enclose(self, linear: Ratios) -> tuple[Ratios, Ratios]:
        """Enclose linear . symbols, shape (symbols, P): middle and half width, shape (P,) each."""
        ...

    def roughly(self, linear: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The same in float64, where the half width covers what that rounds."""
        ...


class Space:
    """The symbols of one calculation, and what they range over.

    Parameters
    ----------
    symbols, rows
        How many symbols and |PWM| there are.
    reach
        What the state's symbols range over; None to calculate as if nothing were ever rounded or overflowed.
    """

    def __init__(self, symbols: int, rows: int, reach: Reach | None = None) -> None:
        self.symbols, self.rows = symbols, rows
        self._reach = reach
        self.ranges: list[tuple[Ratios, Ratios]] = []

    def number(self, value: Ratio | int | Ratios, kind: str) -> Affine:
        """A known number."""
        constant = zeros(self.rows) + value
        return Affine(kind, zeros(self.symbols, self.rows), constant)

    def symbol(self, place: int, kind: str) -> Affine:
        """One of the state's symbols."""
        linear = zeros(self.symbols, self.rows)
        linear[place] = Ratio(1)
        return Affine(kind, linear, zeros(self.rows))

    def uncertain(self, value: Affine, low: Ratio | Ratios, high: Ratio | Ratios) -> Affine:
        """The number plus a rounding between ``low`` and ``high``."""
        if self._reach is None:
            return value
        self.ranges.append((zeros(self.rows) + low, zeros(self.rows) + high))
        noise = {**value.noise, len(self.ranges) - 1: zeros(self.rows) + 1}
        return replace(value, noise=noise)

    def ends(self, value: Affine) -> tuple[Ratios, Ratios]:
        """The least and the largest that a number can be, shape (P,) each."""
        if self._reach is None:
            raise ValueError("a calculation without ranges")
        middle, half = self._reach.enclose(value.linear)
        low, high = value.constant + middle - half, value.constant + middle + half
        for symbol, factor in value.noise.items():
            at_low, at_high = factor * self.ranges[symbol][0], factor * self.ranges[symbol][1]
            low, high = low + np.minimum(at_low, at_high), high + np.maximum(at_low, at_high)
        return low, high

    def largest(self, value: Affine) -> FloatArray:
        """A bound of a number's magnitude, shape (P,), in float64 and rounded up by far more than its own errors."""
        constant = floats(value.constant)
        if value.known:
            return np.abs(constant) * (1.0 + ROUGHLY)
        if self._reach is None:
            raise ValueError("a calculation without ranges")
        middle, half = self._reach.roughly(floats(value.linear))
        around = np.zeros(self.rows)
        for symbol, factor in value.noise.items():
            ends = self.ranges[symbol]
            around += np.abs(floats(factor)) * np.maximum(np.abs(floats(ends[0])), np.abs(floats(ends[1])))
        found: FloatArray = np.abs(constant + middle) + half + around
        return found + ROUGHLY * (np.abs(constant) + np.abs(middle) + half + around)

    def fits(self, value: Affine, end: int | None = None, what: str = "") -> Affine:
        """The number itself, within its type or within +-``end``.

        Raises
        ------
        Refuted
            If it can leave its type.
        """
        end = end or _ENDS.get(value.kind)
        if self._reach is not None and end is not None:
            largest = self.largest(value).max()
            if not largest < end - 1:
                raise Refuted(f"{what or 'a ' + value.kind} can reach {largest:.6g}, beyond +-{end}")
        return value

    def shifted(self, value: Affine, bits: int) -> Affine:
        """A whole number shifted right, which rounds down."""
        unit = Ratio(1, 1 << bits)
        if value.known:
            floor = np.frompyfunc(lambda number: Ratio(number // (1 << bits)), 1, 1)
            return replace(value, constant=floor(value.constant))
        return self.uncertain(value.times(unit), unit - 1, Ratio(0))

    def as_float(self, value: Affine) -> Affine:
        """The number rounded to nearest float32."""
        value = value.as_kind("float")
        if self._reach is None:
            return value
        half = np.frompyfunc(_half_ulp, 1, 1)(self.largest(value))
        return self.uncertain(value, -half, half)


def _half_ulp(largest: float) -> Ratio:
    """Half the distance of float32 numbers of at most this magnitude."""
    if not isfinite(largest):
        raise Refuted("a number of the board has no bound")
    if largest == 0.0:
        return Ratio(0)
    return max(Ratio(2) ** (frexp(largest)[1] - 25), _TINY / 2)


def outward(value: Ratio) -> Ratio:
    """A short ratio, not below the given one."""
    return Ratio(ceil(value * _GRID), _GRID)
