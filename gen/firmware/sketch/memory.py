"""What the EEPROM keeps: copies of the states, and what outlives a reset."""

from __future__ import annotations

import math
import zlib
from typing import TypedDict

import numpy as np

from gen.coefficients.wiring import Wiring
from gen.errors import InputError
from gen.firmware.boards import Board
from gen.firmware.sketch.sensors import SensorsContext
from gen.lowering.program import Program
from gen.lowering.sensors import COUNT_mK
from gen.reference.effects import effect_fields
from gen.reference.lanes import state_fields
from gen.reference.model import AMBIENT_FIELD
from gen.reference.network import state_fields as network_state_fields
from gen.version import __version__

EEPROM_CYCLES = 100_000
"""Erase and write cycles that the chips' data sheets promise for a byte of EEPROM."""
_FIRMWARE_BYTES = 8
"""End of the EEPROM: the firmware's CRC and its complement."""
_LATCH_SLOTS = 4
_LATCH_BYTES = 18
"""A record of what outlives a reset: identity 4, number 4, alarms 2, protection 4, CRC 4."""
COMMISSIONED_BYTES = 9
"""Whether the commissioning was passed: wiring 4, verdict 1, CRC 4."""
_ZERO_FIXED = 4 + 4
"""Bytes of what the thermocouples read too much, beside two for each of them: wiring, CRC."""
_RECORD_FIXED = 4 + 4 + 2 + 4
"""Bytes of a copy beside the measured temperatures and the states: identity, number, PWM, CRC."""
_LEAST_SLOTS = 2
"""While one copy is being written, another must be whole."""


class MemoryContext(TypedDict):
    """Copies of the states in EEPROM."""

    cycles: str
    identity: str
    record_bytes: int
    slots: int
    firmware_at: int
    interval_samples: int
    interval_s: str
    tolerance_counts: int
    tolerance_K: str
    years: str


class LatchContext(TypedDict):
    """Where the latched alarms lie in EEPROM."""

    at: int
    slots: int
    bytes: int


def _latch_at(board: Board) -> int:
    return board.eeprom_bytes - _FIRMWARE_BYTES - _LATCH_SLOTS * _LATCH_BYTES


def commissioned_at(board: Board) -> int:
    """Where the commissioning's record lies in EEPROM."""
    return _latch_at(board) - COMMISSIONED_BYTES


def memory_context(
    board: Board, wiring: Wiring, sensors: SensorsContext, program: Program, sha256: str, sample_ms: int
) -> MemoryContext | None:
    """The copies in EEPROM; none without a measured component, because nothing could tell whether a copy is fresh.

    Raises
    ------
    InputError
        When the board's EEPROM does not hold two.
    """
    if wiring.memory is None or not sensors["measured"]:
        return None
    record = _RECORD_FIXED + 2 * len(sensors["chips"]) + state_bytes(program)
    slots = zero_place(board, wiring, program)[0] // record
    if slots < _LEAST_SLOTS:
        raise InputError(
            f"a copy of the states takes {record} bytes, of which the EEPROM of the {board.title} does not hold two; "
            "expected null",
            place="$.wiring.memory",
        )
    # "normal" stands for a kind of step; it stays, because any other word would make boards drop their copies.
    identity = zlib.crc32(f"{__version__} {sha256} {program.arithmetic} {program.schedule} normal".encode())
    years = EEPROM_CYCLES * slots * wiring.memory.interval_s / (365.25 * 86400)
    return {
        "cycles": f"{EEPROM_CYCLES:,}".replace(",", " "),
        "identity": f"0x{identity:08X}UL",
        "record_bytes": record,
        "slots": slots,
        "firmware_at": board.eeprom_bytes - _FIRMWARE_BYTES,
        "interval_samples": max(record, math.ceil(wiring.memory.interval_s * 1000.0 / sample_ms)),
        "interval_s": f"{wiring.memory.interval_s:g}",
        "tolerance_counts": max(1, round(wiring.memory.tolerance_K * 1000.0 / COUNT_mK)),
        "tolerance_K": f"{wiring.memory.tolerance_K:g}",
        "years": f"{years:.0f}" if years >= 10 else f"{years:.1f}",
    }


def zero_place(board: Board, wiring: Wiring, program: Program) -> tuple[int, int]:
    """Where the record of what the thermocouples read too much lies in EEPROM, and its bytes; 0 where there is none."""
    size = _ZERO_FIXED + 2 * len(zeroed_channels(wiring, program)) if wiring.zero else 0
    return commissioned_at(board) - size, size


def zeroed_channels(wiring: Wiring, program: Program) -> list[int]:
    """Numbers of the thermocouples that agree on a cold motor: those at its parts, and the ambient's."""
    agreeing = {"ambient", *program.model.component_names}
    return [number for number, chip in enumerate(wiring.thermocouples) if chip.channel in agreeing]


def latch_context(board: Board) -> LatchContext:
    """Where what outlives a reset has its place."""
    return {"at": _latch_at(board), "slots": _LATCH_SLOTS, "bytes": _LATCH_BYTES}


def state_bytes(program: Program) -> int:
    """Bytes of the model's states on the board (checked there at compile time)."""
    if program.network is not None:
        return int(np.dtype(network_state_fields(program.network)).itemsize)
    effects = effect_fields(program.effects, program.components) if program.effects is not None else []
    own = [AMBIENT_FIELD] if program.ambient is not None else []
    every = (*map(state_fields, program.components), own, effects)
    return sum(np.dtype(fields).itemsize for fields in every if fields)
