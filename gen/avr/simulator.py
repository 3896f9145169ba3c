"""Runs firmware on an emulated ATmega2560 at 16 MHz (libsimavr, through the C files in ``shim/``).

Known faults of simavr 1.6 that results inherit: an interrupt is entered in 0 cycles instead of 5, and a byte
takes 11 bit times on UART0 instead of 10. Idle sleep passes in the cycle counter without costing host time.
"""

from __future__ import annotations

import ctypes
import os
import re
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gen.avr.compile import SRAM_OFFSET, Symbol, symbols
from gen.avr.shim import EmulationFailed, load_shim

__all__ = ["FREQUENCY_HZ", "MAILBOX_FOLDER", "MARKER_OVERHEAD", "EmulatedMega", "EmulationFailed", "StackUse", "Stop"]

FREQUENCY_HZ = 16_000_000
MARKER_OVERHEAD = 2
"""Cycles that the marks of ``mailbox.h`` add to a step: the OUT of the first and the LDI of the second."""

MAILBOX_FOLDER = Path(__file__).parent
"""The include folder of ``mailbox.h``."""

_SLICE_CYCLES = 400_000_000  # a keyboard interrupt is seen between slices
_BYTE_CYCLES = 1528  # 11 bit times at 115 200 baud as the core sets it: simavr's own pace


class Stop(IntEnum):
    """Why a run ended; the numbers are those of ``shim/mega.h``."""

    LIMIT = 0
    PATTERN = 1
    ENDED = 2
    CRASHED = 3
    RECORDS = 4
    PROTOCOL = 5
    PLACE = 6


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


