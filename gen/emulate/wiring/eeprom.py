"""The EEPROM."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

from gen.avr.shim import Handle


@dataclass(frozen=True)
class EepromCounts:
    """Writes begun, and accesses that the chip refused because a write was under way."""

    writes: int
    refused: int


class Eeprom:
    """What an open emulator keeps without power.

    Parameters
    ----------
    handle
        The emulator.
    """

    def __init__(self, handle: Handle) -> None:
        self._handle = handle
        self._size = int(handle.call("eeprom_size"))

    @property
    def image(self) -> bytes:
        """The 4096 bytes; assign to load others."""
        buffer = (ctypes.c_uint8 * self._size)()
        self._handle.call("eeprom_save", buffer)
        return bytes(buffer)

    @image.setter
    def image(self, image: bytes) -> None:
        if len(image) != self._size:
            raise ValueError(f"an EEPROM image has {self._size} bytes, not {len(image)}")
        self._handle.call("eeprom_load", image)

    @property
    def busy(self) -> bool:
        """Whether the chip is writing a byte."""
        return bool(self._handle.call("eeprom_busy"))

    @property
    def counts(self) -> EepromCounts:
        """What the firmware did with it so far."""
        counts = [ctypes.c_uint32() for _ in range(2)]
        self._handle.call("eeprom_counts", *map(ctypes.byref, counts))
        return EepromCounts(*(count.value for count in counts))
