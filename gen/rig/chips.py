"""What converter chips send for a temperature, by their data sheets.

MAX6675 (table 2): bit 15 is 0, bits 14..3 are the temperature in quarters of a degree, bit 2 tells an open
thermocouple, bit 1 (device identity) is 0 and bit 0 leaves the line floating, read 0. MAX31855 (tables 2 to 4): 14 bits
of quarters of a degree with sign, 0, fault; 12 bits of the chip's own temperature in sixteenths, 0, shorted to VCC,
shorted to GND, open. MAX31856: 19 bits of 1/128 of a degree in 24, then its fault register. MAX31865: configuration,
then the ratio of the resistors in 15 bits, and fault.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

OPEN_BIT = 0x0004


@dataclass(frozen=True)
class Converter:
    """A chip between sensor and board.

    Attributes
    ----------
    kind
        MAX6675, MAX31855, MAX31856 or MAX31865.
    platinum_ohm, reference_ohm
        Of a MAX31865: the resistor at 0 degC, and what it is compared with.
    three_wires
        Of a MAX31865: whether it is told so.
    """

    kind: str = "MAX6675"
    platinum_ohm: float = 100.0
    reference_ohm: float = 430.0
    three_wires: bool = False

    def __post_init__(self) -> None:
        if self.kind not in _WORDS:
            raise ValueError(f"unknown converter {self.kind!r}; expected one of {', '.join(_WORDS)}")

    def word(self, shown_degC: float, own_degC: float, is_open: bool) -> int:
        """Give what it sends for a temperature.

        Parameters
        ----------
        shown_degC
            What its sensor says, with all errors.
        own_degC
            The chip's temperature.
        is_open
            Whether the sensor's wire is broken.
        """
        return _WORDS[self.kind](self, shown_degC, own_degC, is_open)

    @property
    def all_ones(self) -> int:
        """What is read from a line that is high."""
        return 0xFFFF if self.kind == "MAX6675" else 0xFFFF_FFFF


def _nearest(value: float, low: int, high: int) -> int:
    return min(max(math.floor(value + 0.5), low), high)


def _max6675(chip: Converter, shown_degC: float, own_degC: float, is_open: bool) -> int:
    del chip, own_degC
    return _nearest(shown_degC * 4.0, 0, 4095) << 3 | (OPEN_BIT if is_open else 0)


def _max31855(chip: Converter, shown_degC: float, own_degC: float, is_open: bool) -> int:
    del chip
    own = (_nearest(own_degC * 16.0, -880, 2000) & 0xFFF) << 4
    if is_open:
        return 0x7FFC_0000 | 1 << 16 | own | 1
    return (_nearest(shown_degC * 4.0, -1080, 5488) & 0x3FFF) << 18 | own


def _max31856(chip: Converter, shown_degC: float, own_degC: float, is_open: bool) -> int:
    del chip, own_degC
    fine = (_nearest(shown_degC * 128.0, -210 * 128, 1372 * 128) & 0x7FFFF) << 5
    return fine << 8 | (1 if is_open else 0)


def _max31865(chip: Converter, shown_degC: float, own_degC: float, is_open: bool) -> int:
    del own_degC
    configuration = 0xD1 if chip.three_wires else 0xC1
    if is_open:
        return configuration << 16 | 0xFFFF
    t = shown_degC
    ratio = 1.0 + 3.9083e-3 * t - 5.775e-7 * t * t - (4.183e-12 * (t - 100.0) * t**3 if t < 0.0 else 0.0)
    code = _nearest(ratio * chip.platinum_ohm / chip.reference_ohm * 32768.0, 0, 32767)
    return configuration << 16 | code << 1


_WORDS: dict[str, Callable[[Converter, float, float, bool], int]] = {
    "MAX6675": _max6675,
    "MAX31855": _max31855,
    "MAX31856": _max31856,
    "MAX31865": _max31865,
}
