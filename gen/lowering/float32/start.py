"""The start value in float32: thousandths of a kelvin to an accumulator."""

from __future__ import annotations

from functools import cache

import numpy as np

from gen.arrays import IntArray
from gen.lowering.float32.component import LOW_BITS
from gen.lowering.start import worst_start


def start_factor(bits: int) -> np.float32:
    """Words of 2^-``bits`` K in a thousandth of a kelvin."""
    return np.float32(2.0**bits / 1000.0)


def start_accumulator(bits: int, rise_mK: IntArray) -> IntArray:
    """The accumulators for rises: one product of float32, rounded towards zero.

    Parameters
    ----------
    bits
        Of a word after the binary point.
    rise_mK
        In thousandths of a kelvin, at most :data:`gen.lowering.start.LARGEST_MK` in magnitude: exact in float32.
    """
    return _truncated(bits, rise_mK, LOW_BITS)


def ambient_word(bits: int, over_mK: IntArray) -> IntArray:
    """What is added to steady rises for an ambient over the reference: one product of float32, rounded towards zero.

    Parameters
    ----------
    bits
        Of a word after the binary point.
    over_mK
        In thousandths of a kelvin, at most :data:`gen.lowering.start.LARGEST_MK` in magnitude: exact in float32.
    """
    return _truncated(bits, over_mK, 0)


def _truncated(bits: int, value_mK: IntArray, more: int) -> IntArray:
    """Words of so many bits after the binary point, from one product of float32, and `more` bits behind them."""
    words = start_factor(bits) * value_mK.astype(np.float32)
    return np.asarray(np.trunc(words.astype(np.float64) * (1 << more)).astype(np.int64))


@cache
def ambient_error(bits: int, range_mK: tuple[int, int]) -> float:
    """The most that this can be off, in K.

    Parameters
    ----------
    bits
        Of a word after the binary point.
    range_mK
        Lowest and highest ambient over the reference, in thousandths of a kelvin.
    """
    return worst_start(lambda over: ambient_word(bits, over), bits, range_mK)


@cache
def start_error(bits: int, range_mK: tuple[int, int]) -> float:
    """The most that a start can be off, in K.

    Parameters
    ----------
    bits
        Of a word after the binary point.
    range_mK
        Lowest and highest rise to start from, in thousandths of a kelvin.
    """
    return worst_start(lambda rises: start_accumulator(bits, rises), bits + LOW_BITS, range_mK)
