"""The Mega with the world at its pins: levels, probes, MAX6675s, an encoder, EEPROM contents, loss of power."""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass
from enum import IntFlag

import numpy as np
from numpy.typing import NDArray

from gen.avr.simulator import FREQUENCY_HZ, EmulatedMega
from gen.emulate.pins import compare_output, duty, port_pin

CONVERSION_S = 0.22
"""Longest conversion of a MAX6675 by its data sheet, s (0.17 s is typical): the hardest case for the firmware."""

_FULL = 255
_WAVE_HZ = 490.2  # the core's analogWrite on most pins: 16 MHz / 64 / 510


class ResetCause(IntFlag):
    """The bits of MCUSR."""

    POWER_ON = 1
    EXTERNAL = 2
    BROWN_OUT = 4
    WATCHDOG = 8


@dataclass(frozen=True)
class Edges:
    """Changes of a pin: ``cycles`` (uint64) and the ``levels`` (bool) from then on, both of shape (N,)."""

    cycles: NDArray[np.uint64]
    levels: NDArray[np.bool_]

    @property
    def seconds(self) -> NDArray[np.float64]:
        """Simulated time of each change, s."""
        return self.cycles / FREQUENCY_HZ


@dataclass(frozen=True)
class ChipCounts:
    """What a MAX6675 went through.

    Parameters
    ----------
    reads
        Falling edges of its CS.
    early
        Those before a conversion had finished: they gave the old word.
    clashes
        Those while another chip drove the same SO line.
    """

    reads: int
    early: int
    clashes: int


@dataclass(frozen=True)
class EepromCounts:
    """Writes begun, and accesses that the chip refused because a write was under way."""

    writes: int
    refused: int


