"""One component over many lanes, in either arithmetic, behind one interface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gen.arrays import BoolArray, FloatArray, IntArray, SingleArray
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import RESIDUE_BITS
from gen.lowering.fixed.start import start_scale
from gen.lowering.float32 import LOW_BITS, FloatComponent
from gen.lowering.float32.start import ambient_word
from gen.lowering.program import AnyComponent
from gen.reference.fixed import FixedStep
from gen.reference.float32 import FloatStep
from gen.reference.thousandths import thousandths

Fields = list[tuple[str, str]]


class ComponentLanes(Protocol):
    """What :class:`gen.reference.model.ReferenceModel` needs of a component."""

    limited: BoolArray

    def set_ambient(self, over_mK: IntArray) -> None:
        """The ambient over the reference from the next sample on, in thousandths of a kelvin, shape (L,)."""

    @property
    def ambient(self) -> IntArray:
        """That ambient as words of the rise, shape (L,)."""

    def sample(self, row: IntArray, before: IntArray | None) -> None:
        """Advance by one sample at the tables' rows ``row``; ``before`` is the last sample's, None at the start."""

    def rise(self) -> FloatArray:
        """Temperature rise of every lane, in K."""

    def rise_mK(self) -> IntArray:
        """The same in thousandths of a kelvin, to nearest, as the board gives it out."""

    def saturations(self) -> IntArray:
        """How often each lane's words were limited."""

    def state_words(self) -> list[NDArray[Any]]:
        """The state's words in the order of the board's structure."""

    def coefficient_words(self, row: IntArray) -> list[NDArray[Any]]:
        """Rates and steady rise in the order of the board's structure."""


class FixedLanes:
    """A component in fixed point."""

    def __init__(self, component: FixedComponent, start_mK: Sequence[int]) -> None:
        self._component = component
        self._step = FixedStep(component)
        words = zip(*(self._step.start(rise) for rise in start_mK), strict=True)
        self._state = [np.array(word, dtype=np.int64) for word in words]
        low, high = component.start_range_mK
        self.limited = np.array([rise < low or rise > high for rise in start_mK])
        self._ambient = self._acted = np.zeros(len(start_mK), dtype=np.int64)

    @property
    def ambient(self) -> IntArray:
        """See :class:`ComponentLanes`."""
        return self._ambient

    def set_ambient(self, over_mK: IntArray) -> None:
        """See :class:`ComponentLanes`."""
        self._ambient = start_scale(self._component.layout.output_bits).word(over_mK)

    def sample(self, row: IntArray, before: IntArray | None) -> None:
        """See :class:`ComponentLanes`."""
        acted, self._acted = self._acted, self._ambient
        rates, steady = self._coefficients(row, self._ambient)
        changed = before is None or bool(np.any((before != row) | (acted != self._ambient)))
        if self._component.carries and changed:
            old = np.zeros(len(row), dtype=np.int64)
            if before is not None:
                old = self._step.increment(self._state, *self._coefficients(before, acted))
            self._step.carry(self._state, old, self._step.increment(self._state, rates, steady))
        for _ in range(self._component.substeps):
            self._step.advance(self._state, rates, self._step.increment(self._state, rates, steady))

    def rise(self) -> FloatArray:
        """See :class:`ComponentLanes`."""
        scale = 2.0 ** (RESIDUE_BITS - self._component.layout.fraction_bits[0])
        return np.asarray((self._state[0] >> RESIDUE_BITS) * scale, dtype=np.float64)

    def rise_mK(self) -> IntArray:
        """See :class:`ComponentLanes`."""
        return thousandths(self._state[0] >> RESIDUE_BITS, self._component.layout.output_bits)

    def saturations(self) -> IntArray:
        """See :class:`ComponentLanes`."""
        return np.zeros(len(self.limited), dtype=np.int64) + self._step.saturations

    def state_words(self) -> list[NDArray[Any]]:
        """See :class:`ComponentLanes`."""
        return [half for word in self._state for half in (word & 0xFFFF, word >> RESIDUE_BITS)]

    def coefficient_words(self, row: IntArray) -> list[NDArray[Any]]:
        """See :class:`ComponentLanes`."""
        rates, steady = self._coefficients(row, self._acted)
        return [*rates, steady]

    def _coefficients(self, row: IntArray, ambient: IntArray) -> tuple[list[IntArray], IntArray]:
        component = self._component
        return [component.rates[row, i] for i in range(component.order)], component.steady[row] + ambient


