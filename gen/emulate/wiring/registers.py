"""The MAX31856s and MAX31865s on the board's pins."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Literal

from gen.avr.shim import Handle
from gen.avr.simulator import FREQUENCY_HZ
from gen.emulate.wiring.max6675 import ChipCounts
from gen.emulate.wiring.pins import PortPin

RegisterChipName = Literal["MAX31856", "MAX31865"]
#: Longest conversion in s, first register of the data, their bytes, and what makes the chip convert again and again
#: (data sheets; of the MAX31865 with 50 Hz filtered).
_KINDS: dict[str, tuple[float, int, int, int]] = {
    "MAX31856": (0.185, 0x0C, 4, 0x80),
    "MAX31865": (0.066, 0x01, 2, 0xC0),
}


class RegisterChip:
    """One converter that has to be told what to do; SO, SCK and SDI may be shared with others.

    Parameters
    ----------
    handle
        The emulator that it is connected to.
    kind
        Which chip.
    lines
        Where CS, SO, SCK and SDI are.

    Raises
    ------
    ValueError
        When the emulator has no converter left.
    """

    def __init__(self, handle: Handle, kind: RegisterChipName, lines: Sequence[PortPin]) -> None:
        conversion_s, at, self._bytes, converts = _KINDS[kind]
        places = [part for line in lines for part in (line.port.encode(), line.bit)]
        cycles = round(conversion_s * FREQUENCY_HZ)
        self._handle = handle
        self._number = int(handle.call("register_chip_add", *places, cycles, at, self._bytes, converts))
        if self._number < 0:
            raise ValueError("the emulator has no converter left")

    def set_word(self, word: int) -> None:
        """Let conversions give a word's data bytes from now on; all zeros or all ones is a line shorted to that level.

        Of a MAX31865's word (configuration, resistance) the resistance: its configuration is what the firmware wrote.
        """
        line = {0: 0, 0xFFFF_FFFF: 1}.get(word, -1)
        self._handle.call("register_chip_data", self._number, word & (1 << 8 * self._bytes) - 1, line)

    @property
    def counts(self) -> ChipCounts:
        """Its reads so far; of clashes on its line it knows nothing."""
        counts = [ctypes.c_uint32() for _ in range(2)]
        self._handle.call("register_chip_counts", self._number, *map(ctypes.byref, counts))
        return ChipCounts(counts[0].value, counts[1].value, 0)

    def lose_supply(self) -> None:
        """Let the chip alone be without supply for a moment: it forgets what it was told."""
        self._handle.call("register_chip_forget", self._number)

    def register(self, at: int) -> int:
        """What a register holds; raises `ValueError` where there is none."""
        found = int(self._handle.call("register_chip_register", self._number, at))
        if found < 0:
            raise ValueError(f"no register {at}; expected 0..15")
        return found
