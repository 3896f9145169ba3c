"""The float32 recursion, word for word as the board computes it.

Every float operation is one float32 operation in the board's order; accumulators are int64 here, with 40 bits of
range on the board.  Arrays have one entry per lane.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray, SingleArray
from gen.lowering.float32 import LIMIT_BITS, LOW_BITS, FloatComponent
from gen.lowering.float32.start import start_accumulator

#: x1 .. xn as accumulators.
State = list[IntArray]


def accumulated(accumulator: IntArray, value: SingleArray, shift: int) -> IntArray:
    """``accumulator`` plus ``value`` (a number of 2^-shift of its word's units), rounded towards zero."""
    scaled = value.astype(np.float64) * 2.0 ** (LOW_BITS - shift)  # exact
    result: IntArray = accumulator + np.trunc(scaled).astype(np.int64)
    return result


def word(accumulator: IntArray) -> SingleArray:
    """An accumulator's 32-bit word as float32."""
    return (accumulator >> LOW_BITS).astype(np.float32)


class FloatStep:
    """One step of one component; counts where an accumulator had to be limited.

    Parameters
    ----------
    component
        What to run.

    Attributes
    ----------
    saturations
        How many of each lane's additions were limited so far.
    """

    def __init__(self, component: FloatComponent) -> None:
        self._component = component
        self._order = component.order
        self._shifts = component.chain_shifts
        self.saturations: IntArray = np.zeros((), dtype=np.int64)

    def start(self, rise_mK: IntArray) -> State:
        """The state at rest at a rise in thousandths of a kelvin, limited to the start range."""
        low, high = self._component.start_range_mK
        first = start_accumulator(self._component.fraction_bits[0], np.clip(rise_mK, low, high))
        zero = np.zeros(len(rise_mK), dtype=np.int64)
        return [first, *(zero for _ in range(1, self._order))]

    def increment(self, state: State, rates: list[SingleArray], steady: IntArray) -> SingleArray:
        """q in the unit of xn's word, for rate words and S as they are in the board's memory."""
        q = rates[0] * (steady - (state[0] >> LOW_BITS)).astype(np.float32)
        for rate, accumulator in zip(rates[1:], state[1:], strict=True):
            q = rate * (q - word(accumulator))
        return q

    def carry(
        self, state: State, rates: list[SingleArray], old: SingleArray, new: SingleArray, where: BoolArray
    ) -> SingleArray:
        """Carry q/12 of x[n-1] over a change of PWM (orders 2 to 4).

        Parameters
        ----------
        state
            Changed.
        rates
            The new ones.
        old, new
            q with the old and the new coefficients.
        where
            Lanes whose coefficients are new.

        Returns
        -------
        SingleArray
            q after the carry; ``new`` in the other lanes.
        """
        place = self._order - 2
        carried = self._component.carry_factor * (new - old)
        self._add(state, place, carried, 0, where)
        return np.where(where, new - rates[place + 1] * (rates[place] * carried), new)

    def advance(self, state: State, q: SingleArray) -> None:
        """The chain of additions, see :mod:`gen.lowering.recursion.increments`."""
        n, shifts, every = self._order, self._shifts, np.ones(len(q), dtype=bool)
        if n == 2:
            self._add(state, 0, word(state[1]), shifts[0], every)
            self._add(state, 0, q, shifts[0] + 1, every)  # q/2
        elif n == 3:
            self._add(state, 0, word(state[1]), shifts[0], every)
        elif n == 4:
            x3 = word(state[2])
            self._add(state, 0, word(state[1]), shifts[0], every)
            self._add(state, 0, x3, shifts[0] + shifts[1] + 1, every)  # x3/2
            self._add(state, 1, x3, shifts[1], every)
        self._add(state, n - 1, q, 0, every)
        if n > 2:
            self._add(state, n - 2, word(state[n - 1]), shifts[n - 2], every)

    def rise(self, state: State) -> FloatArray:
        """The temperature rise in K: x1 without its low bits."""
        return np.asarray((state[0] >> LOW_BITS) * 2.0 ** -self._component.fraction_bits[0], dtype=np.float64)

    @staticmethod
    def words(state: State) -> list[IntArray]:
        """Low bits and word of each accumulator, in the order of the board's structure."""
        return [part for value in state for part in (value & ((1 << LOW_BITS) - 1), value >> LOW_BITS)]

    def _add(self, state: State, i: int, value: SingleArray, shift: int, where: BoolArray) -> None:
        if self._component.saturates:
            end = np.float32(2.0 ** (LIMIT_BITS + shift))
            beyond = where & (np.abs(value) >= end)
            value = np.where(beyond, np.copysign(np.nextafter(end, np.float32(0.0)), value), value)
            self.saturations = self.saturations + beyond
        total = np.where(where, accumulated(state[i], value, shift), state[i])
        if self._component.saturates:
            words, limit = total >> LOW_BITS, 1 << LIMIT_BITS
            beyond = where & ((words > limit) | (words < -limit))
            total = np.where(beyond, np.sign(words) * (limit << LOW_BITS), total)
            self.saturations = self.saturations + beyond
        state[i] = total
