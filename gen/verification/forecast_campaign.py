"""What the look ahead is compared on: starts far from the limits, near and at them, and the reference's answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gen.arrays import IntArray, RecordArray
from gen.lowering.forecast import LoweredForecast
from gen.lowering.program import Program
from gen.reference.board import reference_of
from gen.reference.forecast import ReferenceForecast, forecast_fields
from gen.verification.sample import sample_fields

STEP, BEGIN = 0, 1
#: A lane's PWM stays for so many samples at most: less than a run takes, or long enough for whole searches.
_LONGEST = (20, 1_000)
#: Samples after which the ambient and the channels are others.
_CHANGE_SHARE = 0.03
#: Measurements that lie on a limit or just below it.
_CLOSE_SHARE = 0.3
#: Every so many lanes one keeps its PWM and its ambient, so that run after run ends between now and the horizon.
_STEADY = 2


@dataclass(frozen=True)
class ForecastCampaign:
    """Inputs of L lanes, shape (L, N + 1), the first of which begins the lane, and what is expected, shape (L, N)."""

    inputs: RecordArray
    expected: RecordArray


def input_type(program: Program) -> np.dtype[np.void]:
    """The harnesses' input record; without channels it has none."""
    told = [("channel", "<i4", (len(program.channels),))] if program.channels else []
    return np.dtype([("op", "u1"), ("pwm", "<i2"), *told, *sample_fields(len(program.parts))])


def output_type(program: Program, forecast: LoweredForecast) -> np.dtype[np.void]:
    """The harnesses' output record: the look ahead, what follows from it, and the rises of the board's own model."""
    rises = [(f"{part.name}.rise_mK", "<i4") for part in program.parts]
    held = [("most_pwm", "u1")] if forecast.holds else []
    return np.dtype([*forecast_fields(forecast), ("samples", "<u4"), ("near", "u1"), *held, *rises])


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
    expected = np.zeros((lanes, length), dtype=output_type(program, forecast))
    for lane in range(lanes):
        surroundings = _Surroundings(random, program, forecast, steady=lane % _STEADY == 0)
        _lane(program, forecast, surroundings, inputs[lane], expected[lane])
    return ForecastCampaign(inputs, expected)


class _Surroundings:
    """What a lane is given: it starts around its limits; its PWM, channels and measurements change now and then.

    Attributes
    ----------
    starts_mK
        Rises at the start, shape (components,): thousandths to tens of kelvins below the limits, so that some runs last
        to the horizon and others end at once.
    pwm, ambient_mC, told
        What holds now; the last one is None where the model has no channels, else of shape (channels, 1).
    """

    def __init__(
        self, random: np.random.Generator, program: Program, forecast: LoweredForecast, *, steady: bool
    ) -> None:
        self._random, self._program, self._steady = random, program, steady
        self._limits = _limits(program, forecast)
        self.ambient_mC = int(random.integers(0, 40_000))
        self.told = self._channels()
        below = _spread(random, int(random.choice([300, 60_000])), len(self._limits))
        self.starts_mK: IntArray = self._limits - self.ambient_mC - (5_000 if steady else below)
        self.pwm = program.model.full_scale * int(random.choice([-1, 1])) if steady else 0
        self._left, self._longest = 0, int(random.choice(_LONGEST))

    def next(self) -> None:
        """Go on to the next sample."""
        if self._steady:
            return
        random, scale = self._random, self._program.model.full_scale
        if self._left == 0:
            self._left = int(random.integers(1, self._longest))
            size = int(random.choice(np.array([0, scale, *random.integers(0, scale + 1, 2)])))
            self.pwm = size * int(random.choice([-1, 1]))
        self._left -= 1
        if random.random() < _CHANGE_SHARE:
            self.ambient_mC += int(random.integers(-2_000, 2_000))
            self.told = self._channels()

    def measured(self, readings_mC: IntArray) -> tuple[IntArray, int]:
        """Measurements around a model's readings, shape (components,), and which of them there are, as a bit mask."""
        random, count = self._random, len(readings_mC)
        beside = np.where(random.random(count) < 0.5, 1, -1) * _spread(random, 100, count)
        close = np.asarray(random.random(count) < _CLOSE_SHARE) | self._steady
        found: IntArray = np.where(close, self._limits - random.integers(0, 200, count), readings_mC + beside)
        return found, (1 << count) - 1 if self._steady else int(random.integers(0, 1 << count))

    def _channels(self) -> IntArray | None:
        """The ambient as it is, every other channel anywhere in its range."""
        if not self._program.channels:
            return None
        ranges = ((channel.low, channel.high) for channel in self._program.channels[1:])
        others = [int(self._random.integers(low, high + 1)) for low, high in ranges]
        return np.array([self.ambient_mC, *others], dtype=np.int64)[:, None]


def _lane(
    program: Program, forecast: LoweredForecast, given: _Surroundings, inputs: RecordArray, expected: RecordArray
) -> None:
    names = program.model.component_names
    starts = {name: [int(rise)] for name, rise in zip(names, given.starts_mK, strict=True)}
    board = reference_of(program, starts, given.told)
    ahead = ReferenceForecast(forecast)
    _put(inputs[:1], BEGIN, given, given.starts_mK, 0)
    for step in range(len(expected)):
        given.next()
        if given.told is not None:
            board.set_channels(given.told)
        board.step(np.array([given.pwm]))
        measured, valid = given.measured(board.rises_mK[:, 0] + given.ambient_mC)
        _put(inputs[step + 1 : step + 2], STEP, given, measured, valid)
        ahead.sample(given.pwm, board, measured, given.ambient_mC, valid)
        while ahead.work(7):
            pass
        _keep(expected[step : step + 1], ahead, dict(zip(names, board.rises_mK, strict=True)))


def _limits(program: Program, forecast: LoweredForecast) -> IntArray:
    """Each component's limit, of one without the lowest of all, shape (components,), in thousandths of a degree."""
    found = dict.fromkeys(range(len(program.parts)), min(limit.limit_mC for limit in forecast.limits))
    found |= {limit.part: limit.limit_mC for limit in forecast.limits if limit.part in found}
    return np.array(list(found.values()), dtype=np.int64)


def _spread(random: np.random.Generator, most: int, count: int) -> IntArray:
    """Sizes from 1 to `most`, as many in each decade."""
    return np.asarray(np.exp(random.random(count) * np.log(most)), dtype=np.int64)


def _put(row: RecordArray, op: int, given: _Surroundings, measured_mC: IntArray, valid: int) -> None:
    row["op"], row["pwm"], row["ambient_mC"], row["valid"] = op, given.pwm, given.ambient_mC, valid
    row["measured_mC"][0] = measured_mC
    if given.told is not None:
        row["channel"][0] = given.told[:, 0]


def _keep(row: RecordArray, ahead: ReferenceForecast, rises_mK: Mapping[str, IntArray]) -> None:
    ahead.keep(row)
    row["samples"], row["near"] = ahead.samples, ahead.near
    if "most_pwm" in (row.dtype.names or ()):
        row["most_pwm"] = ahead.most_pwm
    for name, rise in rises_mK.items():
        row[f"{name}.rise_mK"] = rise
