"""The words of the fast fixed-point form and what each of its operations can lose.

A state word has 40 bits, ``hi * 2^8 + lo``: ``hi`` is what gets multiplied, ``lo`` carries the residue of every
addition on to the next sample.  One unit of x1's ``hi`` is ``unit_mK`` thousandths of a kelvin, m/2^e with m = 4..7,
so that the range of the temperature fills the word and the conversion to thousandths stays a small product.  One
unit of x[i+1]'s ``hi`` is 2^-gap[i] of one of x[i]'s; with the gap taken from the nested rate R[i] its integer fills
32 bits and the product needs no shift but by whole bytes.

x1 - S is formed with 24 bits where that is precise enough.  For a component of order 2 and more R0 then has 24 bits
too (:func:`narrow_product`); every other product is 32 x 32 bits (:func:`fast_product`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from gen.lowering.program import Integers, Proof

Word = TypeVar("Word", int, NDArray[np.int64])

RESIDUE_BITS = 8
#: Samples that one product of a first-order component spans; slots in which such components take turns.
BLOCK = 4
#: x[i+1] is shifted right by its gap as a whole byte and a rest.
SMALLEST_GAP, LARGEST_GAP = 8, 15
#: Words that rounding may add to a range before it overflows.
MARGIN = 64.0


@dataclass(frozen=True)
class FastLayout:
    """Formats of one component of order n.

    Attributes
    ----------
    scale
        (m, e): one unit of x1's high word is m/2^e thousandths of a kelvin.
    gaps
        Length n - 1, see the module's docstring.
    narrow
        Whether S and R0 have 24 bits (order 1: S only), else 32.
    increment_shift
        By how many bits q is shifted left before it is added to the word x[n] (0 unless R[n-1] is above 2^-8).
    """

    scale: tuple[int, int]
    gaps: tuple[int, ...]
    narrow: bool = True
    increment_shift: int = 0

    @property
    def order(self) -> int:
        """The component's order n."""
        return len(self.gaps) + 1

    @property
    def unit_K(self) -> float:
        """Weight of the lowest bit of x1's high word."""
        return self.scale[0] * 2.0 ** -self.scale[1] / 1000.0

    @property
    def high_lsb(self) -> tuple[float, ...]:
        """Weight of the lowest bit of each high word, in K."""
        return tuple(float(v) for v in self.unit_K * 2.0 ** -np.cumsum((0, *self.gaps)))

    @property
    def word_lsb(self) -> tuple[float, ...]:
        """Weight of the lowest bit of each whole word, in K."""
        return tuple(lsb / 2.0**RESIDUE_BITS for lsb in self.high_lsb)

    @property
    def steady_lsb(self) -> float:
        """Weight of the lowest bit of S, and of x1 - S, in K."""
        return self.unit_K * (256.0 if self.narrow else 1.0)

    @property
    def rate_bits(self) -> tuple[int, ...]:
        """Bits after the binary point of the rates."""
        last = 32 + RESIDUE_BITS - self.increment_shift
        if self.order == 1:
            return (last,)
        return ((24 if self.narrow else 32) + self.gaps[0], *(32 + gap for gap in self.gaps[1:]), last)


@dataclass(frozen=True)
class FastComponent:
    """One component in the fast fixed-point form.

    Attributes
    ----------
    name, order
        From the coefficient file.
    layout
        The formats.
    rates
        Integers R[i] * 2^rate_bits[i] for each row of the domain, shape (rows, n); of a first-order component the rate
        of a whole block of samples.
    steady
        Integers, S in ``layout.steady_lsb`` with what the arithmetic loses on average taken off, shape (rows,).
    slot
        First order: the component's turn, 0..BLOCK - 1.
    start_range_mK
        Lowest and highest rise to start from, in thousandths of a kelvin; others are limited and flagged.
    proof
        Always there: a component without one is refused.
    """

    name: str
    order: int
    layout: FastLayout
    rates: Integers
    steady: Integers
    slot: int
    start_range_mK: tuple[int, int]
    proof: Proof

    saturates = False
    substeps = 1

    def describe(self) -> dict[str, Any]:
        """Formats and proof for the manifest."""
        return {
            "name": self.name,
            "order": self.order,
            "unit_mK": f"{self.layout.scale[0]}/2^{self.layout.scale[1]}",
            "gaps": list(self.layout.gaps),
            "rate_fraction_bits": list(self.layout.rate_bits),
            "block": BLOCK if self.order == 1 else 1,
            "start_range_mK": list(self.start_range_mK),
            "proof": self.proof.describe(),
        }


def choose_scale(largest_K: float) -> tuple[int, int]:
    """(m, e), m = 4..7, with the finest unit m/2^e mK of which 2^31 hold a range."""
    e = 60
    while True:
        for m in (4, 5, 6, 7):
            if m * 2.0 ** (31 - e) > largest_K * 1000.0 + 4.0 * MARGIN * m * 2.0**-e * 256.0:
                return m, e
        e -= 1


def fast_product(difference: Word, rate: Word) -> Word:
    """``difference * rate / 2^32`` from ten byte products: 0..:func:`fast_loss` below the true value.

    Byte products of weight 2^32 and more count in full, those of weight 2^24 by their high bytes, others not at all.

    Parameters
    ----------
    difference, rate
        Signed and unsigned, 32 bits.
    """
    left_out = _byte(difference, 0) * _byte(rate, 0)
    for i, j in ((0, 1), (1, 0), (0, 2), (1, 1), (2, 0)):
        left_out = left_out + ((_byte(difference, i) * _byte(rate, j)) << (8 * (i + j)))
    for i in range(4):
        left_out = left_out + (((_byte(difference, i) * _byte(rate, 3 - i)) & 0xFF) << 24)
    return (difference * rate - left_out) >> 32


def rounded_product(difference: Word, rate: Word) -> Word:
    """``difference * rate / 2^32`` to nearest, for what is computed at a change of PWM only."""
    return (difference * rate + (1 << 31)) >> 32


def fast_loss(*, narrow: bool = False) -> float:
    """Upper bound of what :func:`fast_product` loses, in units of its result; ``narrow`` if d's lowest byte is 0."""
    first = 1 if narrow else 0
    low = sum(255.0**2 * 256.0 ** (i + j) for i in range(first, 3) for j in range(3 - i))
    return (low + (4 - first) * 255.0 * 256.0**3) / 2.0**32


def narrow_product(difference: Word, rate: Word) -> Word:
    """``difference * rate / 2^16`` of 24-bit numbers, from eight byte products.

    Without the lowest; those of weight 2^8 count by their high bytes.  0..:data:`NARROW_LOSS` below the true value.
    """
    left_out = _byte(difference, 0) * _byte(rate, 0)
    for i in range(2):
        left_out = left_out + (((_byte(difference, i) * _byte(rate, 1 - i)) & 0xFF) << 8)
    return (difference * rate - left_out) >> 16


#: What :func:`narrow_product` loses at most, in units of its result.
NARROW_LOSS = (255.0**2 + 2.0 * 255.0 * 256.0) / 2.0**16


def _byte(value: Word, number: int) -> Word:
    return (value >> (8 * number)) & 0xFF
