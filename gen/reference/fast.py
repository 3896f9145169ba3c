"""The fast fixed-point recursion over many lanes, word for word as the board computes it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.lowering.fast_block import BACKWARD, FORWARD
from gen.lowering.fast_format import (
    BLOCK,
    RESIDUE_BITS,
    FastComponent,
    fast_product,
    narrow_product,
    rounded_product,
)

Integers = NDArray[np.int64]

#: 2^32 / 6: twice the share of q that x[n-1] carries.
SIXTH = 715827883


def start_words(component: FastComponent, rise_mK: int) -> list[int]:
    """State at rest at a rise in thousandths of a kelvin, limited to the declared range.

    x2.. start at half a unit of the word before: what adding them rounded down loses on average.
    """
    low, high = component.start_range_mK
    m, e = component.layout.scale
    first = -((-max(low, min(high, rise_mK)) << e) // m) << RESIDUE_BITS  # up: it is read back rounded down
    return [first, *(1 << (gap - 1) for gap in component.layout.gaps)]


def share(part: Integers, rate: Integers, j: int, terms: tuple[int, int]) -> Integers:
    """m (1 + .. y + .. y^2) times ``part``, to nearest: see :mod:`gen.lowering.fast_block`.

    Parameters
    ----------
    part
        y (T - S) in units of the word, 32 bits.
    rate
        y * 2^40.
    j
        Samples since the block's start, 1..BLOCK - 1.
    terms
        One of :data:`FORWARD` or :data:`BACKWARD`.
    """
    short = rate >> 16
    fine = (rate >> 8) * terms[0] + ((short * short) >> 16) * terms[1]
    return rounded_product(part, (j << 30) + (fine >> 8))


class FastLanes:
    """A component in the fast fixed-point form; see :class:`gen.reference.lanes.ComponentLanes`.

    Parameters
    ----------
    component
        What to run.
    start_mK
        Rise of each lane at the start.
    """

    def __init__(self, component: FastComponent, start_mK: Sequence[int]) -> None:
        self._component = component
        words = zip(*(start_words(component, rise) for rise in start_mK), strict=True)
        self._state = [np.array(word, dtype=np.int64) for word in words]
        low, high = component.start_range_mK
        self.limited = np.array([rise < low or rise > high for rise in start_mK])
        self._phase = 0
        self._row: Integers | None = None

    @property
    def _elapsed(self) -> int:
        """Samples since the block's start."""
        return (self._phase - self._component.slot) % BLOCK

    def sample(self, row: Integers, before: Integers | None) -> None:
        """Advance by one sample, after what a change of PWM asks for."""
        changed = np.ones(len(row), dtype=bool) if before is None else before != row
        if changed.any():
            kept = [word.copy() for word in self._state]
            if self._component.order == 1:
                self._rebase(row, before)
            else:
                self._carry(row, before)
            self._state = [np.where(changed, new, old) for new, old in zip(self._state, kept, strict=True)]
        self._row = row
        self._phase = (self._phase + 1) % BLOCK
        if self._component.order > 1:
            self._advance(*self._coefficients(row))
        elif self._elapsed == 0:
            rates, steady = self._coefficients(row)
            self._state[0] = self._state[0] - fast_product(((self._state[0] >> 16) - steady) << 8, rates[0])

    def _advance(self, rates: list[Integers], steady: Integers) -> None:
        layout, x = self._component.layout, self._state
        order, gap = layout.order, layout.gaps
        inner = (x[0] >> (2 * RESIDUE_BITS if layout.narrow else RESIDUE_BITS)) - steady
        for i in range(order - 1):
            product = narrow_product if layout.narrow and i == 0 else fast_product
            inner = (x[i + 1] >> RESIDUE_BITS) + product(inner, rates[i])
        q = -(fast_product(inner, rates[-1]) << layout.increment_shift)
        if order == 2:
            x[0] = x[0] + ((x[1] - (-q >> 1)) >> gap[0])
            x[1] = x[1] + q
        elif order == 3:
            x[0] = x[0] + (x[1] >> gap[0])
            x[2] = x[2] + q
            x[1] = x[1] + (x[2] >> gap[1])
        else:
            x[0] = x[0] + ((x[1] + (x[2] >> (gap[1] + 1))) >> gap[0])
            x[1] = x[1] + (x[2] >> gap[1])
            x[3] = x[3] + q
            x[2] = x[2] + (x[3] >> gap[2])

    def _drive(self, row: Integers) -> Integers:
        """-q, before its shift, from products to nearest."""
        layout, x = self._component.layout, self._state
        rates, steady = self._coefficients(row)
        inner = (x[0] >> RESIDUE_BITS) - (steady << 8 if layout.narrow else steady)
        for i in range(layout.order - 1):
            rate = rates[i] << 8 if layout.narrow and i == 0 else rates[i]
            inner = (x[i + 1] >> RESIDUE_BITS) + rounded_product(inner, rate)
        return rounded_product(inner, rates[-1])

    def _carry(self, row: Integers, before: Integers | None) -> None:
        """x[n-1] carries q/12 over a change of PWM."""
        layout = self._component.layout
        old = np.zeros(len(row), dtype=np.int64) if before is None else self._drive(before)
        twelfth = rounded_product((old >> 1) - (self._drive(row) >> 1), np.full(len(row), SIXTH))
        shift = layout.gaps[-1] - layout.increment_shift
        self._state[-2] = self._state[-2] + ((twelfth + (1 << shift >> 1)) >> shift)

    def _part(self, row: Integers) -> tuple[Integers, Integers]:
        """y (T - S) and y of a first-order component."""
        rates, steady = self._coefficients(row)
        return rounded_product((self._state[0] >> RESIDUE_BITS) - (steady << 8) - 128, rates[0]), rates[0]

    def _rebase(self, row: Integers, before: Integers | None) -> None:
        """The rise now, and from which the block would have started with the new PWM."""
        j = self._elapsed
        if j == 0:
            return
        if before is not None:
            self._state[0] = self._state[0] - share(*self._part(before), j, FORWARD[j - 1])
        self._state[0] = self._state[0] + share(*self._part(row), j, BACKWARD[j - 1])

    def rise(self) -> NDArray[np.float64]:
        """Temperature rise of every lane as the board gives it out, in K."""
        return np.asarray(self._high_now() * self._component.layout.unit_K, dtype=np.float64)

    def rise_mK(self) -> Integers:
        """The same in thousandths of a kelvin, rounded down."""
        m, e = self._component.layout.scale
        return np.asarray((self._high_now() * m) >> e, dtype=np.int64)

    def _high_now(self) -> Integers:
        """x1's high word; within a block on the straight line to the block's end."""
        high = self._state[0] >> RESIDUE_BITS
        if self._component.order > 1 or self._row is None:
            return high
        return high - (((self._part(self._row)[0] >> 2) * self._elapsed) >> RESIDUE_BITS)

    def saturations(self) -> Integers:
        """None: the ranges are proven."""
        return np.zeros(len(self.limited), dtype=np.int64)

    def state_words(self) -> list[NDArray[Any]]:
        """The state's words in the order of the board's structure."""
        return [half for word in self._state for half in (word & 0xFF, word >> RESIDUE_BITS)]

    def coefficient_words(self, row: Integers) -> list[NDArray[Any]]:
        """Rates and steady rise in the order of the board's structure; those of 24 bits in two parts."""
        layout = self._component.layout
        rates, steady = self._coefficients(row)
        words: list[NDArray[Any]] = []
        for i, rate in enumerate(rates):
            words += [rate & 0xFFFF, rate >> 16] if layout.narrow and layout.order > 1 and i == 0 else [rate]
        return words + ([steady & 0xFFFF, steady >> 16] if layout.narrow else [steady])

    def _coefficients(self, row: Integers) -> tuple[list[Integers], Integers]:
        component = self._component
        return [component.rates[row, i] for i in range(component.order)], component.steady[row]


def fast_coefficient_fields(component: FastComponent) -> list[tuple[str, str]]:
    """Names and types of the coefficients' words."""
    name, layout = component.name, component.layout
    fields: list[tuple[str, str]] = []
    for i in range(component.order):
        if layout.narrow and component.order > 1 and i == 0:
            fields += [(f"{name}.R0.lo", "<u2"), (f"{name}.R0.hi", "u1")]
        else:
            fields.append((f"{name}.R{i}", "<u4"))
    if layout.narrow:
        return [*fields, (f"{name}.S.lo", "<u2"), (f"{name}.S.hi", "i1")]
    return [*fields, (f"{name}.S", "<i4")]
