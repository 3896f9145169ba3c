"""What converter chips send for a temperature, by their data sheets.

MAX6675 (table 2): bit 15 is 0, bits 14..3 are the temperature in quarters of a degree, bit 2 tells an open
thermocouple, bit 1 (device identity) is 0 and bit 0 leaves the line floating, read 0. MAX31855 (tables 2 to 4): 14 bits
of quarters of a degree with sign, 0, fault; 12 bits of the chip's own temperature in sixteenths, 0, shorted to VCC,
shorted to GND, open. MAX31856: 19 bits of 1/128 of a degree in 24, then its fault register. MAX31865: configuration,
then the ratio of the resistors in 15 bits, and fault. A thermistor has no chip: its word is the sum of 16 conversions
of the Mega's own converter (data sheet, "ADC Conversion Result"), each 1024 times the pin's share of the supply.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

OPEN_BIT = 0x0004
_SUMMED = 16


@dataclass(frozen=True)
class Ntc:
    """A thermistor between its pin and ground, or the supply, and a resistor at the other side.

    Attributes
    ----------
    a, b, c
        1/T = a + b ln R + c (ln R)^3, T in K and R in ohm.
    series_ohm
        The resistor.
    to_supply
        Whether the thermistor is at the supply.
    """

    a: float
    b: float
    c: float
    series_ohm: float
    to_supply: bool = False

    def resistance_ohm(self, degC: float) -> float:
        """Give its resistance: the equation solved by Cardano's formula."""
        rest = self.a - 1.0 / (degC + 273.15)
        if self.c == 0.0:
            return math.exp(-rest / self.b)
        half = rest / (2.0 * self.c)
        root = math.sqrt((self.b / (3.0 * self.c)) ** 3 + half**2)
        return math.exp(math.cbrt(root - half) - math.cbrt(root + half))

    def word(self, degC: float, is_open: bool) -> int:
        """Give the sum of the conversions."""
        own = math.inf if is_open else self.resistance_ohm(degC)
        share = 1.0 / (1.0 + own / self.series_ohm)
        return _SUMMED * min(_nearest(1024.0 * (share if self.to_supply else 1.0 - share), 0, 1024), 1023)


@dataclass(frozen=True)
class Converter:
    """A chip between sensor and board.

    Attributes
    ----------
    kind
        MAX6675, MAX31855, MAX31856, MAX31865 or NTC.
    platinum_ohm, reference_ohm
        Of a MAX31865: the resistor at 0 degC, and what it is compared with.
    three_wires
        Of a MAX31865: whether it is told so.
    thermistor
        Of an NTC.
    """

    kind: str = "MAX6675"
    platinum_ohm: float = 100.0
    reference_ohm: float = 430.0
    three_wires: bool = False
    thermistor: Ntc | None = None

    def __post_init__(self) -> None:
        if self.kind not in _WORDS:
            raise ValueError(f"unknown converter {self.kind!r}; expected one of {', '.join(_WORDS)}")
        if (self.kind == "NTC") != (self.thermistor is not None):
            raise ValueError("an NTC has a thermistor, and nothing else has one")

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
        if self.kind == "NTC":
            return 1023 * _SUMMED
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


def _ntc(chip: Converter, shown_degC: float, own_degC: float, is_open: bool) -> int:
    del own_degC
    assert chip.thermistor is not None
    return chip.thermistor.word(shown_degC, is_open)


_WORDS: dict[str, Callable[[Converter, float, float, bool], int]] = {
    "MAX6675": _max6675,
    "MAX31855": _max31855,
    "MAX31856": _max31856,
    "MAX31865": _max31865,
    "NTC": _ntc,
}
