"""How deep a firmware's stack goes: paint the free RAM, run, and look how far the paint was scratched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.avr.memory import Memory
from gen.avr.shim import Handle


@dataclass(frozen=True)
class StackUse:
    """What the stack took since it was painted.

    Parameters
    ----------
    deepest
        Bytes from the top of SRAM down to the lowest byte written: all of the stack.
    below_paint
        Bytes of that below the stack pointer's place when the stack was painted.
    free
        Bytes between static data and the lowest byte written that were never touched.
    """

    deepest: int
    below_paint: int
    free: int


class Stack:
    """The stack of an open emulator.

    Parameters
    ----------
    handle
        The emulator.
    memory
        Its memory.
    """

    def __init__(self, handle: Handle, memory: Memory) -> None:
        self._handle = handle
        self._memory = memory
        self._painted = (0, 0)

    @property
    def pointer(self) -> int:
        """The stack pointer: the address of the next free byte."""
        return int(self._handle.call("sp"))

    def paint(self) -> None:
        """Fill the RAM between static data (and heap) and the stack pointer with a pattern, for `use`.

        Done once when the emulator is opened; do it again at a later place to measure from there.
        """
        low, high = self._floor(), self.pointer + 1
        self._painted = (low, high)
        if high > low:
            self._memory.poke(low, _canary(low, high).tobytes())

    @property
    def top(self) -> int:
        """The address behind the RAM's last byte."""
        return int(self._handle.call("ramend")) + 1

    def use(self) -> StackUse:
        """Measure the deepest stack use since the last `paint`, in bytes.

        What counts is the lowest byte that was *written*, with another value than the paint's: it may err by
        a byte in one case of 256. A frame that is reserved and never written to is not seen.
        """
        low, high = self._painted
        floor = max(low, self._floor())
        memory = np.frombuffer(self._memory.peek(floor, max(high - floor, 0)), dtype=np.uint8)
        touched = np.flatnonzero(memory != _canary(floor, floor + memory.size))
        lowest = floor + int(touched[0]) if touched.size else max(high, floor)
        return StackUse(deepest=self.top - lowest, below_paint=high - lowest, free=lowest - floor)

    def _floor(self) -> int:
        floor = self._memory.address("_end")
        if "__brkval" in self._memory.symbols:
            floor = max(floor, self._memory.peek_int("__brkval", 2))
        return floor


def _canary(low: int, high: int) -> NDArray[np.uint8]:
    """A pattern that differs from byte to byte, so that no constant fill in the firmware can hide in it."""
    address = np.arange(low, high, dtype=np.uint32)
    return ((address * np.uint32(2654435761)) >> np.uint32(24)).astype(np.uint8)
