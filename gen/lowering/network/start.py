"""Thousandths of a degree Celsius as a word of a state: one product of a signed with an unsigned 32-bit number."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor

from gen.arrays import IntArray
from gen.errors import CheckFailed
from gen.lowering.network.series import WHOLE
from gen.model import ThermalModel


@dataclass(frozen=True)
class DegreeScale:
    """``word = (thousandths * 2^left x factor + half) >> shift``, x as :data:`~gen.lowering.network.series.WHOLE`.

    Attributes
    ----------
    left
        Bits by which thousandths are shifted up: they fill a word as what they come out as does.
    factor
        Below 2^32.
    shift
        Bits of the factor after its binary point, less those that the product leaves out.
    """

    left: int
    factor: int
    shift: int

    @property
    def half(self) -> int:
        """What rounds to nearest."""
        return 1 << (self.shift - 1)


def scale_of(fraction_bits: int) -> DegreeScale:
    """The scale of words of 2^-fraction_bits degC, of which a temperature fits 32."""
    left = max(0, fraction_bits - 10)
    whole = 31 + 10 - (fraction_bits - left)
    return DegreeScale(left, round(2.0 ** (fraction_bits - left + whole) / 1000.0), whole - 8 * WHOLE.least)


def start_range_mC(model: ThermalModel) -> tuple[int, int]:
    """The readings that a start takes, thousandths of a degree Celsius: those within the declared temperatures.

    Raises
    ------
    CheckFailed
        If there is none.
    """
    low, high = ceil(model.domain_temperature[0] * 1000.0), floor(model.domain_temperature[1] * 1000.0)
    if low > high:
        raise CheckFailed("$.domain.temperature_degC: holds no whole thousandth of a degree to start from")
    return low, high


def degrees(thousandths: IntArray, scale: DegreeScale) -> IntArray:
    """Words of temperatures in thousandths of a degree Celsius, any shape."""
    result: IntArray = (WHOLE.of(thousandths << scale.left, 0 * thousandths + scale.factor) + scale.half) >> scale.shift
    return result
