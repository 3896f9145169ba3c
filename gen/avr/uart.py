"""The outer end of the emulated chip's UART0."""

from __future__ import annotations

import ctypes

from gen.avr.shim import Handle

_BYTE_CYCLES = 1528  # 11 bit times at 115 200 baud as the core sets it: simavr's own pace


class Uart:
    """What UART0 of an open emulator sends and receives.

    Parameters
    ----------
    handle
        The emulator.
    """

    def __init__(self, handle: Handle) -> None:
        self._handle = handle

    def take(self) -> bytes:
        """Give the bytes that UART0 sent since the last call."""
        size = int(self._handle.call("uart_available"))
        buffer = (ctypes.c_uint8 * max(size, 1))()
        self._handle.call("uart_take", buffer, size)
        self._handle.call("uart_forget")
        return bytes(buffer[:size])

    def send(self, data: bytes, *, byte_cycles: int = _BYTE_CYCLES) -> None:
        """Queue bytes for UART0's receiver; they arrive while the firmware runs.

        As on the board, bytes that arrive before the firmware switched its receiver on are lost.

        Parameters
        ----------
        data
            The bytes.
        byte_cycles
            Clock cycles from one byte to the next.
        """
        if self._handle.call("uart_send", data, len(data), byte_cycles):
            raise MemoryError
