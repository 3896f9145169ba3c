"""Step responses from rest: the exact ones in decimals, and the board's as its reference computes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from math import ceil, log2
from typing import Any

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.program import Program
from gen.model import Component, NetworkSolution, ThermalModel
from gen.model.schedules import EXACT
from gen.reference.board import reference_of

#: Length of the step responses, in s.
HORIZON_S = 10_800
LEVELS = (20, 40, 60, 80, 100)
"""PWM of the step responses, in percent of full scale."""
_POINTS, _LATER_POINTS = 80, 60
#: Products of order, substeps and samples that the reference may take in a build: about a quarter of a second.
_WORK = 19_200

Parts = Sequence[tuple[float, int]]
"""Intervals in s, and how many points follow at each."""


@dataclass(frozen=True)
class Responses:
    """Step responses of one component.

    Attributes
    ----------
    times, exact
        The exact solution: times in s, shape (T,), and for each level the rises in K, shape (T,).
    ran, errors
        The board's run: times in s, shape (P,), and for each level the board's rise less the exact one, in K.
    own
        For each level the board's rise, in K, shape (P,).
    """

    times: list[float]
    exact: list[list[Decimal]]
    ran: list[float]
    errors: list[list[Decimal]]
    own: list[list[float]]


@dataclass(frozen=True)
class BoardCourse:
    """What the board's reference computed at constant PWM.

    Attributes
    ----------
    interval_s
        Time between two points; the first is at 0.
    rises_K
        Shape (points, components, levels).
    """

    interval_s: float
    rises_K: FloatArray


def levels(model: ThermalModel) -> list[int]:
    """|PWM| of the step responses, within the declared domain."""
    low, high = model.domain_pwm
    return sorted({min(max(round(model.full_scale * percent / 100), low), high) for percent in LEVELS})


def starts(program: Program) -> list[int]:
    """Rises of the components at rest at ambient, or as near to it as the domain allows, in thousandths of a kelvin."""
    return [min(max(0, part.start_range_mK[0]), part.start_range_mK[1]) for part in program.parts]


def board_course(program: Program, stride: int, points: int) -> BoardCourse:
    """Run the board's reference from rest at every level.

    Parameters
    ----------
    program
        What the board holds; without effects, which have no such exact solution.
    stride, points
        Samples from one point to the next, and how many of them.
    """
    pwm = np.array(levels(program.model))
    names = program.model.component_names
    board = reference_of(program, {n: [s] * len(pwm) for n, s in zip(names, starts(program), strict=True)})
    rises = [board.rises]
    for _ in range(points):
        for _ in range(stride):
            board.step(pwm)
        rises.append(board.rises)
    return BoardCourse(stride * program.model.sample_time, np.array(rises))


def responses(program: Program, verified: Mapping[str, Any] | None) -> list[Responses]:
    """Step responses of each component.

    Parameters
    ----------
    program
        What the board holds; without effects, which have no such exact solution.
    verified
        What `gen verify` recorded of a whole run (:class:`gen.verification.accuracy.StepErrors`); without it the board
        runs for a first part here, as a build must not take longer.
    """
    model = program.model
    pwm = levels(model)
    work = _work(program)
    stride = max(1, min(_WORK // work, round(HORIZON_S / model.sample_time)) // _POINTS)
    interval = stride * model.sample_time
    horizon = HORIZON_S if verified is None else float(verified["time_s"][-1])
    later = max(0.0, horizon - interval * _POINTS) / _LATER_POINTS
    parts = [(interval, _POINTS), (later, _LATER_POINTS if later else 0)]
    board = board_course(program, stride, _POINTS) if verified is None else None
    found = []
    solve = _network_responses(program) if model.network is not None else _component_responses(program)
    for number, name in enumerate(model.component_names):
        exact = solve(number, parts)
        if board is not None:
            ran = _times(parts[:1])
            own = [board.rises_K[:, number, lane].tolist() for lane in range(len(pwm))]
            errors = [[Decimal(b) - e for b, e in zip(own[i], exact[i], strict=False)] for i in range(len(pwm))]
        else:
            assert verified is not None
            ran = [float(time) for time in verified["time_s"]]
            run = [(ran[1] - ran[0], len(ran) - 1)]
            errors = [[Decimal(value) for value in values] for values in verified["error_K"][name]]
            true = solve(number, run)
            own = [[float(t + e) for t, e in zip(*pair, strict=True)] for pair in zip(true, errors, strict=True)]
        found.append(Responses(_times(parts), exact, ran, errors, own))
    return found


def _work(program: Program) -> int:
    """What a sample takes the reference, in samples of a component of order 1."""
    if program.network is not None:
        return 2 * program.network.orders
    return sum(component.order * component.substeps for component in program.components)


Solve = Callable[[int, Parts], list[list[Decimal]]]
"""Exact rises of a component, by its number, at every level, at the points of some parts."""


def _component_responses(program: Program) -> Solve:
    def solve(number: int, parts: Parts) -> list[list[Decimal]]:
        start = Decimal(starts(program)[number]) / 1000
        component = program.model.components[number]
        return [exact_response(component, level, start, parts) for level in levels(program.model)]

    return solve


def _network_responses(program: Program) -> Solve:
    """By matrix exponential in float64; rounded, so that the report is the same on every machine."""
    model = program.model
    solution = NetworkSolution(model)
    room = program.channels[0].neutral / 1000.0
    begin = {n: start / 1000.0 + room for n, start in zip(model.component_names, starts(program), strict=True)}

    def solve(number: int, parts: Parts) -> list[list[Decimal]]:
        times = np.array(_times(parts))
        name = model.component_names[number]
        made = []
        for level in levels(model):
            shown = solution.simulate_times(times, np.full(times.size, level), room, start=begin)[name] - room
            made.append([Decimal(f"{value:.9f}") for value in shown])
        return made

    return solve


def _times(parts: Parts) -> list[float]:
    times = [0.0]
    for interval, count in parts:
        begin = times[-1]
        times += [begin + interval * (k + 1) for k in range(count)]
    return times


def exact_response(component: Component, pwm: int, start: Decimal, parts: Parts) -> list[Decimal]:
    """The exact rise at constant PWM, in decimals (a float64 solution would differ in its last digits by machine).

    Parameters
    ----------
    component, pwm, start
        What runs, and from which rise at rest.
    parts
        Intervals in s, and how many points follow at each.
    """
    n = component.order
    generator = np.full((n + 1, n + 1), Decimal(0))
    generator[range(n - 1), range(1, n)] = Decimal(1)
    generator[n - 1, :n] = [-Decimal(a) for a in component.denominator([pwm])[0, :0:-1].tolist()]
    generator[n - 1, n] = Decimal(float(component.effective_gain([pwm])[0])) * pwm
    state = np.array([start, *[Decimal(0)] * (n - 1), Decimal(1)])
    result = [start]
    with localcontext(EXACT):
        for interval, count in parts:
            scaled = generator * Decimal(interval)
            halvings = max(0, ceil(log2(float(np.abs(scaled).sum(axis=1).max()) + 1e-9)) + 1)
            scaled = scaled / Decimal(2**halvings)
            step = term = np.array([[Decimal(int(i == j)) for j in range(n + 1)] for i in range(n + 1)])
            for k in range(1, 25):
                term = term @ scaled / Decimal(k)
                step = step + term
            for _ in range(halvings):
                step = step @ step
            for _ in range(count):
                state = step @ state
                result.append(state[0])
    return result