class DeviceMega(EmulatedMega):
    """An emulated Mega whose pins are reached by their Arduino numbers.

    All methods raise ValueError for a pin that the Mega does not have.
    """

    # ---- pins ----

    def drive_pin(self, pin: int, level: bool | None) -> None:
        """Put a level on a pin from outside; None lets go of it (a pull-up of the firmware then acts)."""
        place = port_pin(pin)
        level_code = -1 if level is None else int(level)
        self._library.gen_mega_pin_drive(self._open(), place.port.encode(), place.bit, level_code)

    def drive_analog(self, pin: int, volts: float) -> None:
        """Put a voltage, 0..5 V, on an analog pin, 54..69."""
        if not 54 <= pin <= 69:
            raise ValueError(f"pin {pin} has no converter")
        self._library.gen_mega_adc(self._open(), pin - 54, round(min(max(volts, 0.0), 5.0) * 1000.0))

    def pin_level(self, pin: int) -> bool:
        """Give a pin's level at present (of a running PWM: the port's latch, see `pin_duty`)."""
        return bool(self._pin(pin) & 1)

    def pin_is_output(self, pin: int) -> bool:
        """Whether the firmware drives the pin."""
        return bool(self._pin(pin) & 2)

    def pin_duty(self, pin: int) -> float:
        """Give the share of time for which the firmware keeps the pin high, 0..1: its PWM, or its level."""
        if not self.pin_is_output(pin):
            return 0.0
        output = compare_output(pin)
        share = duty(output, self.peek(output.control, 14)) if output is not None else None
        return float(self.pin_level(pin)) if share is None else share

    def pin_pwm(self, forward: int, reverse: int) -> int:
        """Give the signed PWM, -255..255, on the two pins of a motor driver."""
        return round(_FULL * (self.pin_duty(forward) - self.pin_duty(reverse)))

    def pin_signed_pwm(self, pwm: int, direction: int, *, forward_level: bool = True) -> int:
        """Give the signed PWM, -255..255, on a motor driver's PWM pin and direction pin.

        Parameters
        ----------
        pwm, direction
            The pins.
        forward_level
            Level of ``direction`` for PWM > 0.
        """
        size = round(_FULL * self.pin_duty(pwm))
        return size if self.pin_level(direction) == forward_level else -size

    def add_probe(self, pin: int) -> int:
        """Record every change of a pin from now on; give the probe's number for `probe`."""
        place = port_pin(pin)
        number = int(self._library.gen_mega_probe_add(self._open(), place.port.encode(), place.bit))
        if number < 0:
            raise ValueError("the emulator has no probe left")
        return number

    def probe(self, number: int) -> Edges:
        """Give all changes that a probe has seen."""
        size = int(self._library.gen_mega_probe_length(self._open(), number))
        cycles, levels = np.zeros(size, dtype=np.uint64), np.zeros(size, dtype=np.uint8)
        self._library.gen_mega_probe_copy(self._open(), number, 0, size, cycles.ctypes.data, levels.ctypes.data)
        return Edges(cycles, levels.astype(np.bool_))

    def _pin(self, pin: int) -> int:
        place = port_pin(pin)
        return int(self._library.gen_mega_pin_read(self._open(), place.port.encode(), place.bit))

    # ---- MAX6675 ----

    def add_max6675(self, cs: int, so: int, sck: int, *, conversion_s: float = CONVERSION_S) -> int:
        """Connect a MAX6675; give its number for `set_word`. SO and SCK may be shared with others."""
        lines = [port_pin(pin) for pin in (cs, so, sck)]
        arguments = [part for line in lines for part in (line.port.encode(), line.bit)]
        cycles = round(conversion_s * FREQUENCY_HZ)
        number = int(self._library.gen_mega_chip_add(self._open(), *arguments, cycles))
        if number < 0:
            raise ValueError("the emulator has no MAX6675 left")
        return number

    def set_word(self, number: int, word: int) -> None:
        """Let a MAX6675's conversions give a 16-bit word from now on."""
        if not 0 <= word <= 0xFFFF or self._library.gen_mega_chip_word(self._open(), number, word):
            raise ValueError(f"word {word} for MAX6675 {number}: expected 0..65535 and a number from add_max6675")

    def chip_counts(self, number: int) -> ChipCounts:
        """Count a MAX6675's reads."""
        counts = [ctypes.c_uint32() for _ in range(3)]
        if self._library.gen_mega_chip_counts(self._open(), number, *map(ctypes.byref, counts)):
            raise ValueError(f"there is no MAX6675 {number}")
        return ChipCounts(*(count.value for count in counts))

    # ---- encoder, and another controller's PWM ----

    def attach_encoder(self, pin: int, *, batch_s: float = 0.0) -> None:
        """Connect the encoder (one).

        Parameters
        ----------
        pin
            Where.
        batch_s
            0: every pulse comes at its own time. Else the interrupts of the pulses that fall due within this time, s,
            are raised together at its end, each when the firmware has taken the one before: as many, and each handled
            by the firmware, but not spaced as on the motor, with the pin at rest, and none can be lost. It spares the
            firmware a return to sleep for every pulse, and the emulator most of its work. On pin 47 (the input of
            Timer 5) it plays no role: the count is exact at every read.
        """
        place = port_pin(pin)
        batch = round(batch_s * FREQUENCY_HZ)
        self._library.gen_mega_encoder_attach(self._open(), place.port.encode(), place.bit, batch)

    def send_pulses(self, count: int, seconds: float) -> None:
        """Let the encoder give pulses within the time that comes; what an earlier call left over is dropped."""
        cycles = round(seconds * FREQUENCY_HZ)
        if count < 0 or self._library.gen_mega_encoder_pulses(self._open(), count, cycles):
            raise ValueError(
                f"{count} pulses in {seconds:g} s: expected an attached encoder and at least 4 cycles each"
            )

    @property
    def pulses_sent(self) -> int:
        """Rising edges that the encoder gave so far."""
        return int(self._library.gen_mega_encoder_risen(self._open()))

    def drive_wave(self, pin: int, share: float, *, frequency_hz: float = _WAVE_HZ) -> None:
        """Put a PWM signal on a pin, as another controller would: high for a share 0..1 of each period.

        Two pins at most have one.
        """
        place = port_pin(pin)
        period = round(FREQUENCY_HZ / frequency_hz)
        high = min(max(round(share * period), 0), period)
        self._library.gen_mega_wave(self._open(), place.port.encode(), place.bit, period, high)

    # ---- EEPROM and power ----

    @property
    def eeprom(self) -> bytes:
        """The EEPROM's 4096 bytes; assign to load an image."""
        size = int(self._library.gen_mega_eeprom_size(self._open()))
        buffer = (ctypes.c_uint8 * size)()
        self._library.gen_mega_eeprom_save(self._open(), buffer)
        return bytes(buffer)

    @eeprom.setter
    def eeprom(self, image: bytes) -> None:
        size = int(self._library.gen_mega_eeprom_size(self._open()))
        if len(image) != size:
            raise ValueError(f"an EEPROM image has {size} bytes, not {len(image)}")
        self._library.gen_mega_eeprom_load(self._open(), image)

    @property
    def eeprom_busy(self) -> bool:
        """Whether the chip is writing a byte of its EEPROM."""
        return bool(self._library.gen_mega_eeprom_busy(self._open()))

    @property
    def eeprom_counts(self) -> EepromCounts:
        """What the firmware did with the EEPROM."""
        counts = [ctypes.c_uint32() for _ in range(2)]
        self._library.gen_mega_eeprom_counts(self._open(), *map(ctypes.byref, counts))
        return EepromCounts(*(count.value for count in counts))

    def cut_power(self, off_s: float, *, cause: ResetCause = ResetCause.POWER_ON, seed: int = 1) -> None:
        """Take the power away for a time, and give it back.

        The SRAM holds noise afterwards; an EEPROM byte in writing is half done.

        Parameters
        ----------
        off_s
            How long, s; simulated time goes on.
        cause
            What MCUSR says afterwards: ``POWER_ON``, or ``BROWN_OUT`` when the supply only sagged.
        seed
            Chooses the noise.
        """
        cycles = math.ceil(off_s * FREQUENCY_HZ)
        self._library.gen_mega_reset(self._open(), int(cause), 1, cycles, seed)

    def press_reset(self) -> None:
        """Press the board's reset button: the SRAM keeps what it holds."""
        self._library.gen_mega_reset(self._open(), int(ResetCause.EXTERNAL), 0, 0, 0)

    def start_clock_at(self, milliseconds: int) -> None:
        """Let the Arduino core's ``millis()`` start at a value, near 2**32 to see it roll over.

        To be called before the firmware runs: it runs up to ``main``, where static data have been set.
        """
        self.run_to("main", FREQUENCY_HZ)
        self._set_millis(milliseconds)

    def hold_up(self, milliseconds: int) -> None:
        """Let ``millis()`` jump ahead, as if the firmware's loop had been held up for so long."""
        address = self.sram_address("timer0_millis")
        self._set_millis(int.from_bytes(self.peek(address, 4), "little") + milliseconds)

    def _set_millis(self, milliseconds: int) -> None:
        self.poke(self.sram_address("timer0_millis"), (milliseconds % 2**32).to_bytes(4, "little"))