class FloatLanes:
    """A component in float32."""

    def __init__(self, component: FloatComponent, start_mK: Sequence[int]) -> None:
        self._component = component
        self._step = FloatStep(component)
        self._rates = component.rate_words
        rise = np.array(start_mK, dtype=np.int64)
        self._state = self._step.start(rise)
        low, high = component.start_range_mK
        self.limited = (rise < low) | (rise > high)
        self._ambient = self._acted = np.zeros(len(rise), dtype=np.int64)

    @property
    def ambient(self) -> IntArray:
        """See :class:`ComponentLanes`."""
        return self._ambient

    def set_ambient(self, over_mK: IntArray) -> None:
        """See :class:`ComponentLanes`."""
        self._ambient = ambient_word(self._component.fraction_bits[0], over_mK)

    def sample(self, row: IntArray, before: IntArray | None) -> None:
        """See :class:`ComponentLanes`."""
        acted, self._acted = self._acted, self._ambient
        rates, steady = self._coefficients(row, self._ambient)
        substeps, changed = self._component.substeps, np.ones(len(row), dtype=bool)
        if before is not None:
            changed = (before != row) | (acted != self._ambient)
        if self._component.order > 1 and np.any(changed):
            old = np.zeros(len(row), dtype=np.float32)
            if before is not None:
                old = self._step.increment(self._state, *self._coefficients(before, acted))
            new = self._step.increment(self._state, rates, steady)
            self._step.advance(self._state, self._step.carry(self._state, rates, old, new, changed))
            substeps -= 1
        for _ in range(substeps):
            self._step.advance(self._state, self._step.increment(self._state, rates, steady))

    def rise(self) -> FloatArray:
        """See :class:`ComponentLanes`."""
        return self._step.rise(self._state)

    def rise_mK(self) -> IntArray:
        """See :class:`ComponentLanes`."""
        return thousandths(self._state[0] >> LOW_BITS, self._component.fraction_bits[0])

    def saturations(self) -> IntArray:
        """See :class:`ComponentLanes`."""
        return np.zeros(len(self.limited), dtype=np.int64) + self._step.saturations

    def state_words(self) -> list[NDArray[Any]]:
        """See :class:`ComponentLanes`."""
        return list(self._step.words(self._state))

    def coefficient_words(self, row: IntArray) -> list[NDArray[Any]]:
        """See :class:`ComponentLanes`."""
        rates, steady = self._coefficients(row, self._acted)
        return [*(np.ascontiguousarray(rate).view(np.uint32) for rate in rates), steady]

    def _coefficients(self, row: IntArray, ambient: IntArray) -> tuple[list[SingleArray], IntArray]:
        return [self._rates[row, i] for i in range(self._component.order)], self._component.steady[row] + ambient


def lanes_of(component: AnyComponent, start_mK: Sequence[int]) -> ComponentLanes:
    """A component's lanes at rest at the given rises, in thousandths of a kelvin."""
    if isinstance(component, FixedComponent):
        return FixedLanes(component, start_mK)
    return FloatLanes(component, start_mK)


def state_fields(component: AnyComponent) -> Fields:
    """Names and types of the state's words, in the order of the board's structure."""
    low = "<u2" if isinstance(component, FixedComponent) else "u1"
    return [
        (f"{component.name}.x{i}.{half}", kind)
        for i in range(1, component.order + 1)
        for half, kind in (("lo", low), ("hi", "<i4"))
    ]


def coefficient_fields(component: AnyComponent) -> Fields:
    """Names and types of the coefficients' words, in the order of the board's structure."""
    rates = [(f"{component.name}.R{i}", "<u4") for i in range(component.order)]
    return [*rates, (f"{component.name}.S", "<i4")]


def word_bits(component: AnyComponent) -> int:
    """Fraction bits of a component's rise as the high word of x1 has it."""
    if isinstance(component, FixedComponent):
        return component.layout.output_bits
    return component.fraction_bits[0]
