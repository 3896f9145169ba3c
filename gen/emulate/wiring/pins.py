"""The boards' pin numbers: where each lies on the chip, and which timer makes its PWM.

The maps are the emulator's own, not those that the generator has for the firmware (`gen.firmware.boards`): a wrong pin
in one of them then shows as a sensor that does not answer. A test compares these with the Arduino core's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class PortPin:
    """A pin as the chip names it: port ``A``..``L`` and bit 0..7."""

    port: str
    bit: int

    def __str__(self) -> str:
        return f"P{self.port}{self.bit}"


@dataclass(frozen=True)
class CompareOutput:
    """The timer output behind a PWM pin; addresses are data addresses.

    Parameters
    ----------
    control
        TCCRnA, which holds this output's COM bits (and TCCRnB is the byte behind it).
    com_shift
        Place of the COM bits in it: 6 for A, 4 for B, 2 for C.
    compare
        OCRnx, low byte.
    wide
        Whether the timer has 16 bits.
    """

    control: int
    com_shift: int
    compare: int
    wide: bool


# Timer -> TCCRnA, {output: OCRnx} (data sheets of the ATmega2560, section 33, and of the ATmega328P, section 36, which
# has the first three at the same places).
_TIMERS = {
    0: (0x44, {"A": 0x47, "B": 0x48}),
    1: (0x80, {"A": 0x88, "B": 0x8A, "C": 0x8C}),
    2: (0xB0, {"A": 0xB3, "B": 0xB4}),
    3: (0x90, {"A": 0x98, "B": 0x9A, "C": 0x9C}),
    4: (0xA0, {"A": 0xA8, "B": 0xAA, "C": 0xAC}),
    5: (0x120, {"A": 0x128, "B": 0x12A, "C": 0x12C}),
}
_ICR_OFFSET = 6  # ICRn lies 6 bytes behind TCCRnA in every 16-bit timer


@dataclass(frozen=True)
class PinMap:
    """The pins of a board.

    Parameters
    ----------
    board
        Its name, for people.
    ports
        Port and bit of each Arduino pin, in order.
    first_analog
        A0.
    outputs
        Arduino pin to timer and output.
    """

    board: str
    ports: tuple[str, ...]
    first_analog: int
    outputs: Mapping[int, str]

    def port_pin(self, pin: int) -> PortPin:
        """Give the port and bit of an Arduino pin number.

        Raises
        ------
        ValueError
            When the board has no such pin.
        """
        if not 0 <= pin < len(self.ports):
            raise ValueError(f"the Arduino {self.board} has no pin {pin}; expected 0..{len(self.ports) - 1}")
        return PortPin(self.ports[pin][0], int(self.ports[pin][1]))

    def compare_output(self, pin: int) -> CompareOutput | None:
        """Give the timer output of an Arduino pin, None when it has no PWM."""
        if pin not in self.outputs:
            return None
        timer, output = int(self.outputs[pin][0]), self.outputs[pin][1]
        control, compares = _TIMERS[timer]
        return CompareOutput(control, {"A": 6, "B": 4, "C": 2}[output], compares[output], timer not in (0, 2))

    def analog_input(self, pin: int) -> int:
        """Give the converter's input of an Arduino pin.

        Raises
        ------
        ValueError
            When it is none of the emulator's.
        """
        inputs = min(len(self.ports) - self.first_analog, _MOST_INPUTS)
        if not 0 <= pin - self.first_analog < inputs:
            raise ValueError(f"pin {pin}: the emulator's converter has A0..A{inputs - 1} only")
        return pin - self.first_analog


_MOST_INPUTS = 8
"""simavr's converter of the ATmega2560 has no A8..A15."""
_MEGA = PinMap(
    "Mega",
    (  # schematic of the Arduino Mega 2560, revision 3: digital pins 0..53, then A0..A15
        *("E0", "E1", "E4", "E5", "G5", "E3", "H3", "H4", "H5", "H6"),
        *("B4", "B5", "B6", "B7", "J1", "J0", "H1", "H0", "D3", "D2"),
        *("D1", "D0", "A0", "A1", "A2", "A3", "A4", "A5", "A6", "A7"),
        *("C7", "C6", "C5", "C4", "C3", "C2", "C1", "C0", "D7", "G2"),
        *("G1", "G0", "L7", "L6", "L5", "L4", "L3", "L2", "L1", "L0"),
        *("B3", "B2", "B1", "B0", "F0", "F1", "F2", "F3", "F4", "F5"),
        *("F6", "F7", "K0", "K1", "K2", "K3", "K4", "K5", "K6", "K7"),
    ),
    54,
    {  # pin 13 has two outputs; the core's analogWrite uses 0A
        **{2: "3B", 3: "3C", 4: "0B", 5: "3A", 6: "4A", 7: "4B", 8: "4C", 9: "2B", 10: "2A", 11: "1A", 12: "1B"},
        **{13: "0A", 44: "5C", 45: "5B", 46: "5A"},
    },
)
_UNO = PinMap(
    "Uno",
    (  # schematic of the Arduino Uno, revision 3: digital pins 0..13, then A0..A5
        *("D0", "D1", "D2", "D3", "D4", "D5", "D6", "D7"),
        *("B0", "B1", "B2", "B3", "B4", "B5"),
        *("C0", "C1", "C2", "C3", "C4", "C5"),
    ),
    14,
    {3: "2B", 5: "0B", 6: "0A", 9: "1A", 10: "1B", 11: "2A"},
)
PIN_MAPS: Mapping[str, PinMap] = {"mega": _MEGA, "uno": _UNO}
"""By the name that the coefficient file has for the board."""


def duty(output: CompareOutput, registers: bytes) -> float | None:
    """Give the share of time that a timer keeps its pin high, None when the timer does not drive it.

    Parameters
    ----------
    output
        Which output.
    registers
        Data memory from ``output.control`` on, at least 14 bytes.

    Notes
    -----
    Only the non-inverting mode and the inverting one (COM = 2, 3) are PWM; the pin is high for OCR of TOP counts in the
    phase-correct modes and OCR + 1 of TOP + 1 in the fast ones (data sheet, sections 16.7 and 17.9).
    """
    control_a, control_b = registers[0], registers[1]
    com = control_a >> output.com_shift & 3
    if com < 2 or not control_b & 7:
        return None
    at = output.compare - output.control
    compare = registers[at] | (registers[at + 1] << 8 if output.wide else 0)
    mode = control_a & 3 | (control_b >> 3 & (3 if output.wide else 1)) << 2
    top, fast = _wide_top(mode, registers) if output.wide else _narrow_top(mode, registers)
    if top is None:
        return None
    share = (min(compare, top) + 1) / (top + 1) if fast else min(compare, top) / top
    return share if com == 2 else 1.0 - share


def _narrow_top(mode: int, registers: bytes) -> tuple[int | None, bool]:
    compare_a = registers[3]
    return {1: (255, False), 3: (255, True), 5: (compare_a or 1, False), 7: (compare_a or 1, True)}.get(
        mode, (None, False)
    )


def _wide_top(mode: int, registers: bytes) -> tuple[int | None, bool]:
    capture = registers[_ICR_OFFSET] | registers[_ICR_OFFSET + 1] << 8
    compare_a = registers[8] | registers[9] << 8
    fixed = {1: 255, 2: 511, 3: 1023, 5: 255, 6: 511, 7: 1023}
    if mode in fixed:
        return fixed[mode], mode >= 5
    if mode in (8, 10, 14):
        return capture or 1, mode == 14
    if mode in (9, 11, 15):
        return compare_a or 1, mode == 15
    return None, False
