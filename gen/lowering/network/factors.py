"""Factors as the board evaluates them: a channel's value in thousandths to a whole number of 2^-bits.

A table is a chain of straight pieces, a polynomial is Horner's scheme in t = (value - low) / (high - low). Both are
integer arithmetic, so that float32 builds share them.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import ceil, comb, log2

import numpy as np

from gen.arrays import IntArray
from gen.errors import CheckFailed
from gen.lowering.network.series import WHOLE
from gen.model.network_parts import Channel, Factor

#: No factor's word reaches this many bits: its products are of a signed with an unsigned 32-bit number.
WORD_BITS = 30
SHARE_BITS = 30
"""Fraction bits of t."""
_WHOLE_SHIFT = 32 - 8 * WHOLE.least
CUT = 1.0 + WHOLE.dropped * 2.0**-_WHOLE_SHIFT
"""Largest error of a product's upper word, in its units: what is cut and what the product leaves out."""


def scaled(word: IntArray, factor: IntArray) -> IntArray:
    """A non-negative 32-bit word times a factor of 2^-30, by the board's product."""
    return WHOLE.of(factor, word) >> WORD_BITS - 8 * WHOLE.least


def high(difference: IntArray, constant: int) -> IntArray:
    """2^-32 of a product of a signed with an unsigned 32-bit number."""
    return WHOLE.of(difference, np.full(difference.shape, constant, dtype=np.int64)) >> _WHOLE_SHIFT


def filling(width: int) -> int:
    """By how many bits a width can be shifted to stay below 2^31."""
    return 31 - width.bit_length()


@dataclass(frozen=True)
class Piece:
    """Up to a channel's value: ``value + sign * ((told - at) * 2^left x slope >> 16)``, x as the whole product.

    Attributes
    ----------
    end
        The first told value that it is not for, in thousandths.
    at, value
        Its beginning, in thousandths, and the factor's word there.
    left, slope
        What fills 31 bits with the piece's width; words per that many thousandths in 2^-32, a magnitude.
    falling
        Whether it is taken off.
    """

    end: int
    at: int
    value: int
    left: int
    slope: int
    falling: bool


@dataclass(frozen=True)
class FactorProgram:
    """One factor.

    Attributes
    ----------
    channel
        Index of its channel; the ambient is 0.
    bits
        Fraction bits of its word.
    pieces, last
        A table's pieces, and its word from the last one's end on; no pieces for a polynomial.
    coefficients
        A polynomial's in t, as words, highest power first; empty for a table.
    low, left, scale
        ``t = (told - low) * 2^left x scale >> 16`` in 2^-30.
    error
        Largest difference from the factor itself, anywhere in the channel's range.
    label
        What it is, for people.
    """

    channel: int
    bits: int
    pieces: tuple[Piece, ...]
    last: int
    coefficients: tuple[int, ...]
    low: int
    left: int
    scale: int
    error: float
    label: str

    def word(self, told: IntArray) -> IntArray:
        """The factor's word for told values in thousandths, any shape."""
        if self.coefficients:
            return self._horner(told)
        made = np.full(told.shape, self.last, dtype=np.int64)
        for piece in reversed(self.pieces):
            change = high((told - piece.at) << piece.left, piece.slope)
            value = piece.value - change if piece.falling else piece.value + change
            made = np.where(told < piece.end, value, made)  # elsewhere the change means nothing
        return made

    def _horner(self, told: IntArray) -> IntArray:
        share = high((told - self.low) << self.left, self.scale)
        value: IntArray = np.full(told.shape, self.coefficients[0], dtype=np.int64)
        for coefficient in self.coefficients[1:]:
            value = coefficient + scaled(share, value)
        return np.maximum(value, 0)


def lower_factor(factor: Factor, channels: tuple[Channel, ...], largest: float, index: int) -> FactorProgram:
    """Choose a factor's words.

    Parameters
    ----------
    factor
        What to evaluate.
    channels
        The network's.
    largest
        Its largest value.
    index
        Of the factor, for its label.
    """
    number = next(k for k, channel in enumerate(channels) if channel.column == factor.channel)
    channel = channels[number]
    label = f"factor {index}: of {factor.channel}"
    low, high = round(channel.low * 1000.0), round(channel.high * 1000.0)
    if high - low >= 1 << 31:
        raise CheckFailed(
            f"$.network.channels[{number}].range: {high - low} thousandths are more than a board counts: write "
            f"{channel.column} in a larger unit"
        )
    if factor.polynomial:
        return _polynomial(factor, number + 1, low, high, label)
    bits = WORD_BITS - ceil(log2(max(largest, 1e-4)) + 1e-9)
    at, values = _within(factor, low, high)
    words = [round(value * 2**bits) for value in values]
    pieces = [Piece(at[0], at[0], words[0], 0, 0, False)]
    for k in range(len(at) - 1):
        change, width = abs(words[k + 1] - words[k]), at[k + 1] - at[k]
        left = filling(width)
        slope = min(round(Fraction(change << 32, width << left)), (1 << 32) - 1)
        pieces.append(Piece(at[k + 1], at[k], words[k], left, slope, words[k + 1] < words[k]))
    # A slope is off by half a unit, or by one, over 2^31 of 2^-32; its product is cut; both ends are rounded.
    off = 0.5 + CUT + 1.0
    return FactorProgram(number + 1, bits, tuple(pieces), words[-1], (), 0, 0, 0, off * 2.0**-bits, label)


def _within(factor: Factor, low: int, high: int) -> tuple[list[int], list[Fraction]]:
    """A table's points within the channel's range, to which the board holds it, and its ends; in thousandths, exact."""
    at = [round(value * 1000.0) for value in factor.at]
    given = list(map(Fraction, factor.value))

    def value(told: int) -> Fraction:
        if told <= at[0]:
            return given[0]
        for (a, y), (b, z) in pairwise(zip(at, given, strict=True)):
            if told <= b:
                return y + (z - y) * Fraction(told - a, b - a)
        return given[-1]

    points = [low, *(point for point in at if low < point < high), high]
    return points, [value(point) for point in points]


def _polynomial(factor: Factor, channel: int, low: int, high: int, label: str) -> FactorProgram:
    """Expand about the range's lower end, in exact arithmetic, and round once."""
    given = [Fraction(c) for c in reversed(factor.polynomial)]
    start, width = Fraction(low, 1000), Fraction(high - low, 1000)
    expanded = [
        sum((given[n] * comb(n, k) * start ** (n - k) for n in range(k, len(given))), Fraction(0)) * width**k
        for k in range(len(given))
    ]
    total = float(sum(abs(c) for c in expanded))
    bits = WORD_BITS - ceil(log2(max(total, 1e-4)) + 1e-9)
    words = tuple(round(c * 2**bits) for c in reversed(expanded))
    left = filling(high - low)
    scale = min((1 << (SHARE_BITS + 32)) // ((high - low) << left), (1 << 32) - 1)  # down, so that t never passes 1
    share = (0.5 + CUT) * 2.0**-SHARE_BITS
    slope = float(sum(k * abs(c) for k, c in enumerate(expanded)))
    error = slope * share + ((0.5 + CUT) * len(words)) * 2.0**-bits
    return FactorProgram(channel, bits, (), 0, words, low, left, scale, error, label)
