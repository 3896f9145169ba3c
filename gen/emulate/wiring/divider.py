"""A thermistor and its resistor at one of the converter's pins, a share of the supply."""

from __future__ import annotations

import math

from gen.avr.shim import Handle
from gen.emulate.wiring.max6675 import ChipCounts

CONVERSIONS = 16
"""The firmware adds up so many."""
_STEPS = 1023
"""simavr's converter gives so many times the voltage over the supply, rounded down."""


class Divider:
    """A pin whose voltage moves with the supply.

    Parameters
    ----------
    handle
        The emulator that it is connected to.
    number
        The converter's input.
    """

    def __init__(self, handle: Handle, number: int) -> None:
        self._handle = handle
        self._input = number
        self._code = 0
        self._supply_mV = 5000.0

    def set_word(self, word: int) -> None:
        """Let 16 conversions from now on give a sum, to the nearest that 16 equal ones can give."""
        if not 0 <= word <= _STEPS * CONVERSIONS:
            raise ValueError(f"word {word}: expected 0..{_STEPS * CONVERSIONS}")
        self._code = round(word / CONVERSIONS)
        self._drive()

    @property
    def counts(self) -> ChipCounts:
        """None: a voltage does not know who looks at it."""
        return ChipCounts(0, 0, 0)

    def supply_with(self, volts: float) -> None:
        """Give the divider another supply, the chip's."""
        self._supply_mV = 1000.0 * volts
        self._drive()

    def _drive(self) -> None:
        self._handle.call("adc", self._input, math.ceil(self._code * self._supply_mV / _STEPS))
