"""The analog converter, which several parts of the sketch share: what it converts in each sample, in which order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, TypedDict

from gen.firmware.boards import Board

CONVERSION_CYCLES: Final = 14 * 128
"""From one conversion to the next, which its interrupt begins: 13 cycles of the converter's clock, and another."""
STEPS: Final = 1024
"""A conversion gives so many times its input over the supply, rounded down."""
SETTLING: Final = 8
"""Conversions that are thrown away after the converter was off."""
_AGAINST_SUPPLY = 0x40
"""ADMUX: REFS0."""
_UPPER_INPUTS = 0x08
"""ADCSRB: MUX5."""


class ConvertedInput(TypedDict):
    """An input: what ADMUX and ADCSRB hold for it, conversions that are thrown away before, those that are added up."""

    what: str
    mux: int
    upper: int
    settling: int
    conversions: int


class ConverterContext(TypedDict):
    """All that is converted in a sample.

    `didr` turns the digital inputs of its pins off: register and value.
    """

    converted: list[ConvertedInput]
    settling: int
    didr: list[tuple[str, int]]


def converter_context(board: Board, inputs: Sequence[ConvertedInput]) -> ConverterContext:
    """What the templates of the converter need.

    Parameters
    ----------
    board
        Whose converter it is.
    inputs
        Of all parts that share it, in the order in which they are converted.
    """
    pins = [one for one in inputs if one["mux"] & 0x18 == 0]
    registers = [("DIDR0", False), ("DIDR2", True)] if board.upper_inputs else [("DIDR0", False)]
    return {
        "converted": [*inputs],
        "settling": SETTLING,
        "didr": [
            (register, sum(1 << (one["mux"] & 7) for one in pins if bool(one["upper"]) == upper))
            for register, upper in registers
        ],
    }


def converted(what: str, mux: int, conversions: int, settling: int = 0) -> ConvertedInput:
    """Describe an input.

    Parameters
    ----------
    what
        For those who read the emitted table.
    mux
        MUX5..MUX0 of the data sheet ("Input Channel Selections").
    conversions
        How many make a sum, 64 at most: it has 16 bits.
    settling
        How many are thrown away before.
    """
    return {
        "what": what,
        "mux": _AGAINST_SUPPLY | mux & 0x1F,
        "upper": _UPPER_INPUTS if mux & 0x20 else 0,
        "settling": settling,
        "conversions": conversions,
    }


def round_ms(inputs: Sequence[ConvertedInput]) -> float:
    """How long all of them take, ms."""
    count = SETTLING + sum(one["settling"] + one["conversions"] for one in inputs)
    return count * CONVERSION_CYCLES / 16e3
