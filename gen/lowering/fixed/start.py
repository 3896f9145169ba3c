"""The start value in fixed point: thousandths of a kelvin to a high word of x1."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TypeVar

from gen.arrays import IntArray
from gen.lowering.start import worst_start

Rise = TypeVar("Rise", int, IntArray)


@dataclass(frozen=True)
class StartScale:
    """2^b / 1000 for the b bits after the binary point of x1's high word.

    Attributes
    ----------
    whole
        The whole part.
    upper, lower
        The 32 bits after the binary point, to nearest, in two halves.
    """

    whole: int
    upper: int
    lower: int

    def word(self, rise_mK: Rise) -> Rise:
        """The word for a rise, to nearest; a rise that is a whole number of units is met exactly.

        Parameters
        ----------
        rise_mK
            In thousandths of a kelvin, at most :data:`gen.lowering.start.LARGEST_MK` in magnitude.
        """
        over = rise_mK >> 8
        part = over * self.upper + ((rise_mK & 255) * self.upper >> 8) + (over * self.lower >> 16)  # in 2^-8
        word: Rise = rise_mK * self.whole + (part + 128 >> 8)
        return word


def start_scale(bits: int) -> StartScale:
    """The factors for words of 2^-``bits`` K."""
    whole, rest = divmod(1 << bits, 1000)
    upper, lower = divmod(((rest << 32) + 500) // 1000, 1 << 16)
    return StartScale(whole, upper, lower)


@cache
def start_error(bits: int, range_mK: tuple[int, int]) -> float:
    """The most that a start can be off, in K.

    Parameters
    ----------
    bits
        Of a high word after the binary point.
    range_mK
        Lowest and highest rise to start from, in thousandths of a kelvin.
    """
    return worst_start(start_scale(bits).word, bits, range_mK)
