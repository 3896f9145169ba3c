"""The boards that a sketch can be for: where their numbered pins lie, what serves them, and what they are built with.

Pinouts of the Arduino Mega 2560 and Uno (revision 3); registers and memories by the data sheets of the ATmega2560 and
the ATmega328P.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from gen.coefficients.wiring import BoardName


@dataclass(frozen=True)
class Board:
    """One board.

    Attributes
    ----------
    name
        For people: "Mega".
    title
        The same in full.
    chip
        As its data sheet has it.
    mcu
        What simavr calls it.
    platformio
        What PlatformIO calls the board.
    letters, bits
        Port letter and bit of the pins, by their number.
    first_analog
        A0.
    interrupts
        External interrupt of a pin.
    pwm_timers
        Timer that makes a pin's PWM. Timer 0 also keeps the core's time.
    timers
        All others, with what switches each off: register and bit.
    converter
        The converter, likewise.
    unused
        What nothing needs: register and bit.
    bandgap_mux
        ADMUX's bits for the reference of 1.1 V.
    upper_inputs
        Whether the converter has inputs behind the first eight pins.
    far_flash
        Whether some of the flash lies beyond 64 KB.
    eeprom_bytes
        What the EEPROM holds.
    stack_reserve
        Bytes of RAM that the self test wants never to have been touched.
    """

    name: str
    title: str
    chip: str
    mcu: str
    platformio: str
    letters: str
    bits: str
    first_analog: int
    interrupts: Mapping[int, int]
    pwm_timers: Mapping[int, int]
    timers: Mapping[int, tuple[str, str]]
    converter: tuple[str, str]
    unused: tuple[tuple[str, str], ...]
    bandgap_mux: int
    upper_inputs: bool
    far_flash: bool
    eeprom_bytes: int
    stack_reserve: int

    def port_bit(self, pin: int) -> tuple[str, int]:
        """Port letter and bit of an Arduino pin."""
        return self.letters[pin], int(self.bits[pin])

    def label(self, pin: int) -> str:
        """The pin's name as printed on the board: 22 or A0."""
        return f"A{pin - self.first_analog}" if pin >= self.first_analog else str(pin)

    def mux(self, pin: int) -> int:
        """MUX5..MUX0 of an analog pin: the first eight are 0..7, A8..A15 of the Mega 32..39."""
        number = pin - self.first_analog
        return number if number < 8 else 0x20 | number & 7


MEGA = Board(
    name="Mega",
    title="Arduino Mega 2560",
    chip="ATmega2560",
    mcu="atmega2560",
    platformio="megaatmega2560",
    letters="EEEEGEHHHHBBBBJJHHDDDDAAAAAAAACCCCCCCCDGGGLLLLLLLLBBBBFFFFFFFFKKKKKKKK",
    bits="0145533456456710103210012345677654321072107654321032100123456701234567",
    first_analog=54,
    interrupts={2: 4, 3: 5, 18: 3, 19: 2, 20: 1, 21: 0},
    pwm_timers={2: 3, 3: 3, 4: 0, 5: 3, 6: 4, 7: 4, 8: 4, 9: 2, 10: 2, 11: 1, 12: 1, 13: 0, 44: 5, 45: 5, 46: 5},
    timers={
        1: ("PRR0", "PRTIM1"),
        2: ("PRR0", "PRTIM2"),
        3: ("PRR1", "PRTIM3"),
        4: ("PRR1", "PRTIM4"),
        5: ("PRR1", "PRTIM5"),
    },
    converter=("PRR0", "PRADC"),
    unused=(
        ("PRR0", "PRTWI"),
        ("PRR0", "PRSPI"),
        ("PRR1", "PRUSART1"),
        ("PRR1", "PRUSART2"),
        ("PRR1", "PRUSART3"),
    ),
    bandgap_mux=0x1E,
    upper_inputs=True,
    far_flash=True,
    eeprom_bytes=4096,
    stack_reserve=512,
)
UNO = Board(
    name="Uno",
    title="Arduino Uno",
    chip="ATmega328P",
    mcu="atmega328p",
    platformio="uno",
    letters="DDDDDDDDBBBBBBCCCCCC",
    bits="01234567012345012345",
    first_analog=14,
    interrupts={2: 0, 3: 1},
    pwm_timers={3: 2, 5: 0, 6: 0, 9: 1, 10: 1, 11: 2},
    timers={1: ("PRR", "PRTIM1"), 2: ("PRR", "PRTIM2")},
    converter=("PRR", "PRADC"),
    unused=(("PRR", "PRTWI"), ("PRR", "PRSPI")),
    bandgap_mux=0x0E,
    upper_inputs=False,
    far_flash=False,
    eeprom_bytes=1024,
    stack_reserve=128,
)
BOARDS: Mapping[BoardName, Board] = {"mega": MEGA, "uno": UNO}

#: TCCRnB with which a PWM timer makes 8-bit phase-correct PWM of about so many Hz: clock / 64 (as the Arduino core
#: lets it run), / 8 and / 1, over 510 counts.
TIMER_RUNS = {
    490: {
        1: "_BV(CS11) | _BV(CS10)",
        2: "_BV(CS22)",
        3: "_BV(CS31) | _BV(CS30)",
        4: "_BV(CS41) | _BV(CS40)",
        5: "_BV(CS51) | _BV(CS50)",
    },
    3922: {timer: f"_BV(CS{timer}1)" for timer in range(1, 6)},
    31373: {timer: f"_BV(CS{timer}0)" for timer in range(1, 6)},
}
