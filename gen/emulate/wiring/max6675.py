"""The MAX6675s and MAX31855s on the board's pins."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

from gen.avr.shim import Handle
from gen.avr.simulator import FREQUENCY_HZ
from gen.emulate.wiring.pins import PortPin

CONVERSION_S = 0.22
"""Longest conversion of a MAX6675 by its data sheet, s (0.17 s is typical): the hardest case for the firmware."""


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


class Max6675:
    """One converter that is only read; SO and SCK may be shared with others.

    Parameters
    ----------
    handle
        The emulator that it is connected to.
    lines
        Where CS, SO and SCK are.
    conversion_s
        How long a conversion takes, s.
    bits
        Of its word: 16, or a MAX31855's 32.

    Raises
    ------
    ValueError
        When the emulator has no converter left.
    """

    def __init__(
        self, handle: Handle, lines: Sequence[PortPin], *, conversion_s: float = CONVERSION_S, bits: int = 16
    ) -> None:
        places = [part for line in lines for part in (line.port.encode(), line.bit)]
        self._handle = handle
        self._bits = bits
        self._number = int(handle.call("chip_add", *places, round(conversion_s * FREQUENCY_HZ), bits))
        if self._number < 0:
            raise ValueError("the emulator has no MAX6675 left")

    def set_word(self, word: int) -> None:
        """Let conversions give a word from now on."""
        if not 0 <= word < 1 << self._bits:
            raise ValueError(f"word {word}: expected 0..{(1 << self._bits) - 1}")
        self._handle.call("chip_word", self._number, word)

    @property
    def counts(self) -> ChipCounts:
        """Its reads so far."""
        counts = [ctypes.c_uint32() for _ in range(3)]
        self._handle.call("chip_counts", self._number, *map(ctypes.byref, counts))
        return ChipCounts(*(count.value for count in counts))