class EmulatedMega:
    """An ATmega2560 with a firmware in its flash, just out of reset.

    Parameters
    ----------
    elf
        The firmware, as `gen.avr.compile.build_elf` writes it.
    cache
        The folder that keeps the compiled shim between runs.

    Raises
    ------
    ToolMissing
        When gcc, libsimavr or avr-nm are not installed.
    EmulationFailed
        When the ELF file cannot be loaded.
    """

    def __init__(self, elf: Path, cache: Path) -> None:
        self._handle: int | None = None
        if not elf.is_file():
            raise EmulationFailed(f"{elf}: no such firmware")
        self._elf = elf
        self._symbols = {symbol.name: symbol for symbol in symbols(elf)}
        self._library = load_shim(cache)
        handle = self._library.gen_mega_open(os.fsencode(elf))
        if not handle:
            raise EmulationFailed(f"{elf}: out of memory")
        self._handle = handle
        message = self._message()
        if message:
            self.close()
            raise EmulationFailed(f"{elf}: {message}")
        self._painted = (0, 0)
        self.paint_stack()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        self.close()

    def close(self) -> None:
        """Free the emulator; it cannot be used afterwards. Closing twice does no harm."""
        if self._handle is not None:
            self._library.gen_mega_close(self._handle)
            self._handle = None

    # ---- state ----

    @property
    def cycle(self) -> int:
        """Clock cycles since the emulator was opened, sleep included; a reset does not set it back."""
        return int(self._library.gen_mega_cycle(self._open()))

    @property
    def seconds(self) -> float:
        """Simulated time in seconds since the emulator was opened."""
        return self.cycle / FREQUENCY_HZ

    @property
    def asleep(self) -> int:
        """Clock cycles that the chip spent in a sleep mode since the emulator was opened."""
        return int(self._library.gen_mega_asleep(self._open()))

    def longest_awake(self) -> int:
        """Give the longest stretch of clock cycles without sleep since this was asked for last, interrupts included."""
        return int(self._library.gen_mega_longest_awake(self._open()))

    @property
    def stack_pointer(self) -> int:
        """The stack pointer: the address of the next free byte."""
        return int(self._library.gen_mega_sp(self._open()))

    @property
    def resets(self) -> int:
        """How often the firmware was reset since it was opened (by the watchdog)."""
        return int(self._library.gen_mega_resets(self._open()))

    def symbol(self, name: str) -> Symbol:
        """Look a symbol up by its linker name.

        Raises
        ------
        KeyError
            When the firmware has no such symbol.
        """
        if name not in self._symbols:
            raise KeyError(f"{self._elf.name} has no symbol {name}")
        return self._symbols[name]

    def sram_address(self, name: str) -> int:
        """Give the SRAM address of a variable in bytes, as `peek` and `run_records` take it.

        Raises
        ------
        KeyError
            When the firmware has no such symbol, or it does not lie in SRAM.
        """
        address = self.symbol(name).address - SRAM_OFFSET
        if not 0 <= address < 0x10000:
            raise KeyError(f"{name} of {self._elf.name} does not lie in SRAM")
        return address

    def peek(self, address: int, size: int) -> bytes:
        """Read ``size`` bytes of data memory (registers, I/O, SRAM) without side effects.

        Raises
        ------
        ValueError
            When they lie outside the data memory.
        """
        buffer = (ctypes.c_uint8 * max(size, 1))()
        if min(address, size) < 0 or self._library.gen_mega_peek(self._open(), address, size, buffer):
            raise ValueError(f"{size} bytes at {address:#x} lie outside the data memory")
        return bytes(buffer[:size])

    def poke(self, address: int, data: bytes) -> None:
        """Write bytes into data memory without side effects.

        Raises
        ------
        ValueError
            When they lie outside the data memory.
        """
        if address < 0 or self._library.gen_mega_poke(self._open(), address, len(data), data):
            raise ValueError(f"{len(data)} bytes at {address:#x} lie outside the data memory")

    # ---- running ----

    def run_cycles(self, cycles: int) -> Stop:
        """Run for a number of clock cycles (the last instruction may pass it by a few).

        Returns
        -------
        Stop
            ``LIMIT``, or ``ENDED`` when the firmware executed ``cli`` and ``sleep`` before.

        Raises
        ------
        EmulationFailed
            When the firmware crashed.
        """
        return self._run(self.cycle + cycles, b"")

    def run_seconds(self, seconds: float) -> Stop:
        """Run for a simulated time in seconds; returns and raises as `run_cycles`."""
        return self.run_cycles(round(seconds * FREQUENCY_HZ))

    def run_until_bytes(self, pattern: bytes, max_cycles: int) -> bytes:
        """Run until UART0 has sent ``pattern``; only bytes that were not yet taken with `uart_take` count.

        Parameters
        ----------
        pattern
            1 to 256 bytes.
        max_cycles
            The limit in clock cycles.

        Returns
        -------
        bytes
            All that UART0 sent and that was not yet taken, up to the end of the pattern. It counts as taken.

        Raises
        ------
        EmulationFailed
            When the firmware crashed, ended or reached the limit without sending the pattern.
        """
        if not 1 <= len(pattern) <= 256:
            raise ValueError(f"a pattern has 1 to 256 bytes, not {len(pattern)}")
        stop = self._run(self.cycle + max_cycles, pattern)
        sent = self.uart_take()
        if stop is not Stop.PATTERN:
            why = "ended" if stop is Stop.ENDED else f"ran {max_cycles} cycles"
            raise EmulationFailed(f"the firmware {why} without sending {pattern!r}; it sent {sent[-200:]!r}")
        return sent

    def run_to_end(self, max_cycles: int) -> None:
        """Run until the firmware executes ``cli`` and ``sleep``.

        Raises
        ------
        EmulationFailed
            When the firmware crashed or did not end within ``max_cycles`` clock cycles.
        """
        if self._run(self.cycle + max_cycles, b"") is not Stop.ENDED:
            raise EmulationFailed(f"the firmware did not end within {max_cycles} cycles ({self._place()})")

    def run_to(self, name: str, max_cycles: int) -> None:
        """Run, instruction by instruction, until the firmware reaches a function: to stop before ``main``, say.

        Parameters
        ----------
        name
            Its linker name.
        max_cycles
            The limit in clock cycles.

        Raises
        ------
        KeyError
            When the firmware has no such symbol.
        EmulationFailed
            When the firmware crashed, ended or reached the limit without coming there.
        """
        place = self.symbol(name).address
        stop = Stop(self._library.gen_mega_run_to(self._open(), self.cycle + max_cycles, place))
        if stop is not Stop.PLACE:
            raise EmulationFailed(f"{self._why(stop, max_cycles)}; it should have come to {name}")

    def run_records(
        self,
        inputs: bytes | NDArray[np.generic],
        in_address: int,
        in_size: int,
        out_address: int,
        out_size: int,
        n: int,
        max_cycles: int,
    ) -> tuple[NDArray[np.uint8], NDArray[np.uint32]]:
        """Serve ``n`` records to a harness built with ``mailbox.h``, and collect what it makes of them.

        A later call goes on where the harness stands: its state is kept.

        Parameters
        ----------
        inputs
            ``n * in_size`` bytes, little endian as the board has them.
        in_address, out_address
            SRAM addresses of the input and output variable (`sram_address`).
        in_size, out_size
            Their sizes in bytes.
        n
            The number of records.
        max_cycles
            The limit in clock cycles for all records together.

        Returns
        -------
        outputs
            ``uint8`` of shape ``(n, out_size)``.
        cycles
            ``uint32`` of shape ``(n,)``: clock cycles between the marks, with `MARKER_OVERHEAD`.

        Raises
        ------
        ValueError
            When ``inputs`` has another size.
        EmulationFailed
            When the firmware crashed, ended early, broke the protocol or reached the limit.
        """
        given = inputs if isinstance(inputs, bytes) else np.ascontiguousarray(inputs).tobytes()
        if len(given) != n * in_size:
            raise ValueError(f"{n} records of {in_size} bytes need {n * in_size} bytes, not {len(given)}")
        outputs = np.zeros((n, out_size), dtype=np.uint8)
        cycles = np.zeros(n, dtype=np.uint32)
        done = ctypes.c_uint32()
        stop = Stop(
            self._library.gen_mega_run_records(
                self._open(),
                given,
                in_address,
                in_size,
                outputs.ctypes.data,
                out_address,
                out_size,
                n,
                cycles.ctypes.data,
                self.cycle + max_cycles,
                ctypes.byref(done),
            )
        )
        if stop is not Stop.RECORDS:
            raise EmulationFailed(f"{self._why(stop, max_cycles)}, {done.value} of {n} records done")
        return outputs, cycles

    # ---- UART0 ----

    def uart_take(self) -> bytes:
        """Give the bytes that UART0 sent since the last call."""
        handle = self._open()
        size = int(self._library.gen_mega_uart_available(handle))
        buffer = (ctypes.c_uint8 * max(size, 1))()
        self._library.gen_mega_uart_take(handle, buffer, size)
        self._library.gen_mega_uart_forget(handle)
        return bytes(buffer[:size])

    def uart_send(self, data: bytes, *, byte_cycles: int = _BYTE_CYCLES) -> None:
        """Queue bytes for UART0's receiver; they arrive while the firmware runs.

        As on the board, bytes that arrive before the firmware switched its receiver on are lost.

        Parameters
        ----------
        data
            The bytes.
        byte_cycles
            Clock cycles from one byte to the next.
        """
        if self._library.gen_mega_uart_send(self._open(), data, len(data), byte_cycles):
            raise MemoryError

    # ---- stack ----

    def paint_stack(self) -> None:
        """Fill the RAM between static data (and heap) and the stack pointer with a pattern, for `stack_use`.

        Done once when the emulator is opened; do it again at a later place to measure from there.
        """
        low, high = self._stack_floor(), self.stack_pointer + 1
        self._painted = (low, high)
        if high > low:
            self.poke(low, _canary(low, high).tobytes())

    def stack_use(self) -> StackUse:
        """Measure the deepest stack use since the last `paint_stack`, in bytes.

        What counts is the lowest byte that was *written*, with another value than the paint's: it may err by
        a byte in one case of 256. A frame that is reserved and never written to is not seen.
        """
        low, high = self._painted
        top = int(self._library.gen_mega_ramend(self._open())) + 1
        floor = max(low, self._stack_floor())
        memory = np.frombuffer(self.peek(floor, max(high - floor, 0)), dtype=np.uint8)
        touched = np.flatnonzero(memory != _canary(floor, floor + memory.size))
        lowest = floor + int(touched[0]) if touched.size else max(high, floor)
        return StackUse(deepest=top - lowest, below_paint=high - lowest, free=lowest - floor)

    def _stack_floor(self) -> int:
        floor = self.sram_address("_end")
        if "__brkval" in self._symbols:
            floor = max(floor, int.from_bytes(self.peek(self.sram_address("__brkval"), 2), "little"))
        return floor

    # ---- inner workings ----

    def _open(self) -> int:
        if self._handle is None:
            raise ValueError("the emulator is closed")
        return self._handle

    def _run(self, limit: int, pattern: bytes) -> Stop:
        handle = self._open()
        while True:
            part = min(limit, self.cycle + _SLICE_CYCLES)
            stop = Stop(self._library.gen_mega_run(handle, part, pattern, len(pattern)))
            if stop in (Stop.CRASHED, Stop.PROTOCOL):
                raise EmulationFailed(self._why(stop, 0))
            if stop is not Stop.LIMIT or part == limit:
                return stop

    def _why(self, stop: Stop, max_cycles: int) -> str:
        if stop is Stop.CRASHED:
            return f"the firmware crashed: {self._message()} ({self._place()})"
        if stop is Stop.PROTOCOL:
            return self._message()
        if stop is Stop.ENDED:
            return f"the firmware ended ({self._place()})"
        return f"the firmware ran {max_cycles} cycles without coming to an end ({self._place()})"

    def _message(self) -> str:
        text = bytes(self._library.gen_mega_message(self._open())).decode("utf-8", "replace")
        return re.sub(r"\x1b\[[0-9;]*m", "", text).strip()

    def _place(self) -> str:
        counter = int(self._library.gen_mega_pc(self._open()))
        code = [s for s in self._symbols.values() if s.kind in "TtWw" and s.address <= counter]
        name = f" in {max(code, key=lambda s: s.address).name}" if code else ""
        return f"pc {counter:#x}{name}, sp {self.stack_pointer:#x}, cycle {self.cycle}"


def _canary(low: int, high: int) -> NDArray[np.uint8]:
    """A pattern that differs from byte to byte, so that no constant fill in the firmware can hide in it."""
    address = np.arange(low, high, dtype=np.uint32)
    return ((address * np.uint32(2654435761)) >> np.uint32(24)).astype(np.uint8)
