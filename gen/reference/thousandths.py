"""Words as thousandths of a kelvin, as the board gives them out."""

from __future__ import annotations

from gen.arrays import IntArray
from gen.lowering.kinds import OUTPUT_BITS


def thousandths(word: IntArray, bits: int) -> IntArray:
    """A word of 2^-bits K in thousandths of a kelvin, to nearest, halves upwards.

    The board multiplies in 32 bits, so that no more than 25 bits after the binary point take part.
    """
    kept = min(bits, OUTPUT_BITS)
    fraction = (word & ((1 << bits) - 1)) >> (bits - kept)
    result: IntArray = (word >> bits) * 1000 + (fraction * 125 + (1 << (kept - 4)) >> (kept - 3))
    return result
