"""What the look ahead is compared on: starts far from the limits, near and at them, and the reference's answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.lowering.forecast import LoweredForecast
from gen.lowering.program import Program
from gen.reference.board import reference_of
from gen.reference.forecast import FORECAST_FIELDS, ReferenceForecast

Integers = NDArray[np.int64]
Records = NDArray[np.void]
STEP, BEGIN = 0, 1
#: Samples for which a PWM stays at most: long enough for a run, or for a search.
_LONGEST = (20, 1_000)
#: A run that is begun anew less often than this would hardly ever end.
_CHANGE_SHARE = 0.03
#: Measurements that lie on a limit or just below it.
_CLOSE_SHARE = 0.3


@dataclass(frozen=True)
class ForecastCampaign:
    """Inputs of L lanes, shape (L, N + 1), the first of which begins the lane, and what is expected, shape (L, N)."""

    inputs: Records
    expected: Records


def input_type(program: Program) -> np.dtype[np.void]:
    """The harnesses' input record; without channels it has none."""
    told = [("channel", "<i4", (len(program.channels),))] if program.channels else []
    sample = [("measured_mC", "<i4", (len(program.parts),)), ("ambient_mC", "<i4")]
    return np.dtype([("op", "u1"), ("pwm", "<i2"), *told, *sample, ("valid", "<u2"), ("plausible", "<u2")])


def output_type(program: Program) -> np.dtype[np.void]:
    """The harnesses' output record: the look ahead, what follows from it, and the rises of the board's own model."""
    rises = [(f"{part.name}.rise_mK", "<i4") for part in program.parts]
    return np.dtype([*FORECAST_FIELDS, ("samples", "<u4"), ("near", "u1"), *rises])


def forecast_campaign(
    program: Program, forecast: LoweredForecast, lanes: int, length: int, seed: int = 7_411
) -> ForecastCampaign:
    """PWM, channels and measurements that change now and then, from starts around the limits.

    Parameters
    ----------
    program, forecast
        What the board holds.
    lanes, length
        Of the campaign.
    """
    random = np.random.default_rng(seed)
    inputs = np.zeros((lanes, length + 1), dtype=input_type(program))
    expected = np.zeros((lanes, length), dtype=output_type(program))
    for lane in range(lanes):
        _lane(random, program, forecast, inputs[lane], expected[lane], steady=lane % 4 == 0)
    return ForecastCampaign(inputs, expected)


def _lane(
    random: np.random.Generator,
    program: Program,
    forecast: LoweredForecast,
    inputs: Records,
    expected: Records,
    *,
    steady: bool,
) -> None:
    """One lane; a steady one keeps its PWM and its ambient, and only what is measured comes and goes."""
    ambient_mC = int(random.integers(0, 40_000))
    told = _told(random, program, ambient_mC)
    # Thousandths to tens of kelvins below a limit: some runs last to the horizon, others end at once.
    limits = _limits(program, forecast)
    below = _spread(random, int(random.choice([300, 60_000])), len(limits))
    starts = limits - ambient_mC - (5_000 if steady else below)
    names = program.model.component_names
    board = reference_of(program, {name: [int(rise)] for name, rise in zip(names, starts, strict=True)}, told)
    ahead = ReferenceForecast(forecast)
    _put(inputs[:1], BEGIN, 0, told, starts, ambient_mC, 0)
    scale = program.model.full_scale
    pwm, left, longest = (scale, len(expected), 1) if steady else (0, 0, int(random.choice(_LONGEST)))
    for step in range(len(expected)):
        if left == 0:
            left = int(random.integers(1, longest))
            pwm = int(random.choice(np.array([0, scale, *random.integers(0, scale + 1, 2)]))) * int(
                random.choice([-1, 1])
            )
        left -= 1
        if random.random() < _CHANGE_SHARE and not steady:
            ambient_mC += int(random.integers(-2_000, 2_000))
            told = _told(random, program, ambient_mC)
        if told is not None:
            board.set_channels(told)
        board.step(np.array([pwm]))
        readings = board.rises_mK[:, 0] + ambient_mC
        beside = _spread(random, 100, len(readings))
        measured: Integers = np.where(random.random(len(readings)) < 0.5, readings + beside, readings - beside)
        close = np.asarray(random.random(len(readings)) < _CLOSE_SHARE) | steady
        measured = np.where(close, limits - random.integers(0, 200, len(limits)), measured)
        valid = (1 << len(readings)) - 1 if steady else int(random.integers(0, 1 << len(readings)))
        _put(inputs[step + 1 : step + 2], STEP, pwm, told, measured, ambient_mC, valid)
        ahead.sample(pwm, board, measured, ambient_mC, valid)
        while ahead.work(7):
            pass
        _keep(expected[step : step + 1], ahead, dict(zip(names, board.rises_mK, strict=True)))


def _limits(program: Program, forecast: LoweredForecast) -> Integers:
    """Each component's limit, of one without the lowest of all, shape (components,), in thousandths of a degree."""
    found = dict.fromkeys(range(len(program.parts)), min(limit.limit_mC for limit in forecast.limits))
    found |= {limit.component: limit.limit_mC for limit in forecast.limits if limit.component is not None}
    return np.array([found[component] for component in sorted(found)], dtype=np.int64)


def _spread(random: np.random.Generator, most: int, count: int) -> Integers:
    """Sizes from 1 to `most`, as many in each decade."""
    return np.asarray(np.exp(random.random(count) * np.log(most)), dtype=np.int64)


def _told(random: np.random.Generator, program: Program, ambient_mC: int) -> Integers | None:
    """The ambient as it is, every other channel anywhere in its range, shape (channels, 1)."""
    if not program.channels:
        return None
    values = [random.integers(channel.low, channel.high + 1) for channel in program.channels]
    return np.array([ambient_mC, *values[1:]], dtype=np.int64)[:, None]


def _put(
    row: Records, op: int, pwm: int, told: Integers | None, measured: Integers, ambient_mC: int, valid: int
) -> None:
    row["op"], row["pwm"], row["ambient_mC"], row["valid"] = op, pwm, ambient_mC, valid
    row["measured_mC"][0] = measured
    if told is not None:
        row["channel"][0] = told[:, 0]


def _keep(row: Records, ahead: ReferenceForecast, rises_mK: Mapping[str, Integers]) -> None:
    ahead.keep(row)
    row["samples"], row["near"] = ahead.samples, ahead.near
    for name, rise in rises_mK.items():
        row[f"{name}.rise_mK"] = rise
