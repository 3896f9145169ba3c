"""The fixed-point recursion, word for word as the board computes it.

Words are whole numbers: Python integers for one run, or int64 arrays for many runs at once (every operation
below works on both).  A state word has 48 bits; its high word is ``word >> 16``.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from gen.arrays import IntArray
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.corrected_format import FIRST_DROPPED
from gen.lowering.fixed.formats import CARRY_FACTOR, GAIN_FACTOR, RESIDUE_BITS, WORD_BITS, dropped_bytes
from gen.lowering.fixed.start import start_scale

Word = TypeVar("Word", int, IntArray)


def product(difference: Word, rate: Word, shift: int, *, wide: bool, dropped: int | None = None) -> Word:
    """``difference * rate >> shift`` without the lowest byte products, rounded down.

    Parameters
    ----------
    difference
        Signed, 32 bits.
    rate
        Unsigned, 32 bits.
    shift
        16, 24 or 32.
    wide
        Whether the result is a 48-bit word (else it is a high word, whose range is proven to be 32 bits).
    dropped
        How many columns of byte products to leave out, if not the usual number.
    """
    whole = difference * rate
    columns = dropped_bytes(shift, wide=wide) if dropped is None else dropped
    for i in range(columns):  # of byte i the products with the rate's bytes that end in a column left out
        part = ((difference >> 8 * i) & 0xFF) * (rate & ((1 << 8 * (columns - i)) - 1))
        whole = whole - (part << 8 * i)
    return whole >> shift


class FixedStep:
    """One sample of one component; counts where a word had to saturate.

    Parameters
    ----------
    component
        What to run.

    Attributes
    ----------
    saturations
        How many results were limited so far (always 0 for a component with a proof).
    """

    def __init__(self, component: FixedComponent) -> None:
        self._component = component
        self._limit_high = 1 << 31
        self._limit_word = 1 << (WORD_BITS - 1)
        self.saturations: int | IntArray = 0

    def start(self, rise_mK: int) -> list[int]:
        """State at rest at a rise in thousandths of a kelvin, limited to the declared range."""
        low, high = self._component.start_range_mK
        limited = max(low, min(high, rise_mK))
        word = start_scale(self._component.layout.output_bits).word(limited)
        return [word << RESIDUE_BITS] + [0] * (self._component.order - 1)

    def increment(self, state: list[Word], rates: list[Word], steady: Word) -> Word:
        """Give q, as a word of x[n], for a state (not changed), integer rates and integer steady rise."""
        layout = self._component.layout
        if layout.corrected:
            return self._corrected_increment(state, rates, steady)
        inner = self._high((state[0] >> RESIDUE_BITS) - steady)
        for i in range(layout.order - 1):
            inner = self._high(
                (state[i + 1] >> RESIDUE_BITS)
                + self._high(product(inner, rates[i], layout.product_shifts[i], wide=False))
                + 1
            )
        return -product(inner, rates[-1], layout.product_shifts[-1], wide=True)

    def _corrected_increment(self, state: list[Word], rates: list[Word], steady: Word) -> Word:
        first, second, last = self._component.layout.product_shifts
        inner = (state[0] >> RESIDUE_BITS) - steady
        inner = (state[1] >> RESIDUE_BITS) + product(inner, rates[0], first, wide=False, dropped=FIRST_DROPPED)
        inner = (state[2] >> RESIDUE_BITS) + product(inner, rates[1], second, wide=False)
        return -product(inner, rates[2], last, wide=True)

    def carry(self, state: list[Word], old: Word, new: Word) -> None:
        """Carry q/12 of x[n-1] over a change of PWM, given q before and after (the carried form of orders 2 to 4)."""
        layout = self._component.layout
        cut, (whole, bits) = 8 * layout.carry_byte, divmod(layout.chain_shifts[-1], 8)
        change = self._high((-old >> cut) - (-new >> cut)) >> bits
        part = ((change * CARRY_FACTOR) >> 16 << cut) >> 8 * whole
        place = self._component.order - 2
        state[place] = self._word(state[place] + part)

    def advance(self, state: list[Word], rates: list[Word], q: Word) -> None:
        """Do the additions: :mod:`gen.lowering.recursion.increments`, rates :mod:`gen.lowering.fixed.correction`."""
        if self._component.layout.corrected:
            self._advance_corrected(state, rates, q)
            return
        order = self._component.order
        shift = self._component.layout.chain_shifts
        if order == 1:
            state[0] = self._word(state[0] + q)
        elif order == 2:
            state[0] = self._word(state[0] + (state[1] >> shift[0]))
            state[0] = self._word(state[0] + (q >> (shift[0] + 1)))
            state[1] = self._word(state[1] + q)
        elif order == 3:
            state[0] = self._word(state[0] + (state[1] >> shift[0]))
            state[2] = self._word(state[2] + q)
            state[1] = self._word(state[1] + (state[2] >> shift[1]))
        else:
            state[0] = self._word(state[0] + (state[1] >> shift[0]))
            state[0] = self._word(state[0] + (state[2] >> (shift[0] + shift[1] + 1)))
            state[1] = self._word(state[1] + (state[2] >> shift[1]))
            state[3] = self._word(state[3] + q)
            state[2] = self._word(state[2] + (state[3] >> shift[2]))

    def _advance_corrected(self, state: list[Word], rates: list[Word], q: Word) -> None:
        first, second = self._component.layout.chain_shifts
        rise = state[0] + (state[1] >> first)
        last = state[2] + q
        byte = rates[0] >> 24 + self._component.layout.first_rate_cut
        short = (last >> 33) + byte * (state[1] >> 40)
        short = (short * (rates[1] >> 24) >> 8) - 2 * (-q >> 24)
        correction = short * ((rates[2] >> 24) * 2 * GAIN_FACTOR >> 8) >> 7
        state[:] = [rise, state[1] + (last >> second) + correction, last]

    def _high(self, value: Word) -> Word:
        return self._limited(value, self._limit_high) if self._component.saturates else value

    def _word(self, value: Word) -> Word:
        return self._limited(value, self._limit_word) if self._component.saturates else value

    def _limited(self, value: Word, limit: int) -> Word:
        if isinstance(value, int):
            limited = max(-limit, min(limit - 1, value))
            self.saturations += limited != value
            return limited
        clipped = np.clip(value, -limit, limit - 1)
        self.saturations = self.saturations + (clipped != value).astype(np.int64)
        return clipped
