"""The reference simulator's error against the exact solution, over whole runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.firmware.step_responses import HORIZON_S, board_course, levels, starts
from gen.lowering.program import Program
from gen.model.exact import ExactSolution
from gen.model.network_solution import NetworkSolution
from gen.reference.board import reference_of
from gen.verification.profiles import Profile, campaign, with_channels

#: A run of 10 800 s at the sample time of 0.25 s.
LENGTH = 43_200
_POINTS = 60
_STEP_POINTS = 30
_STEP_DIGITS = 12
"""Decimals of the errors in K that are kept."""


@dataclass(frozen=True)
class ErrorCourse:
    """How large the error becomes along a run.

    Parameters
    ----------
    time_s
        Ends of equal intervals of the run, s, shape (P,).
    error_K
        By component, the largest magnitude of the error within each interval, over all lanes, K, shape (P,).
    """

    time_s: list[float]
    error_K: dict[str, list[float]]

    def largest(self) -> dict[str, float]:
        """Give each component's largest error, K."""
        return {name: max(values) for name, values in self.error_K.items()}


def error_course(program: Program, lanes: int, length: int = LENGTH) -> ErrorCourse:
    """Compare the reference with the exact solution.

    Parameters
    ----------
    program
        What the board holds.
    lanes, length
        Of a campaign whose starts lie inside the declared domain; `length` in samples.
    """
    profile = campaign(program.model, lanes, length, seed=10_800)
    low = max(part.start_range_mK[0] for part in program.parts)
    high = min(part.start_range_mK[1] for part in program.parts)
    if program.ambient is not None:  # the range is about rises over the reference
        low, high = (
            low - program.ambient.low + program.ambient.neutral,
            high - program.ambient.high + program.ambient.neutral,
        )
    start = np.clip(profile.start_mK, low, high)
    names = program.model.component_names
    told = _told(program, profile)
    model = reference_of(program, [int(value) for value in start], None if told is None else told[:, :, 0])
    over = None if told is None else (told[0] - program.channels[0].neutral) / 1000.0
    rise = {name: value / 1000.0 for name, value in model.starts_mK.items()}
    exact = ExactSolution(program.model).simulate(
        _in_domain(program, profile.pwm), rise, None if over is None else over[:, 1:]
    )
    ends = np.linspace(0, length, min(_POINTS, length) + 1).round().astype(int)[1:]
    worst = np.zeros((len(ends), len(names)))
    worst[0] = np.abs(model.rises - start / 1000.0).max(axis=1)  # what was asked for, not what the board made of it
    interval = 0
    for step in range(length):
        if told is not None:
            model.set_channels(told[:, :, step + 1])
        model.step(profile.pwm[:, step])
        truth = np.array([exact[name][:, step + 1] for name in names])
        if over is not None:
            truth = truth - over[:, step + 1]
        worst[interval] = np.maximum(worst[interval], np.abs(model.rises - truth).max(axis=1))
        interval += step + 1 == ends[interval]
    return ErrorCourse(
        (ends * program.model.sample_time).tolist(),
        {name: worst[:, number].tolist() for number, name in enumerate(names)},
    )


@dataclass(frozen=True)
class StepErrors:
    """The board's step responses from rest less the exact ones, of the baseline.

    Attributes
    ----------
    pwm
        The levels, shape (V,).
    time_s
        Points of the run, equally far apart, the first at 0, s, shape (P,).
    error_K
        By component and level, K, shape (V, P).
    """

    pwm: list[int]
    time_s: list[float]
    error_K: dict[str, list[list[float]]]


def step_errors(program: Program, length: int = LENGTH) -> StepErrors:
    """Run the reference at the constant PWM that the build report shows.

    Parameters
    ----------
    program
        What the board holds; its effects are left out.
    length
        Most samples to run.
    """
    program = replace(program, effects=None)
    model = program.model
    stride = max(1, min(length, round(HORIZON_S / model.sample_time)) // _STEP_POINTS)
    pwm = levels(model)
    board = board_course(program, stride, _STEP_POINTS)
    begin = {name: start / 1000.0 for name, start in zip(model.component_names, starts(program), strict=True)}
    held = np.repeat(np.array(pwm)[:, None], stride * _STEP_POINTS, axis=1)
    exact = _exact_steps(program, held, begin)
    return StepErrors(
        pwm,
        [k * board.interval_s for k in range(_STEP_POINTS + 1)],
        {
            name: [
                [
                    round(float(error), _STEP_DIGITS)
                    for error in board.rises_K[:, number, lane] - exact[name][lane, ::stride]
                ]
                for lane in range(len(pwm))
            ]
            for number, name in enumerate(model.component_names)
        },
    )


def _exact_steps(program: Program, held: IntArray, begin: Mapping[str, float]) -> dict[str, FloatArray]:
    """Exact rises at constant PWM, shape (V, N + 1) each, K."""
    model = program.model
    if model.network is None:
        return ExactSolution(model).simulate(held, {name: np.full(len(held), rise) for name, rise in begin.items()})
    solution, room = NetworkSolution(model), program.channels[0].neutral / 1000.0
    times = np.arange(held.shape[1] + 1) * model.sample_time
    first = {name: rise + room for name, rise in begin.items()}
    lanes = [solution.simulate_times(times, np.append(pwm, pwm[-1]), room, start=first) for pwm in held]
    return {name: np.array([lane[name] for lane in lanes]) - room for name in model.component_names}


def _told(program: Program, profile: Profile) -> IntArray | None:
    """What the board is told of a moving ambient before start and samples, shape (1, L, N + 1), if it does."""
    if program.ambient is None:
        return None
    told = with_channels(profile, program.channels).channels
    assert told is not None
    return np.moveaxis(np.clip(told, program.ambient.low, program.ambient.high), 2, 0)


def _in_domain(program: Program, pwm: IntArray) -> IntArray:
    low, high = program.model.domain_pwm
    clamped: IntArray = np.clip(np.abs(pwm), low, high)
    return clamped
