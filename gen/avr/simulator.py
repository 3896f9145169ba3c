"""Runs firmware on an emulated ATmega2560, or another chip, at 16 MHz (libsimavr, through the C files in ``shim/``).

Known faults of simavr 1.6 that results inherit: an interrupt is entered in 0 cycles instead of 5, and a byte
takes 11 bit times on UART0 instead of 10. Idle sleep passes in the cycle counter without costing host time.
"""

from __future__ import annotations

import ctypes
from enum import IntEnum
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from gen.avr.chip import MEGA, Chip
from gen.avr.memory import Memory
from gen.avr.shim import EmulationFailed, Handle
from gen.avr.stack import Stack
from gen.avr.uart import Uart

__all__ = ["FREQUENCY_HZ", "MAILBOX_FOLDER", "MARKER_OVERHEAD", "EmulatedChip", "EmulationFailed", "Stop"]

FREQUENCY_HZ = 16_000_000
MARKER_OVERHEAD = 2
"""Cycles that the marks of ``mailbox.h`` add to a step: the OUT of the first and the LDI of the second."""

MAILBOX_FOLDER = Path(__file__).parent
"""The include folder of ``mailbox.h``."""

_SLICE_CYCLES = 400_000_000  # a keyboard interrupt is seen between slices


class Stop(IntEnum):
    """Why a run ended; the numbers are those of ``shim/core.h``."""

    LIMIT = 0
    PATTERN = 1
    ENDED = 2
    CRASHED = 3
    RECORDS = 4
    PROTOCOL = 5
    PLACE = 6


class EmulatedChip:
    """An AVR with a firmware in its flash, just out of reset: an ATmega2560, or another one.

    Parameters
    ----------
    elf
        The firmware, as `gen.avr.compile.build_elf` writes it.
    cache
        The folder that keeps the compiled shim between runs.
    chip
        Another chip than the Mega's.

    Attributes
    ----------
    elf
        The firmware's file.
    memory
        Its data memory, and the firmware's symbols.
    uart
        The outer end of its UART0.
    stack
        How deep the firmware's stack goes.

    Raises
    ------
    ToolMissing
        When gcc, libsimavr or avr-nm are not installed.
    EmulationFailed
        When the ELF file cannot be loaded.
    """

    def __init__(self, elf: Path, cache: Path, chip: Chip = MEGA) -> None:
        self.elf = elf
        self._handle = Handle(elf, cache, chip.mcu)
        self.memory = Memory(self._handle, elf)
        self.uart = Uart(self._handle)
        self.stack = Stack(self._handle, self.memory)
        self.stack.paint()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free the emulator; it cannot be used afterwards. Closing twice does no harm."""
        self._handle.close()

    # ---- time ----

    @property
    def cycle(self) -> int:
        """Clock cycles since the emulator was opened, sleep included; a reset does not set it back."""
        return int(self._handle.call("cycle"))

    @property
    def seconds(self) -> float:
        """Simulated time in seconds since the emulator was opened."""
        return self.cycle / FREQUENCY_HZ

    @property
    def asleep(self) -> int:
        """Clock cycles that the chip spent in a sleep mode since the emulator was opened."""
        return int(self._handle.call("asleep"))

    def longest_awake(self) -> int:
        """Give the longest stretch of clock cycles without sleep since this was asked for last, interrupts included."""
        return int(self._handle.call("longest_awake"))

    @property
    def resets(self) -> int:
        """How often the firmware was reset since it was opened (by the watchdog)."""
        return int(self._handle.call("resets"))

    def let_go_astray(self) -> None:
        """Let a firmware that has gone astray run on, as on a chip, in place of raising `EmulationFailed`.

        From now on an access behind the end of a memory finds or leaves a byte that nothing else uses, an instruction
        that is none does nothing, the program counter wraps, and sleep without interrupts lasts until the watchdog
        ends it. What a chip does with an instruction that is none, its data sheet does not say.
        """
        self._handle.call("astray")

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
        """Run until UART0 has sent ``pattern``; only bytes that were not yet taken from `uart` count.

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
        sent = self.uart.take()
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
        place = self.memory.symbol(name).address
        stop = Stop(self._handle.call("run_to", self.cycle + max_cycles, place))
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
            SRAM addresses of the input and output variable (`Memory.address`).
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
            self._handle.call(
                "run_records",
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

    # ---- inner workings ----

    def _run(self, limit: int, pattern: bytes) -> Stop:
        while True:
            part = min(limit, self.cycle + _SLICE_CYCLES)
            stop = Stop(self._handle.call("run", part, pattern, len(pattern)))
            if stop in (Stop.CRASHED, Stop.PROTOCOL):
                raise EmulationFailed(self._why(stop, 0))
            if stop is not Stop.LIMIT or part == limit:
                return stop

    def _why(self, stop: Stop, max_cycles: int) -> str:
        if stop is Stop.CRASHED:
            return f"the firmware crashed: {self._handle.message()} ({self._place()})"
        if stop is Stop.PROTOCOL:
            return self._handle.message()
        if stop is Stop.ENDED:
            return f"the firmware ended ({self._place()})"
        return f"the firmware ran {max_cycles} cycles without coming to an end ({self._place()})"

    def _place(self) -> str:
        counter = int(self._handle.call("pc"))
        code = [s for s in self.memory.symbols.values() if s.kind in "TtWw" and s.address <= counter]
        name = f" in {max(code, key=lambda s: s.address).name}" if code else ""
        return f"pc {counter:#x}{name}, sp {self.stack.pointer:#x}, cycle {self.cycle}"
