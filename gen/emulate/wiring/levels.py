"""Levels that the world puts on the board's pins and levels that it sees there, by their Arduino numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import BoolArray, FloatArray
from gen.avr.memory import Memory
from gen.avr.shim import Handle
from gen.avr.simulator import FREQUENCY_HZ
from gen.emulate.plants.plant import FULL_PWM
from gen.emulate.wiring.pins import PinMap, duty

_WAVE_HZ = 490.2  # the core's analogWrite on most pins: 16 MHz / 64 / 510


@dataclass(frozen=True)
class Edges:
    """Changes of a pin: ``cycles`` (uint64) and the ``levels`` (bool) from then on, both of shape (N,)."""

    cycles: NDArray[np.uint64]
    levels: BoolArray

    @property
    def seconds(self) -> FloatArray:
        """Simulated time of each change, s."""
        return self.cycles / FREQUENCY_HZ


class Probe:
    """Watches a pin from when `Pins.watch` made it."""

    def __init__(self, handle: Handle, number: int) -> None:
        self._handle = handle
        self._number = number

    def edges(self) -> Edges:
        """Give all changes so far."""
        return self.latest(int(self._handle.call("probe_length", self._number)))

    def latest(self, most: int) -> Edges:
        """Give the last changes, no more than so many."""
        length = int(self._handle.call("probe_length", self._number))
        size = min(most, length)
        cycles, levels = np.zeros(size, dtype=np.uint64), np.zeros(size, dtype=np.uint8)
        self._handle.call("probe_copy", self._number, length - size, size, cycles.ctypes.data, levels.ctypes.data)
        return Edges(cycles, levels.astype(np.bool_))


class Pins:
    """The pins of an open emulator.

    All methods raise ValueError for a pin that the board does not have.

    Parameters
    ----------
    handle
        The emulator.
    memory
        Its memory: the timers' registers tell the PWM.
    pins
        The board's.
    """

    def __init__(self, handle: Handle, memory: Memory, pins: PinMap) -> None:
        self._handle = handle
        self._map = pins
        self._memory = memory

    # ---- from outside ----

    def drive(self, pin: int, level: bool | None) -> None:
        """Put a level on a pin; None lets go of it (a pull-up of the firmware then acts)."""
        self._call("pin_drive", pin, -1 if level is None else int(level))

    def drive_analog(self, pin: int, volts: float) -> None:
        """Put a voltage, 0..5 V, on an analog pin."""
        self._handle.call("adc", self._map.analog_input(pin), round(min(max(volts, 0.0), 5.0) * 1000.0))

    def drive_wave(self, pin: int, share: float, *, frequency_hz: float = _WAVE_HZ) -> None:
        """Put a PWM signal on a pin, as another controller would: high for a share 0..1 of each period.

        Two pins at most have one.
        """
        period = round(FREQUENCY_HZ / frequency_hz)
        self._call("wave", pin, period, min(max(round(share * period), 0), period))

    # ---- from inside ----

    def level(self, pin: int) -> bool:
        """Give a pin's level at present (of a running PWM: the port's latch, see `duty`)."""
        return bool(self._call("pin_read", pin) & 1)

    def is_output(self, pin: int) -> bool:
        """Whether the firmware drives the pin."""
        return bool(self._call("pin_read", pin) & 2)

    def duty(self, pin: int) -> float:
        """Give the share of time for which the firmware keeps the pin high, 0..1: its PWM, or its level."""
        if not self.is_output(pin):
            return 0.0
        output = self._map.compare_output(pin)
        share = duty(output, self._memory.peek(output.control, 14)) if output is not None else None
        return float(self.level(pin)) if share is None else share

    def pwm(self, forward: int, reverse: int) -> int:
        """Give the signed PWM, -255..255, on the two pins of a motor driver."""
        return round(FULL_PWM * (self.duty(forward) - self.duty(reverse)))

    def signed_pwm(self, pwm: int, direction: int, *, forward_level: bool = True) -> int:
        """Give the signed PWM, -255..255, on a motor driver's PWM pin and direction pin.

        Parameters
        ----------
        pwm, direction
            The pins.
        forward_level
            Level of ``direction`` for PWM > 0.
        """
        size = round(FULL_PWM * self.duty(pwm))
        return size if self.level(direction) == forward_level else -size

    def watch(self, pin: int) -> Probe:
        """Record every change of a pin from now on."""
        number = int(self._call("probe_add", pin))
        if number < 0:
            raise ValueError("the emulator has no probe left")
        return Probe(self._handle, number)

    def _call(self, name: str, pin: int, *arguments: int) -> Any:  # noqa: ANN401
        place = self._map.port_pin(pin)
        return self._handle.call(name, place.port.encode(), place.bit, *arguments)
