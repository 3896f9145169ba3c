"""The emulated chip's data memory, by address and by the names in the firmware."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from pathlib import Path

from gen.avr.compile import SRAM_OFFSET, Symbol, symbols
from gen.avr.shim import Handle


class Memory:
    """Registers, I/O and SRAM of an open emulator, read and written without side effects.

    Parameters
    ----------
    handle
        The emulator.
    elf
        Its firmware, for the names.

    Attributes
    ----------
    symbols
        The firmware's, by linker name.

    Raises
    ------
    ToolMissing
        When avr-nm is not installed.
    """

    def __init__(self, handle: Handle, elf: Path) -> None:
        self._handle = handle
        self._firmware = elf.name
        self.symbols: Mapping[str, Symbol] = {symbol.name: symbol for symbol in symbols(elf)}

    def symbol(self, name: str) -> Symbol:
        """Look a symbol up by its linker name.

        Raises
        ------
        KeyError
            When the firmware has no such symbol.
        """
        if name not in self.symbols:
            raise KeyError(f"{self._firmware} has no symbol {name}")
        return self.symbols[name]

    def address(self, name: str) -> int:
        """Give the SRAM address of a variable in bytes, as `peek` and `EmulatedChip.run_records` take it.

        Raises
        ------
        KeyError
            When the firmware has no such symbol, or it does not lie in SRAM.
        """
        address = self.symbol(name).address - SRAM_OFFSET
        if not 0 <= address < 0x10000:
            raise KeyError(f"{name} of {self._firmware} does not lie in SRAM")
        return address

    def peek(self, address: int, size: int) -> bytes:
        """Read ``size`` bytes.

        Raises
        ------
        ValueError
            When they lie outside the data memory.
        """
        buffer = (ctypes.c_uint8 * max(size, 1))()
        if min(address, size) < 0 or self._handle.call("peek", address, size, buffer):
            raise ValueError(f"{size} bytes at {address:#x} lie outside the data memory")
        return bytes(buffer[:size])

    def poke(self, address: int, data: bytes) -> None:
        """Write bytes.

        Raises
        ------
        ValueError
            When they lie outside the data memory.
        """
        if address < 0 or self._handle.call("poke", address, len(data), data):
            raise ValueError(f"{len(data)} bytes at {address:#x} lie outside the data memory")

    def peek_int(self, name: str, size: int) -> int:
        """Read an unsigned variable of ``size`` bytes by its linker name."""
        return int.from_bytes(self.peek(self.address(name), size), "little")
