"""Three bytes a word: how a table of coefficients lies in flash.

A float32's bits, read as a whole number, grow with its value, and a rate varies by a factor of a few over the domain.
So its bits are a base plus a 24-bit number, which loses nothing up to a factor of 4 and one bit up to a factor of 16.
A steady rise is a signed 24-bit number of 256 units.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray, SingleArray
from gen.lowering.float32.component import FloatComponent

#: Bits of what the table stores.
STORED_BITS = 24
#: A steady rise is a multiple of this power of two of its unit.
STEADY_SHIFT = 32 - STORED_BITS


@dataclass(frozen=True)
class Column:
    """One column of the table: word = base + (stored << shift), modulo 2^32."""

    name: str
    base: int
    shift: int
    stored: tuple[int, ...]


def packed(words: SingleArray) -> SingleArray:
    """Float32 words (positive, shape (rows,)) rounded to what a column can hold."""
    bits = words.view(np.uint32).astype(np.int64)
    base, shift = _frame(bits)
    rounded = base + (((bits - base) + ((1 << shift) >> 1)) >> shift << shift)
    highest = base + (((1 << STORED_BITS) - 1) << shift)
    result: SingleArray = np.minimum(rounded, highest).astype(np.uint32).view(np.float32)
    return result


def packed_steady(kelvins: FloatArray, fraction_bits: int) -> IntArray:
    """Steady rises in K as words that a column can hold, shape (rows,)."""
    return np.rint(kelvins * 2.0 ** (fraction_bits - STEADY_SHIFT)).astype(np.int64) << STEADY_SHIFT


def column_words(component: FloatComponent) -> list[Column]:
    """The columns of one component: its rate words, then S.

    Raises
    ------
    ValueError
        If a word is not one that a column can hold.
    """
    columns = []
    for i, words in enumerate(component.rate_words.T):
        bits = np.ascontiguousarray(words).view(np.uint32).astype(np.int64)
        columns.append(_column(f"{component.name}.R{i}", bits, *_frame(bits)))
    return [*columns, _column(f"{component.name}.S", component.steady, 0, STEADY_SHIFT, signed=True)]


def _frame(bits: IntArray) -> tuple[int, int]:
    base = int(bits.min())
    return base, max(0, int(bits.max() - base).bit_length() - STORED_BITS)


def _column(name: str, words: IntArray, base: int, shift: int, *, signed: bool = False) -> Column:
    stored = (words - base) >> shift
    lowest = -(1 << (STORED_BITS - 1)) if signed else 0
    if np.any((stored << shift) + base != words) or stored.min() < lowest or stored.max() - lowest >= 1 << STORED_BITS:
        raise ValueError(f"{name} does not fit {STORED_BITS} bits")
    return Column(name, base, shift, tuple(int(v) & ((1 << STORED_BITS) - 1) for v in stored))
