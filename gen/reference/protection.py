"""Causes and actions, sample by sample as the board has them, for many runs at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gen.arrays import BoolArray, IntArray, RecordArray
from gen.lowering.protection import MOST_TIMES, LoweredProtection, Word


class ReferenceProtection:
    """A board's table over L independent lanes.

    Parameters
    ----------
    entries
        The table.
    lanes
        How many.

    Attributes
    ----------
    acting, holding
        Bit masks of the entries, shape (L,): those that act, and those whose cause is there, for however long.
    """

    def __init__(self, entries: Sequence[LoweredProtection], lanes: int) -> None:
        self._entries = tuple(entries)
        self.acting = np.zeros(lanes, dtype=np.int64)
        self.holding = np.zeros(lanes, dtype=np.int64)
        self._asked = np.zeros(lanes, dtype=bool)
        self._held = np.zeros((len(entries), lanes), dtype=np.int64)
        self._left = np.zeros((len(entries), lanes), dtype=np.int64)
        self._times = np.zeros((len(entries), lanes), dtype=np.int64)

    def advance(self, record: RecordArray) -> None:
        """Go on from what a board keeps, shape (L,), see :func:`protection_fields`."""
        for number in range(len(self._entries)):
            self._held[number] = record[f"protection.{number}.held"]
        for number in _pausing(self._entries):
            self._left[number] = record[f"protection.{number}.left"]
            self._times[number] = record[f"protection.{number}.times"]
        self.acting = record["protection.acting"].astype(np.int64)
        self.holding = record["protection.holding"].astype(np.int64)
        self._asked = record["protection.asked"] != 0

    def restore(self, acting: IntArray) -> None:
        """Act as before a reset of the board.

        Parameters
        ----------
        acting
            Bit masks, shape (L,); bits of entries that end by themselves are ignored.
        """
        self.acting |= acting & sum(1 << number for number, entry in enumerate(self._entries) if entry.lasts)

    def ask(self, lanes: BoolArray) -> None:
        """Ask for the end of what has to be asked for, at the next sample, in the lanes that are marked, shape (L,)."""
        self._asked |= lanes

    def step(self, words: Mapping[Word, IntArray], measured_mC: IntArray, valid: IntArray) -> None:
        """Take a sample.

        Parameters
        ----------
        words
            Bit masks, shape (L,) each: latched rules, thermocouples that are not believed, what the sketch found.
        measured_mC
            Measured temperatures, shape (components, L), in thousandths of a degree Celsius.
        valid
            Bit masks of the components whose measurement passed its checks, shape (L,).
        """
        for number, entry in enumerate(self._entries):
            bit = 1 << number
            there = _set_bits(words[entry.word] & entry.mask, entry.mask) >= entry.least
            self._held[number] = np.where(there, np.minimum(self._held[number] + 1, entry.delay + 1), 0)
            cooled = np.ones_like(there)
            if entry.until == "cool":
                seen = ((valid >> entry.component) & 1) == 1
                cooled = seen & (measured_mC[entry.component] < entry.restart_mC)
            acted = (self.acting & bit) != 0
            ends = ~there & (cooled & self._asked & (self._left[number] == 0) if entry.lasts else np.ones_like(there))
            self.holding = np.where(there, self.holding | bit, self.holding & ~bit)
            self.acting = np.where(ends, self.acting & ~bit, self.acting)
            self.acting = np.where(self._held[number] > entry.delay, self.acting | bit, self.acting)
            if entry.pause:
                self._pause(number, entry, acted, (self.acting & bit) != 0)
        self._asked[:] = False

    @property
    def waiting(self) -> IntArray:
        """Samples before a command may end all that acts, shape (L,)."""
        waiting = np.zeros(len(self.acting), dtype=np.int64)
        for number in _pausing(self._entries):
            waiting = np.where((self.acting >> number) & 1, np.maximum(waiting, self._left[number]), waiting)
        return waiting

    def _pause(self, number: int, entry: LoweredProtection, acted: BoolArray, acts: BoolArray) -> None:
        """What comes again soon has to wait, each time twice as long; what stays away is forgotten bit by bit."""
        left, times = self._left[number], self._times[number]
        pause = np.where(times > 0, np.minimum(entry.pause << np.maximum(times - 1, 0), 0xFFFF), 0)
        forgets = ~acts & ~acted & (left == 0) & (times > 0)
        self._left[number] = np.select(
            [acts & ~acted, (acted & ~acts) | forgets], [pause, entry.forgotten], np.maximum(left - 1, 0)
        )
        self._times[number] = np.select([acts & ~acted, forgets], [np.minimum(times + 1, MOST_TIMES), times - 1], times)

    def most_pwm(self, full_scale: int) -> IntArray:
        """The largest |PWM| that is allowed, shape (L,), in counts."""
        most = np.full(len(self.acting), full_scale, dtype=np.int64)
        for number, entry in enumerate(self._entries):
            most = np.where((self.acting >> number) & 1, np.minimum(most, entry.pwm), most)
        return most

    @property
    def holds(self) -> BoolArray:
        """Whether the forecast says to what the motor is derated, shape (L,)."""
        return self.any_of([entry.holds for entry in self._entries])

    def any_of(self, chosen: Sequence[bool]) -> BoolArray:
        """Whether an entry acts that is among the chosen ones, shape (L,); `chosen` has one for each entry."""
        mask = sum(1 << number for number, choice in enumerate(chosen) if choice)
        found: BoolArray = (self.acting & mask) != 0
        return found

    def keep(self, record: RecordArray) -> None:
        """Write what the board keeps into a record, shape (L,), see :func:`protection_fields`."""
        if not self._entries:
            return
        for number in range(len(self._entries)):
            record[f"protection.{number}.held"] = self._held[number]
        for number in _pausing(self._entries):
            record[f"protection.{number}.left"] = self._left[number]
            record[f"protection.{number}.times"] = self._times[number]
        record["protection.acting"] = self.acting
        record["protection.holding"] = self.holding
        record["protection.asked"] = self._asked


def _pausing(entries: Sequence[LoweredProtection]) -> list[int]:
    """Numbers of the entries that have a pause."""
    return [number for number, entry in enumerate(entries) if entry.pause]


def _set_bits(values: IntArray, mask: int) -> IntArray:
    """How many bits of a mask are set in each value."""
    places = [place for place in range(mask.bit_length()) if mask >> place & 1]
    count: IntArray = sum(((values >> place) & 1 for place in places), np.zeros_like(values))
    return count


def protection_fields(entries: Sequence[LoweredProtection]) -> list[tuple[str, str]]:
    """The board's structure, byte by byte, packed and little endian; nothing without entries."""
    if not entries:
        return []
    held = [(f"protection.{number}.held", "<u2") for number in range(len(entries))]
    left = [(f"protection.{number}.left", "<u2") for number in _pausing(entries)]
    times = [(f"protection.{number}.times", "u1") for number in _pausing(entries)]
    return [
        *held,
        *left,
        *times,
        ("protection.acting", "<u4"),
        ("protection.holding", "<u4"),
        ("protection.asked", "u1"),
    ]
