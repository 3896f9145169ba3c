"""The largest model that a board holds, from what each further component of it costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.rivals.growth.measure import Grown
from gen.coefficients.network import MOST_NODES

TICK_CYCLES = 4_000_000
"""What 0.25 s at 16 MHz have."""


MOST = MOST_NODES
"""What a coefficient file holds of components, and of nodes."""
SKETCH_FLASH, SKETCH_RAM = 28_000, 2_320
"""What the emitted sketch of the MY1016 needs without its model, in bytes, stack included: `benchmarks/sketch_cost.py`
less the model's own (docs/device.md, README.md), of the forms in fixed point, rounded up."""


@dataclass(frozen=True)
class Board:
    """What a board has, in bytes; flash without its boot loader.

    Attributes
    ----------
    name
        What the table calls it.
    flash_bytes, ram_bytes
        For the model, with whatever else stands there taken off.
    """

    name: str
    flash_bytes: int
    ram_bytes: int


BOARDS = (
    Board("Mega 2560, beside the sketch", 253_952 - SKETCH_FLASH, 8192 - SKETCH_RAM),
    Board("Uno, nothing else on it", 32_256, 2048),
)
"""The Mega's sketch, with its copies in EEPROM, needs more RAM than an Uno has."""


def largest(board: Board, smaller: Grown, larger: Grown) -> dict[str, int]:
    """Continue a series by a straight line.

    Parameters
    ----------
    board
        What there is.
    smaller, larger
        Two models of the series.

    Returns
    -------
    dict
        By what runs out (flash, RAM, cycles): the size up to which it does not, at least 0.
    """
    limits = {
        "flash": (board.flash_bytes, smaller.flash_bytes, larger.flash_bytes),
        "RAM": (board.ram_bytes, smaller.ram_bytes, larger.ram_bytes),
        "cycles": (TICK_CYCLES, smaller.cycles_change, larger.cycles_change),
    }
    span = larger.size - smaller.size
    return {
        name: max(0, int(smaller.size + (there - low) * span // (high - low)))
        for name, (there, low, high) in limits.items()
        if high > low
    }


def held(board: Board, series: Sequence[Grown], most: int = MOST) -> tuple[int, str]:
    """Give the largest size of a series that a board holds, and what ends it.

    By the series' two largest models; what the tool refused is never held, nor more than a file holds.

    Parameters
    ----------
    board
        What there is.
    series
        Models of growing size.
    most
        What a file holds.
    """
    whole = [one for one in series if one.refused is None]
    limits = largest(board, whole[-2], whole[-1])
    refused = [one.size - 1 for one in series if one.refused is not None]
    if refused:
        limits["the table's 32 767 bytes"] = min(refused)
    limits["a file holds no more"] = most
    short = min(limits, key=lambda name: limits[name])
    return limits[short], short
