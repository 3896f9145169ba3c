"""What the sketch is told to measure its own supply."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

from gen.coefficients.protection import Protection
from gen.coefficients.wiring import HYSTERESIS_mV, Wiring
from gen.firmware.boards import Board
from gen.firmware.sketch.converter import STEPS, ConvertedInput, converted

_CONVERSIONS = 16
_SETTLING = 8
"""The reference is a weak source, and needs 70 us at most to start: these are 0.9 ms."""


class SupplyContext(TypedDict):
    """Sums of conversions of the reference: the lower the supply the larger.

    `input` is the converter's number of it; the supply is `reference` / sum, in mV. It is low from a sum of more than
    `low` on, until one of no more than `sound`.
    """

    input: int
    conversions: int
    reference: int
    reference_mV: str
    low: int
    low_mV: str
    sound: int
    sound_mV: str


def supply_input(board: Board, entries: Sequence[Protection]) -> list[ConvertedInput]:
    """What the converter does for it: nothing where no entry asks for it."""
    if all(entry.cause != "supply_low" for entry in entries):
        return []
    return [converted("the reference of 1.1 V", board.bandgap_mux, _CONVERSIONS, _SETTLING)]


def supply_context(wiring: Wiring, number: int) -> SupplyContext:
    """Describe the measurement.

    Parameters
    ----------
    wiring
        The coefficient file's.
    number
        The converter's, of the reference.
    """
    supply = wiring.own_supply
    reference = _CONVERSIONS * STEPS * supply.reference_mV
    sound_mV = supply.limit_mV + HYSTERESIS_mV
    return {
        "input": number,
        "conversions": _CONVERSIONS,
        "reference": round(reference),
        "reference_mV": f"{supply.reference_mV:g}",
        "low": int(reference / supply.limit_mV),
        "low_mV": f"{supply.limit_mV:g}",
        "sound": int(reference / sound_mV),
        "sound_mV": f"{sound_mV:g}",
    }
