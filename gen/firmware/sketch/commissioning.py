"""Commissioning: a person and the board go through thermocouples, direction, encoder and stop."""

from __future__ import annotations

import json
import math
import zlib
from typing import TypedDict

from gen.coefficients.wiring import Wiring
from gen.firmware.boards import Board
from gen.firmware.sketch.drive import DriveContext
from gen.firmware.sketch.memory import COMMISSIONED_BYTES, commissioned_at
from gen.lowering.program import Program
from gen.lowering.samples import samples
from gen.lowering.sensors import NOISE_COUNTS, COUNT_mK

_AGREE_K = 4.0
"""A cold motor: no two thermocouples are farther apart than two chips may err, 2 K each (MAX6675's and MAX31855's data
sheets at room temperature)."""
_MOVED_K = 2.0
"""A hand warms a thermocouple by more than that, and nothing else does so to one alone."""
_COLD_S, _HELD_S, _LET_GO_S = 10.0, 1.0, 4.0
"""For so long a cold motor is watched; a change must hold; a warmed thermocouple must not warm further."""
_RUN_S, _STANDS_S, _STOP_S = 4.0, 3.0, 10.0
"""So long the motor is driven; a motor without encoder is given to stop; one with an encoder may turn on."""
_PERSON_S = 120.0
"""So long the board waits for a person in each step."""
_PWM_SHARE = 0.2
"""Of the full scale, where no encoder says from which PWM on the motor turns."""


class CommissioningContext(TypedDict):
    """The dialogue's times in samples and its thresholds in counts of 0.25 K, and where its record lies.

    `pwm` is what the motor is driven with, `no_pulse_samples` how long an encoder may be silent at it.
    """

    at: int
    bytes: int
    wiring: str
    agree: int
    steady: int
    moved: int
    cold_samples: int
    cold_s: str
    held_samples: int
    let_go_samples: int
    run_samples: int
    run_s: str
    stands_samples: int
    stop_samples: int
    stop_s: str
    person_samples: int
    person_s: str
    pwm: int
    no_pulse_samples: int


def commissioning_context(
    board: Board, wiring: Wiring, drive: DriveContext | None, program: Program
) -> CommissioningContext:
    """Describe the dialogue of a board with thermocouples and copies in EEPROM.

    Parameters
    ----------
    board, wiring
        The file's.
    drive
        The motor's driver as the sketch has it.
    program
        What is emitted.
    """
    full_scale, sample_time = program.model.full_scale, program.model.sample_time
    encoder = wiring.encoder
    pwm = min(encoder.stall_pwm, full_scale) if encoder else math.ceil(_PWM_SHARE * full_scale)

    def counted(seconds: float) -> int:
        return max(1, samples(seconds, sample_time))

    run = counted(_RUN_S)
    if drive is not None:
        run += drive["pause_samples"] + (math.ceil(256 * pwm / drive["ramp_step"]) if drive["ramp_step"] else 0)
    return {
        "at": commissioned_at(board),
        "bytes": COMMISSIONED_BYTES,
        "wiring": f"0x{wiring_identity(wiring, program.model.name):08X}UL",
        "agree": round(_AGREE_K * 1000 / COUNT_mK),
        "steady": NOISE_COUNTS,
        "moved": round(_MOVED_K * 1000 / COUNT_mK),
        "cold_samples": counted(_COLD_S),
        "cold_s": f"{_COLD_S:g}",
        "held_samples": counted(_HELD_S),
        "let_go_samples": counted(_LET_GO_S),
        "run_samples": min(run, 0xFFFF),
        "run_s": f"{_RUN_S:g}",
        "stands_samples": counted(_STANDS_S),
        "stop_samples": counted(_STOP_S),
        "stop_s": f"{_STOP_S:g}",
        "person_samples": counted(_PERSON_S),
        "person_s": f"{_PERSON_S:g}",
        "pwm": pwm,
        # One less than what makes a stall: the dialogue says it before the table of causes stops the motor.
        "no_pulse_samples": max(1, counted(encoder.stall_s) - 1) if encoder else 1,
    }


def wiring_identity(wiring: Wiring, name: str) -> int:
    """CRC-32 of what a commissioning is about: the motor's name, thermocouples, encoder and driver with their pins.

    Another coefficient file for the same wiring, as `gen refine` writes it, keeps it.
    """
    chips = [
        (chip.channel, chip.chip, chip.analog_pin)
        if chip.chip == "NTC"
        else (chip.channel, chip.chip, chip.cs, chip.so, chip.sck, chip.sdi)
        for chip in wiring.thermocouples
    ]
    encoder = wiring.encoder.pin if wiring.encoder else None
    drive = (
        (*wiring.drive.pwm_pins.items(), wiring.drive.direction_pin, wiring.drive.forward_is_high)
        if wiring.drive
        else None
    )
    return zlib.crc32(json.dumps([name, chips, encoder, drive]).encode())
