"""The board's words for many lanes at once, through the reference simulator: a state that can be branched and set."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import RESIDUE_BITS
from gen.lowering.float32 import LOW_BITS
from gen.lowering.program import AnyComponent
from gen.lowering.recursion import increments
from gen.reference.lanes import FixedLanes, FloatLanes, lanes_of, word_bits

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
State = list[Integers]


class Board:
    """One component as the board advances it.

    Parameters
    ----------
    component
        What to run.
    """

    def __init__(self, component: AnyComponent) -> None:
        self.component = component
        lanes = lanes_of(component, [0])
        assert isinstance(lanes, FixedLanes | FloatLanes)
        self._lanes = lanes
        if isinstance(component, FixedComponent):
            self._low, bits = RESIDUE_BITS, component.layout.fraction_bits
        else:
            self._low, bits = LOW_BITS, tuple(f + LOW_BITS for f in component.fraction_bits)
        self._units: Array = np.ldexp(1.0, -np.array(bits))
        self.fraction_bits = word_bits(component)

    def start(self, rise_mK: list[int]) -> State:
        """States at rest, one for each rise in thousandths of a kelvin."""
        lanes = lanes_of(self.component, rise_mK)
        assert isinstance(lanes, FixedLanes | FloatLanes)
        return list(lanes._state)

    def sample(self, state: State, row: Integers, before: Integers | None) -> State:
        """The states after a sample at the domain's rows ``row``; ``before`` is the last one's, None at the start."""
        self._lanes._state = list(state)
        self._lanes._step.saturations = np.zeros((), dtype=np.int64)  # they are counted by lane, and lanes branch
        self._lanes.sample(row, before)
        return list(self._lanes._state)

    def word(self, state: State) -> Integers:
        """The word of x1 that the board gives out, of 2^-fraction_bits K."""
        word: Integers = state[0] >> self._low
        return word

    def rise(self, state: State) -> Array:
        """The same in K."""
        return np.asarray(self.word(state) * 2.0**-self.fraction_bits, dtype=np.float64)

    def values(self, state: State) -> Array:
        """x1 .. xn with all their bits, in K per sample^k, shape (lanes, n)."""
        return np.stack([word * unit for word, unit in zip(state, self._units, strict=True)], axis=1)

    def words(self, values: Array) -> State:
        """The state nearest below given values, shape (lanes, n)."""
        return [np.floor(v / unit).astype(np.int64) for v, unit in zip(values.T, self._units, strict=True)]

    def maps(self) -> Array:
        """x - s as a linear function of (T, Ts T', Ts^2 T'', ..) - s at each row, shape (rows, n, n).

        It guides the search and judges nothing: what it lacks looks like a larger disturbance.
        """
        component, n = self.component, self.component.order
        finer = np.diag(float(component.substeps) ** -np.arange(n))
        if isinstance(component, FixedComponent):
            rates = component.rates * 2.0 ** -np.array(component.layout.rate_fraction_bits)
            if component.layout.corrected:
                constant = increments.state_map(np.zeros((1, n)), 0.0)[0]
                constant[0] -= constant[2] / 12.0
                return np.tile(constant @ finer, (len(rates), 1, 1))
        else:
            rates = component.rates.astype(np.float64)
        maps: Array = increments.state_map(increments.from_rates(rates)) @ finer
        return maps


@dataclass(frozen=True)
class Copy:
    """The board's state as a copy of the true one, and back.

    Attributes
    ----------
    maps, inverse
        :meth:`Board.maps` and its inverse, shape (rows, n, n).
    steady
        Shape (rows,).
    """

    maps: Array
    inverse: Array
    steady: Array

    @classmethod
    def of(cls, board: Board, steady: Array) -> Copy:
        """For a board and the exact steady rises in K."""
        maps = board.maps()
        return cls(maps, np.asarray(np.linalg.inv(maps), dtype=np.float64), steady)

    def true(self, values: Array, row: Integers) -> Array:
        """The copy y of the true state, for the board's values at rows, shape (lanes, n)."""
        return self._mapped(self.inverse, values, row)

    def board(self, true: Array, row: Integers) -> Array:
        """The board's values for a true state at rows."""
        return self._mapped(self.maps, true, row)

    def _mapped(self, maps: Array, values: Array, row: Integers) -> Array:
        steady = self.steady[row]
        away = values.copy()
        away[:, 0] -= steady
        mapped = (maps[row] @ away[:, :, None])[:, :, 0]
        mapped[:, 0] += steady
        return mapped
