"""What turns the motor: the board's own driver, or another controller that it observes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypedDict

from gen.coefficients.wiring import Drive, Observe, Wiring
from gen.firmware.boards import TIMER_RUNS, Board
from gen.firmware.sketch.pin import Pin, pin_context
from gen.lowering.samples import samples


class Timer(TypedDict):
    """A timer that makes PWM, what it runs with, and on which of the driver's lines."""

    number: int
    runs: str
    lines: list[str]


class ProfileStep(TypedDict):
    """A step of the built-in profile."""

    samples: int
    pwm: int
    s: str


class DriveContext(TypedDict):
    """The motor's driver: a PWM input for each direction, or one with a direction input."""

    forward: Pin | None
    reverse: Pin | None
    pwm: Pin | None
    direction: Pin | None
    forward_high: bool
    timers: list[Timer]
    frequency_Hz: int
    pause_samples: int
    ramp_step: int
    steps: list[ProfileStep]
    repeat: bool
    autostart: bool


class ObserveContext(TypedDict):
    """Pins on which another controller's PWM is measured."""

    forward: Pin
    reverse: Pin | None


def drive_context(board: Board, drive: Drive, full_scale: int, sample_time: float) -> DriveContext:
    """Describe a driver; a sample has so many s."""
    steps = drive.profile.steps if drive.profile else ()
    lines = {key: getattr(drive, f"{key}_pin") for key in ("forward", "reverse", "pwm", "direction")}
    pins = {
        key: None if pin is None else pin_context(board, pin, f"$.wiring.drive.{key}_pin") for key, pin in lines.items()
    }
    of_timer = {key.removesuffix("_pin"): board.pwm_timers[pin] for key, pin in drive.pwm_pins.items()}
    return {
        "forward": pins["forward"],
        "reverse": pins["reverse"],
        "pwm": pins["pwm"],
        "direction": pins["direction"],
        "forward_high": drive.forward_is_high,
        "timers": [
            {
                "number": timer,
                "runs": TIMER_RUNS[drive.frequency_Hz][timer],
                "lines": [key for key, own in of_timer.items() if own == timer],
            }
            for timer in sorted({*of_timer.values()} - {0})
        ],
        "steps": [
            {
                "samples": max(1, round(step.duration_s / sample_time)),
                "pwm": step.pwm,
                "s": f"{step.duration_s:g}",
            }
            for step in steps
        ],
        "frequency_Hz": drive.frequency_Hz,
        "pause_samples": samples(drive.reversal_pause_s, sample_time),
        "ramp_step": _ramp_step(drive.ramp_s, full_scale, sample_time),
        "repeat": bool(drive.profile and drive.profile.repeat),
        "autostart": bool(drive.profile and drive.profile.autostart),
    }


def _ramp_step(ramp_s: float, full_scale: int, sample_time: float) -> int:
    """By how much |PWM| may rise in a sample, in 256ths of a count; 0: by anything."""
    step = 256.0 * full_scale * sample_time / ramp_s if ramp_s else 0.0
    return 0 if step >= 256.0 * full_scale else math.ceil(step)


def observe_context(board: Board, observe: Observe) -> ObserveContext:
    """Describe the pins of another controller."""
    reverse = observe.reverse_pin
    return {
        "forward": pin_context(board, observe.forward_pin, "$.wiring.observe.forward_pin"),
        "reverse": pin_context(board, reverse, "$.wiring.observe.reverse_pin") if reverse is not None else None,
    }


def idle_timers(board: Board, wiring: Wiring) -> list[int]:
    """Timers of the board that this wiring never uses."""
    used = {board.pwm_timers[pin] for pin in wiring.drive.pwm_pins.values()} if wiring.drive else set()
    if wiring.encoder and wiring.encoder.counts_in_hardware:
        used.add(5)
    return [timer for timer in board.timers if timer not in used]


def switched_off(board: Board, idle: Sequence[int], *, converts: bool) -> dict[str, list[str]]:
    """What the board can do without: bits to set, by register.

    Parameters
    ----------
    board
        Which.
    idle
        Timers that nothing uses.
    converts
        Whether the converter is used.
    """
    found: dict[str, list[str]] = {}
    converter = [] if converts else [board.converter]
    for register, bit in [*board.unused, *converter, *(board.timers[timer] for timer in idle)]:
        found.setdefault(register, []).append(bit)
    return found
