"""A board with the world at its pins: `levels`, `max6675`, `pulses`, `eeprom`; losses of power and the clock here."""

from __future__ import annotations

import math
from enum import IntFlag
from pathlib import Path

from gen.avr.chip import BOARDS
from gen.avr.simulator import FREQUENCY_HZ, EmulatedChip
from gen.coefficients.wiring import BoardName, ChipName
from gen.emulate.wiring.divider import Divider
from gen.emulate.wiring.eeprom import Eeprom
from gen.emulate.wiring.levels import Pins
from gen.emulate.wiring.max6675 import CONVERSION_S, Max6675
from gen.emulate.wiring.pins import PIN_MAPS, PortPin
from gen.emulate.wiring.pulses import EncoderPulses
from gen.emulate.wiring.registers import RegisterChip

MAX31855_S = 0.1
"""Longest conversion of a MAX31855 by its data sheet, s."""


class ResetCause(IntFlag):
    """The bits of MCUSR."""

    POWER_ON = 1
    EXTERNAL = 2
    BROWN_OUT = 4
    WATCHDOG = 8


class DeviceBoard(EmulatedChip):
    """An emulated Mega, or Uno, whose pins are reached by their Arduino numbers.

    Parameters
    ----------
    elf, cache
        See `EmulatedChip`.
    board
        As the coefficient file names it.

    Attributes
    ----------
    pins
        Levels, voltages and signals at its pins.
    encoder
        The pulses of an encoder.
    eeprom
        What it keeps without power.
    """

    def __init__(self, elf: Path, cache: Path, board: BoardName = "mega") -> None:
        super().__init__(elf, cache, BOARDS[board])
        self._map = PIN_MAPS[board]
        self.pins = Pins(self._handle, self.memory, self._map)
        self.encoder = EncoderPulses(self._handle, self._map)
        self.eeprom = Eeprom(self._handle)
        self._dividers: list[Divider] = []

    def add_max6675(self, cs: int, so: int, sck: int, *, conversion_s: float = CONVERSION_S) -> Max6675:
        """Connect a MAX6675 to three pins; raises as `Max6675`."""
        return Max6675(self._handle, self._places(cs, so, sck), conversion_s=conversion_s)

    def add_chip(
        self,
        chip: ChipName,
        cs: int | None,
        so: int | None,
        sck: int | None,
        sdi: int | None = None,
        analog: int | None = None,
    ) -> Max6675 | RegisterChip | Divider:
        """Connect a sensor of any kind: its chip's lines, or a thermistor's pin; raises as `Max6675`."""
        if chip == "NTC":
            assert analog is not None
            self._dividers.append(Divider(self._handle, self._map.analog_input(analog)))
            return self._dividers[-1]
        assert cs is not None and so is not None and sck is not None
        if chip == "MAX6675":
            return self.add_max6675(cs, so, sck)
        if chip == "MAX31855":
            return Max6675(self._handle, self._places(cs, so, sck), conversion_s=MAX31855_S, bits=32)
        assert sdi is not None
        return RegisterChip(self._handle, chip, self._places(cs, so, sck, sdi))

    def _places(self, *pins: int) -> list[PortPin]:
        return [self._map.port_pin(pin) for pin in pins]

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
        self._handle.call("reset", int(cause), 1, cycles, seed)

    def press_reset(self, *, cause: ResetCause = ResetCause.EXTERNAL) -> None:
        """Press the board's reset button: the SRAM keeps what it holds.

        Parameters
        ----------
        cause
            What MCUSR says afterwards; none when a boot loader has cleared it.
        """
        self._handle.call("reset", int(cause), 0, 0, 0)

    def run_watchdog_at(self, hertz: int) -> None:
        """Let the watchdog's own oscillator run so fast, from when the firmware sets the watchdog next on.

        Parameters
        ----------
        hertz
            Of the oscillator; 128 000 until told otherwise. That the clock is off looks the same to the firmware.
        """
        self._handle.call("watchdog_hz", hertz)

    def supply_with(self, volts: float, *, reference_V: float = 1.1) -> None:
        """Give the chip another supply, from now on; it computes on as ever, only its converter sees it.

        Parameters
        ----------
        volts
            5 until told otherwise.
        reference_V
            What this chip's own reference has.

        Raises
        ------
        ValueError
            Where there is no supply, or a reference of 8 V or more.
        """
        if volts <= 0.0 or self._handle.call("supply", round(volts * 1000.0), round(reference_V * 1000.0)):
            raise ValueError(f"no chip has a supply of {volts:g} V and a reference of {reference_V:g} V")
        for divider in self._dividers:
            divider.supply_with(volts)

    def add_boot_loader(self, program: bytes, address: int = 0x3E000) -> None:
        """Put a boot loader into flash: resets, and the first start, go there.

        Parameters
        ----------
        program
            Its bytes.
        address
            Where they begin; a Mega's is of 8 KB at the end.

        Raises
        ------
        ValueError
            Where it does not fit.
        """
        if self._handle.call("boot_loader", address, program, len(program)):
            raise ValueError(f"a boot loader of {len(program)} bytes does not fit at {address:#x}")

    def start_clock_at(self, milliseconds: int) -> None:
        """Let the Arduino core's ``millis()`` start at a value, near 2**32 to see it roll over.

        To be called before the firmware runs: it runs up to ``main``, where static data have been set.
        """
        self.run_to("main", FREQUENCY_HZ)
        self._set_millis(milliseconds)

    def hold_up(self, milliseconds: int) -> None:
        """Let ``millis()`` jump ahead, as if the firmware's loop had been held up for so long."""
        self._set_millis(self.memory.peek_int("timer0_millis", 4) + milliseconds)

    def _set_millis(self, milliseconds: int) -> None:
        self.memory.poke(self.memory.address("timer0_millis"), (milliseconds % 2**32).to_bytes(4, "little"))
