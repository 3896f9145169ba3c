"""What the checks of the chip itself are told: patterns for the CPU's registers, times of the watchdog's oscillator."""

from __future__ import annotations

import math
from typing import Final, TypedDict

OSCILLATOR_HZ: Final = 128_000
"""The watchdog's own, typically (data sheet, "128 kHz Internal Oscillator")."""
_TURNS = 2048
_TOLERANCE = 0.2
_EVERY_S = 10.0
_SILENT_S = 0.1
_KEPT = (*range(2, 18), 28, 29)
"""Registers that belong to the caller (avr-gcc's calling convention); r1 is 0 again at the end, the others are free."""
_CPU_CYCLES = 430


class ChipChecks(TypedDict):
    """Names as the templates have them; patterns have a value for each register, flags are those of SREG without I."""

    cpu_kept: tuple[int, ...]
    cpu_patterns: tuple[tuple[int, ...], ...]
    cpu_flags: tuple[int, ...]
    cpu_cycles: int
    oscillator_s: str
    oscillator_ms: str
    oscillator_samples: int
    oscillator_silent: int
    oscillator_shortest_us: int
    oscillator_longest_us: int


def chip_checks(sample_time: float) -> ChipChecks:
    """What the templates of both checks need.

    Parameters
    ----------
    sample_time
        The model's, in s.
    """
    pattern = tuple(0x55 ^ number for number in range(32))
    rings_us = 1e6 * _TURNS / OSCILLATOR_HZ
    every = max(2, math.ceil(_EVERY_S / sample_time))
    return {
        "cpu_kept": _KEPT,
        "cpu_patterns": (pattern, tuple(value ^ 0xFF for value in pattern)),
        "cpu_flags": (0x55, 0x2A),
        "cpu_cycles": _CPU_CYCLES,
        "oscillator_s": f"{every * sample_time:g}",
        "oscillator_ms": f"{rings_us / 1000.0:g}",
        "oscillator_samples": every,
        "oscillator_silent": max(2, math.ceil(_SILENT_S / sample_time)),
        "oscillator_shortest_us": round(rings_us * (1.0 - _TOLERANCE)),
        "oscillator_longest_us": round(rings_us * (1.0 + _TOLERANCE)),
    }
