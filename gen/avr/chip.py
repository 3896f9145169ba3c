"""The chips that are emulated: what the compiler and simavr call them, and what a sketch has of their memories."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Chip:
    """A microcontroller of an Arduino board.

    Parameters
    ----------
    name
        As its data sheet has it.
    mcu
        What avr-gcc and simavr call it.
    define
        The macro by which sources know its board.
    flash_bytes, ram_bytes
        What the board leaves to a sketch: all flash but the boot loader's, and all of the RAM (``upload.maximum_size``
        and ``upload.maximum_data_size`` of the Arduino core's ``boards.txt``; the Mega's RAM from its data sheet).
    eeprom_bytes
        What the EEPROM holds.
    variant
        The Arduino core's folder with the board's pins.
    """

    name: str
    mcu: str
    define: str
    flash_bytes: int
    ram_bytes: int
    eeprom_bytes: int
    variant: str


MEGA = Chip("ATmega2560", "atmega2560", "ARDUINO_AVR_MEGA2560", 253_952, 8_192, 4_096, "mega")
UNO = Chip("ATmega328P", "atmega328p", "ARDUINO_AVR_UNO", 32_256, 2_048, 1_024, "standard")
BOARDS = {"mega": MEGA, "uno": UNO}
"""By the name of the board."""
