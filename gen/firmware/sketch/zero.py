"""What the thermocouples read too much, learnt while the motor is cold."""

from __future__ import annotations

import math
from typing import TypedDict

from gen.coefficients.wiring import Wiring
from gen.firmware.boards import Board
from gen.firmware.sketch.memory import zero_place, zeroed_channels
from gen.lowering.program import Program

_WINDOW_S = 60.0
"""Of the mean that is taken. A converter's step and its noise are 0.25 K; of 240 readings 0.02 K are left."""
_LEAST_READINGS, _MOST_READINGS = 8, 1200
"""Of the mean: sums of so many hold in 32 bits."""
_NEAR_K = 0.1
"""A part that the model has so near the room says no more about where its sensor should be."""


class ZeroContext(TypedDict):
    """Numbers of the thermocouples that are compared, the mean's readings, and where the record lies."""

    at: int
    bytes: int
    channels: list[int]
    readings: int
    window_s: str
    tolerance_mK: int
    near_mK: int
    automatic: bool


def zero_context(board: Board, wiring: Wiring, program: Program, reading_ms: int) -> ZeroContext | None:
    """Describe what is learnt at a cold start.

    Parameters
    ----------
    board, wiring
        The file's.
    program
        What is emitted.
    reading_ms
        From one reading of the thermocouples to the next.

    Returns
    -------
    ZeroContext or None
        None where the file does not ask for it. By itself it is learnt only where the model follows the ambient as a
        motor does: one whose rises know nothing of it would have a motor at rest as warm as any room.
    """
    if wiring.zero is None:
        return None
    at, size = zero_place(board, wiring, program)
    pairs = math.ceil(500.0 * _WINDOW_S / reading_ms)
    readings = 2 * min(max(pairs, _LEAST_READINGS // 2), _MOST_READINGS // 2)
    follows = program.network is not None or program.ambient is not None
    return {
        "at": at,
        "bytes": size,
        "channels": zeroed_channels(wiring, program),
        "readings": readings,
        "window_s": f"{readings * reading_ms / 1000:g}",
        "tolerance_mK": round(1000.0 * wiring.zero.tolerance_K),
        "near_mK": round(1000.0 * _NEAR_K),
        "automatic": wiring.zero.automatic and follows,
    }
