"""Thousandths of a degree Celsius as a word of a state: one product of a signed with an unsigned 32-bit number."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, log2

from gen.lowering.kinds import Integers


@dataclass(frozen=True)
class DegreeScale:
    """``word = (thousandths * factor + half) >> shift``.

    Attributes
    ----------
    factor
        Below 2^32.
    shift
        Bits of the factor after its binary point.
    """

    factor: int
    shift: int

    @property
    def half(self) -> int:
        """What rounds to nearest."""
        return 1 << (self.shift - 1)


def scale_of(fraction_bits: int) -> DegreeScale:
    """The scale of words of 2^-fraction_bits degC."""
    shift = 31 - floor(log2(2.0**fraction_bits / 1000.0))
    return DegreeScale(round(2.0 ** (fraction_bits + shift) / 1000.0), shift)


def degrees(thousandths: Integers, scale: DegreeScale) -> Integers:
    """Words of temperatures in thousandths of a degree Celsius, any shape."""
    result: Integers = thousandths * scale.factor + scale.half >> scale.shift
    return result
