"""Speed feedback."""

from __future__ import annotations

import math

from gen.coefficients.wiring import Encoder
from gen.firmware.boards import Board
from gen.firmware.sketch.pin import Pin, pin_context

_LATE_SAMPLES = 3
"""Samples whose pulses at full speed the encoder's interrupt takes before it takes the line for noisy."""
_MARGIN = 1.25
"""The encoder's fastest pulse train over the nominal one."""
_OVERSPEED, _TURNING = 1.2, 0.05
"""Shares of the nominal speed beyond which a motor is too fast, and beyond which it turns at all."""


class EncoderContext(Pin):
    """Speed feedback; `factor` turns pulses in a time of `unit_us` into revolutions per minute."""

    counter: bool
    interrupt: int | None
    pulses_per_revolution: int
    shift: int
    unit_us: int
    factor: int
    most: int
    wide: bool
    limit: int
    fastest_rpm: int
    shortest_us: int
    overspeed_rpm: int
    turning_rpm: int
    stall_pwm: int
    stall_samples: int
    stall_s: str


def encoder_context(board: Board, encoder: Encoder, nominal_rpm: float, sample_ms: int) -> EncoderContext:
    """Describe an encoder on a motor of a nominal speed, rpm; a sample has so many ms."""
    fastest_rpm = nominal_rpm * _MARGIN
    fastest = fastest_rpm / 60.0 * encoder.pulses_per_revolution * sample_ms / 1000.0
    # pulses * factor must fit 32 bits; the clock of micros() has steps of 4 us
    shift = max(2, math.ceil(math.log2(fastest_rpm * _MARGIN * sample_ms * 1000.0)) - 32)
    factor = max(1, round(60e6 / 2**shift / encoder.pulses_per_revolution))
    return {
        **pin_context(board, encoder.pin, "$.wiring.encoder.pin"),
        "counter": encoder.counts_in_hardware,
        "interrupt": board.interrupts.get(encoder.pin),
        "pulses_per_revolution": encoder.pulses_per_revolution,
        "shift": shift,
        "unit_us": 2**shift,
        "factor": factor,
        "most": (2**32 - 1) // factor,
        "wide": _LATE_SAMPLES * fastest >= 65535.0,
        "limit": math.ceil(_LATE_SAMPLES * fastest),
        "fastest_rpm": math.ceil(fastest_rpm),
        "shortest_us": sample_ms * 250,
        "overspeed_rpm": math.ceil(nominal_rpm * _OVERSPEED),
        "turning_rpm": math.ceil(nominal_rpm * _TURNING),
        "stall_pwm": encoder.stall_pwm,
        "stall_samples": max(1, math.ceil(encoder.stall_s * 1000.0 / sample_ms)),
        "stall_s": f"{encoder.stall_s:g}",
    }
