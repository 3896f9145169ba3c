"""What the templates are told about running the model ahead."""

from __future__ import annotations

from typing import TypedDict

from gen.lowering.forecast import NOISE_MK, SMOOTHED, LoweredForecast
from gen.lowering.program import Program

_AT_ONCE = {"fixed": 8, "float": 2}
"""Samples that the sketch goes ahead before it looks at the clock: a few milliseconds of a Mega."""


class LimitEntry(TypedDict):
    """A limit; `part` is a component's number; behind all of them, that of a network's state."""

    name: str
    source: str
    limit_mC: int
    part: int


class ForecastContext(TypedDict):
    """What is watched, how far ahead, and how fast; `near` is in samples, `horizon_s` for people.

    `told`: how many channels the model has; `pwm_channel`: the number of the one that is the PWM with its sign.
    `hidden`: a node that nobody measures is among the limits. `proven`: the limits allow for the words' errors.
    `holds`: a motor is derated to what can be held; then what is measured is averaged over `smoothed` samples, and
    `noise_mK` of it count at the end of a run alone.
    """

    limits: list[LimitEntry]
    horizon: int
    horizon_s: str
    steps: int
    at_once: int
    most_pwm: int
    told: int
    pwm_channel: int | None
    near: int | None
    hidden: bool
    proven: bool
    holds: bool
    smoothed: int
    noise_mK: int


def forecast_context(program: Program, forecast: LoweredForecast | None) -> ForecastContext | None:
    """The forecast as the templates print it; None without one.

    Parameters
    ----------
    program, forecast
        What is emitted.
    """
    if forecast is None:
        return None
    return {
        "limits": [
            {
                "name": limit.name,
                "source": f"{limit.source_degC:g}",
                "limit_mC": limit.limit_mC,
                "part": limit.part,
            }
            for limit in forecast.limits
        ],
        "horizon": forecast.horizon,
        "horizon_s": f"{forecast.horizon * program.model.sample_time:g}",
        "steps": forecast.steps,
        "at_once": 1 if program.effects is not None else _AT_ONCE[program.arithmetic],
        "most_pwm": forecast.most_pwm,
        "told": len(program.channels),
        "pwm_channel": forecast.pwm_channel,
        "near": forecast.near,
        "hidden": any(limit.part >= len(program.parts) for limit in forecast.limits),
        "proven": forecast.proven,
        "holds": forecast.holds,
        "smoothed": SMOOTHED,
        "noise_mK": NOISE_MK,
    }
