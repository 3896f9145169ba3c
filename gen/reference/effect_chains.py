"""A component's recursion once more, driven by its effects, word for word as the board runs it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import IntArray, SingleArray
from gen.lowering.effects.program import GUARD_BITS
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import CARRY_FACTOR, RESIDUE_BITS, WORD_BITS
from gen.lowering.float32 import LOW_BITS, FloatComponent
from gen.reference.effect_tapes import Counter
from gen.reference.float32 import FloatStep

Words = list[NDArray[Any]]

_CHAIN_BITS = WORD_BITS + GUARD_BITS


def product(difference: IntArray, rate: IntArray, shift: int) -> IntArray:
    """difference rate 2^-shift, rounded down; 40 by 32 bits, in two parts that fit 64."""
    return ((difference >> 16) * rate + ((difference & 0xFFFF) * rate >> 16)) >> (shift - 16)


class FixedChain:
    """A component's recursion in fixed point, with whole products and every word held to its bits."""

    def __init__(self, component: FixedComponent, counter: Counter, lanes: int) -> None:
        self._component, self._layout = component, component.layout
        self._counter = counter
        self.x = [np.zeros(lanes, dtype=np.int64) for _ in range(component.order)]
        self.rates = [np.zeros(lanes, dtype=np.int64) for _ in range(component.order)]
        self.drive: IntArray = np.zeros(lanes, dtype=np.int64)

    def start(self, words: IntArray) -> None:
        """Rest at a rise in words that are read."""
        self.x = [words << RESIDUE_BITS, *(np.zeros_like(words) for _ in self.x[1:])]
        self.rates = [np.zeros_like(words) for _ in self.rates]
        self.drive = np.zeros_like(words)

    def word(self, x: list[IntArray] | None = None) -> IntArray:
        """What is read of the rise."""
        return (self.x if x is None else x)[0] >> RESIDUE_BITS

    def tried(self, row: IntArray, drive: IntArray) -> list[IntArray]:
        """The state after a sample with this drive."""
        rates = self._at(row)
        x = list(self.x)
        if self._component.order > 1:
            shift = self._layout.chain_shifts[-1]
            old = self._increment(x, self.rates, self.drive)
            change = (self._increment(x, rates, drive) - old >> 8) * CARRY_FACTOR >> (8 + shift)
            place = self._component.order - 2
            x[place] = self._limited(x[place] + change, _CHAIN_BITS)
        for _ in range(self._component.substeps):
            self._advance(x, self._increment(x, rates, drive))
        return x

    def advance(self, row: IntArray, drive: IntArray) -> None:
        """Take that sample."""
        self.x = self.tried(row, drive)
        self.rates, self.drive = self._at(row), drive

    def words(self) -> Words:
        """In the order of the board's structure."""
        return [*self.x, *([*self.rates, self.drive] if self._component.order > 1 else [])]

    def _at(self, row: IntArray) -> list[IntArray]:
        return [self._component.rates[row, i] for i in range(self._component.order)]

    def _increment(self, x: list[IntArray], rates: list[IntArray], drive: IntArray) -> IntArray:
        shifts = self._layout.product_shifts
        inner = self._limited((x[0] >> RESIDUE_BITS) - drive, _CHAIN_BITS - RESIDUE_BITS)
        for i in range(self._component.order - 1):
            inner = (x[i + 1] >> RESIDUE_BITS) + product(inner, rates[i], shifts[i]) + 1
            inner = self._limited(inner, _CHAIN_BITS - RESIDUE_BITS)
        return -product(inner, rates[-1], shifts[-1])

    def _advance(self, x: list[IntArray], q: IntArray) -> None:
        shift = self._layout.chain_shifts

        def add(place: int, term: IntArray) -> None:
            x[place] = self._limited(x[place] + term, _CHAIN_BITS)

        match self._component.order:
            case 1:
                add(0, q)
            case 2:
                add(0, (x[1] >> shift[0]) + (q >> (shift[0] + 1)))
                add(1, q)
            case 3:
                add(0, x[1] >> shift[0])
                add(2, q)
                add(1, x[2] >> shift[1])
            case _:
                add(0, (x[1] >> shift[0]) + (x[2] >> (shift[0] + shift[1] + 1)))
                add(1, x[2] >> shift[1])
                add(3, q)
                add(2, x[3] >> shift[2])

    def _limited(self, value: IntArray, bits: int) -> IntArray:
        return self._counter.held(value, -(1 << (bits - 1)), (1 << (bits - 1)) - 1)


class FloatChain:
    """The same in float32: the baseline's own recursion, once more, perhaps in a coarser unit (all words scale)."""

    def __init__(self, component: FloatComponent, counter: Counter, lanes: int) -> None:
        self._component, self._counter = component, counter
        self._step = FloatStep(component)
        self._rates = component.rate_words
        self.start(np.zeros(lanes, dtype=np.int64))

    def start(self, words: IntArray) -> None:
        """See :class:`FixedChain`."""
        self.x = [words << LOW_BITS, *(np.zeros_like(words) for _ in range(1, self._component.order))]
        self.rates = [np.zeros(words.shape, dtype=np.float32) for _ in range(self._component.order)]
        self.drive = np.zeros_like(words)

    def word(self, x: list[IntArray] | None = None) -> IntArray:
        """See :class:`FixedChain`."""
        return (self.x if x is None else x)[0] >> LOW_BITS

    def tried(self, row: IntArray, drive: IntArray) -> list[IntArray]:
        """See :class:`FixedChain`."""
        rates, x, step = self._at(row), list(self.x), self._step
        substeps = self._component.substeps
        if self._component.order > 1:
            old = step.increment(x, self.rates, self.drive)
            new = step.increment(x, rates, drive)
            step.advance(x, step.carry(x, rates, old, new, np.ones(len(row), dtype=bool)))
            substeps -= 1
        for _ in range(substeps):
            step.advance(x, step.increment(x, rates, drive))
        return x

    def advance(self, row: IntArray, drive: IntArray) -> None:
        """See :class:`FixedChain`."""
        self.x = self.tried(row, drive)
        self.rates, self.drive = self._at(row), drive

    def saturations(self) -> IntArray:
        """How often the recursion itself limited a word (a component without a proof)."""
        return np.asarray(np.zeros_like(self.drive) + self._step.saturations)

    def words(self) -> Words:
        """See :class:`FixedChain`."""
        kept: Words = [*(rate.view(np.uint32) for rate in self.rates), self.drive]
        return [*FloatStep.words(self.x), *(kept if self._component.order > 1 else [])]

    def _at(self, row: IntArray) -> list[SingleArray]:
        return [np.ascontiguousarray(self._rates[row, i]) for i in range(self._component.order)]
