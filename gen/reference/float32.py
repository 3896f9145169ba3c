"""The float32 recursion, word for word as the board computes it.

Every operation is one float32 operation in the board's order.  Words are float32 arrays, one entry per lane (numpy
scalars of float32 work as well); nothing here may promote to float64.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gen.lowering.float32 import CARRY, FloatComponent

Word = NDArray[np.float32]

_HALF = np.float32(0.5)
_MAGNITUDE = np.uint32(0x7FFF)


def upper_magnitude(word: Word) -> NDArray[np.uint32]:
    """The upper 16 bits without the sign: what the board compares instead of magnitudes."""
    bits: NDArray[np.uint32] = (np.asarray(word, dtype=np.float32).view(np.uint32) >> np.uint32(16)) & _MAGNITUDE
    return bits


def leading(word: Word) -> Word:
    """The word with the lower 16 bits cleared: its 8 leading significant bits."""
    bits = np.asarray(word, dtype=np.float32).view(np.uint32) & np.uint32(0xFFFF0000)
    return bits.view(np.float32)


class FloatStep:
    """One sample of one component; counts folds, and where a high word had to be limited.

    A state is the list of the board's struct and is changed in place: [base, low, drive, keep] for order 1, else
    [base, low, high2, low2, .. high_n, low_n] and from order 3 on xn, the sum of the last two.

    Parameters
    ----------
    component
        What to run.

    Attributes
    ----------
    saturations
        How many of each lane's words were limited so far.
    folds
        How many words were folded so far, over all lanes.
    """

    def __init__(self, component: FloatComponent) -> None:
        self._order = component.order
        self._saturates = component.saturates
        self._start_constant = np.float32(component.start_constant)
        self._steady_constant = np.float32(component.steady_constant)
        self._thresholds = [np.uint32(word) for word in component.threshold_words]
        self._limits = [np.float32(limit) for limit in component.limits]
        self._start_range = tuple(np.float32(end) for end in component.start_range)
        self.saturations: NDArray[np.int64] = np.zeros((), dtype=np.int64)
        self.folds = 0

    def start(self, rise: Word) -> list[Word]:
        """The state at rest at a rise in K (clamped to the start range), with S = 0 until :meth:`change`."""
        lowest, highest = self._start_range
        clamped = np.where(rise < lowest, lowest, np.where(rise > highest, highest, rise)).astype(np.float32)
        on_grid = (clamped + self._start_constant) - self._start_constant
        count = (4, 4, 7, 9)[self._order - 1]
        words: list[Word] = [np.zeros_like(clamped) for _ in range(count)]
        words[0] = np.float32(0.0) - on_grid
        words[1] = clamped - on_grid
        return words

    def on_grid(self, steady: Word) -> Word:
        """A steady rise rounded so that it may be passed to :meth:`change` (for schedules computed on board)."""
        return (steady + self._steady_constant) - self._steady_constant

    def constant(self, state: list[Word], rates: list[Word]) -> None:
        """One (sub)step with the PWM of the last one."""
        if self._order == 1:
            state[1] = state[3] * state[1] + state[2]
            self._fold_driven(state, rates[0])
        else:
            self.advance(state, self.increment(state, rates))

    def changed(self, state: list[Word], old: list[Word], new: list[Word], old_steady: Word, new_steady: Word) -> None:
        """One (sub)step, the first with a new PWM; the old rates and steady rise are 0 after :meth:`start`."""
        if self._order == 1:
            self.change(state, old_steady, new_steady)
            state[2] = new[0] * state[0]
            state[3] = np.float32(1.0) - new[0]
            self.constant(state, new)
            return
        before = self.increment(state, old)
        self.change(state, old_steady, new_steady)
        self.advance(state, self.carry(state, new, before, self.increment(state, new)))

    def change(self, state: list[Word], old_steady: Word, new_steady: Word) -> None:
        """Move base to another steady rise; the old one is 0 after :meth:`start`.  Exact."""
        state[0] = state[0] + (new_steady - old_steady)

    def increment(self, state: list[Word], rates: list[Word]) -> Word:
        """q for a state (not changed), orders 2 to 4."""
        q = rates[0] * (state[0] - state[1])
        for i in range(1, self._order):
            kept = i > 1 and i == self._order - 1
            q = rates[i] * (q - (state[2 * i + 2] if kept else self._sum(state, i)))
        return q

    def carry(self, state: list[Word], rates: list[Word], old: Word, new: Word) -> Word:
        """Carry q/12 of x[n-1] over a change of PWM (orders 2 to 4).

        Parameters
        ----------
        state
            Changed.
        rates
            The new ones.
        old, new
            q with the old and the new coefficients.

        Returns
        -------
        Word
            q with the new coefficients after the carry.
        """
        place = self._order - 2
        carried = CARRY * (new - old)
        state[2 * place + 1] = state[2 * place + 1] + carried
        return new - rates[place + 1] * (rates[place] * carried)

    def advance(self, state: list[Word], q: Word) -> None:
        """The chain of additions, see :mod:`gen.lowering.increments` (orders 2 to 4)."""
        order = self._order
        if order == 2:
            state[1] = state[1] + (self._sum(state, 1) + _HALF * q)
        elif order == 3:
            state[1] = state[1] + self._sum(state, 1)
        else:
            x3 = self._sum(state, 2)
            state[1] = state[1] + (self._sum(state, 1) + _HALF * x3)
            state[3] = state[3] + x3
            self._fold_pair(state, 1)
        self._fold_base(state)
        last = order - 1
        state[2 * last + 1] = state[2 * last + 1] + q
        self._fold_pair(state, last)
        if order > 2:
            state[2 * last + 2] = self._sum(state, last)
            state[2 * last - 1] = state[2 * last - 1] + state[2 * last + 2]
            self._fold_pair(state, last - 1)

    def rise(self, state: list[Word], steady: Word) -> Word:
        """The temperature rise in K at the present steady rise."""
        return (steady - state[0]) + state[1]

    @staticmethod
    def words(state: list[Word]) -> list[NDArray[np.uint32]]:
        """The state's bits in the order of the board's struct."""
        return [np.asarray(word, dtype=np.float32).view(np.uint32) for word in state]

    @staticmethod
    def _sum(state: list[Word], i: int) -> Word:
        return state[2 * i] + state[2 * i + 1]

    def _fold_driven(self, state: list[Word], rate: Word) -> None:
        full = self._fold_base(state)
        if np.any(full):
            state[2] = np.where(full, rate * state[0], state[2])

    def _fold_base(self, state: list[Word]) -> NDArray[np.bool_]:
        return self._fold(state, 0, np.float32(-1.0))

    def _fold_pair(self, state: list[Word], i: int) -> None:
        self._fold(state, i, np.float32(1.0))

    def _fold(self, state: list[Word], i: int, sign: np.float32) -> NDArray[np.bool_]:
        """Move low's leading bits to base (which has x1 with the other sign) or to high."""
        high, low = state[2 * i], state[2 * i + 1]
        full = upper_magnitude(low) >= self._thresholds[i]
        if np.any(full):
            self.folds += int(np.count_nonzero(full))
            moved = leading(low)
            state[2 * i] = self._limited(np.where(full, high + sign * moved, high), full, self._limits[i])
            state[2 * i + 1] = np.where(full, low - moved, low)
        return full

    def _limited(self, word: Word, where: NDArray[np.bool_], limit: np.float32) -> Word:
        if not self._saturates:
            return word
        beyond = where & (np.abs(word) > limit)
        self.saturations = self.saturations + beyond
        return np.where(beyond, np.copysign(limit, word), word)
