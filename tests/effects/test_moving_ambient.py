"""Effects beside an ambient that moves through the parts' dynamics, against their equations written down here."""

from __future__ import annotations

import json
from functools import cache
from typing import get_args

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gen.arrays import FloatArray
from gen.coefficients import Coefficients, parse
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.model.extended import ExtendedSolution
from gen.reference.model import ReferenceModel
from gen.verification.held import HeldSolution
from tests.effects.test_hand_written_equations import COMPONENT, DOCUMENT, SHOWN, TS, gain, poles

#: Seconds, PWM and ambient in degC.
PROFILE = ((60, 180, 25.0), (60, 180, 40.0), (90, 0, 5.0), (30, -120, 31.25))
FAN, COOLING = 1.5, {1: 0.004, 2: 0.003}
SECONDS, LEVELS, ROOMS = zip(*PROFILE, strict=True)
SAMPLES = [round(seconds / TS) for seconds in SECONDS]
PWM = np.repeat(LEVELS, SAMPLES)
ROOM: FloatArray = np.repeat(ROOMS, SAMPLES)


@cache
def coefficients() -> Coefficients:
    effects = [
        {"name": "airflow", "component": COMPONENT[n], "parameters": {"channel": "fan", "cooling_per_s": COOLING[n]}}
        for n in (1, 2)
    ]
    return parse(json.dumps({**DOCUMENT, "effects": effects}).encode())


@cache
def by_hand(order: int) -> FloatArray:
    """A(d/dt) T = K |PWM| + A(0) ambient + a1 q, where q = -k fan (T - ambient) and a1 is A's linear coefficient."""
    y, found = np.array([SHOWN] + [0.0] * (order - 1)), [SHOWN]
    for seconds, pwm, room in PROFILE:
        rates = poles(order, abs(pwm))
        last, linear = float(np.prod(rates)), 1.0 if order == 1 else sum(rates)

        def slope(
            _: float, x: FloatArray, pwm: int = pwm, room: float = room, a: float = last, b: float = linear
        ) -> FloatArray:
            heat = gain(order, abs(pwm)) * abs(pwm) - b * COOLING[order] * FAN * (x[0] - room)
            return np.array([heat - a * (x[0] - room)] if order == 1 else [x[1], heat - a * (x[0] - room) - b * x[1]])

        times = np.arange(1, round(seconds / TS) + 1) * TS
        solved = solve_ivp(slope, (0.0, times[-1]), y, t_eval=times, rtol=1e-11, atol=1e-12)
        found += solved.y[0].tolist()
        y = solved.y[:, -1]
    return np.array(found)


@pytest.mark.parametrize("order", [1, 2])
def test_the_solution_that_judges_the_board(order: int) -> None:
    model = coefficients().model
    above, rooms = np.array([SHOWN - ROOM[0]]), ROOM[:, None]
    held = HeldSolution(model, coefficients().effects, dict.fromkeys(COMPONENT.values(), above), rooms[0])
    shown = []
    for pwm, room in zip(PWM, rooms, strict=True):
        held.step(np.array([pwm]), room, {"fan": np.array([FAN])})
        shown.append(held.shown()[model.component_names.index(COMPONENT[order]), 0] + room[0])
    np.testing.assert_allclose(shown, by_hand(order)[1:], rtol=0, atol=1e-7)


@pytest.mark.parametrize("order", [1, 2])
def test_the_exact_solution_of_runs(order: int) -> None:
    time: FloatArray = np.arange(PWM.size + 1, dtype=np.float64) * TS
    room: FloatArray = np.append(ROOM, ROOM[-1])
    solution = ExtendedSolution(coefficients().model, coefficients().effects)
    shown = solution.simulate_times(
        time, np.append(PWM, 0), room, room, {"fan": np.full(time.size, FAN)},
        dict.fromkeys(COMPONENT.values(), SHOWN - ROOM[0]),
    )[COMPONENT[order]]  # fmt: skip
    # What drives an effect within a sample is the mean of its ends, also where the room jumps by 35 K between two.
    np.testing.assert_allclose(shown, by_hand(order), rtol=0, atol=0.03)


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
def test_the_board(arithmetic: Arithmetic) -> None:
    program = lower(coefficients(), arithmetic, "table")
    names = program.model.component_names
    start = {name: [round((SHOWN - ROOM[0]) * 1000)] for name in names}
    told = np.rint(np.array([ROOM, np.full(ROOM.size, FAN)]) * 1000.0).astype(np.int64)
    board = ReferenceModel(program, start, told[:, :1])
    shown = []
    for sample, pwm in enumerate(PWM):
        board.set_channels(told[:, sample : sample + 1])
        board.step(np.array([pwm]))
        shown.append(board.readings[:, 0])
    found = np.array(shown)
    for order, name in COMPONENT.items():
        np.testing.assert_allclose(found[:, names.index(name)], by_hand(order)[1:], rtol=0, atol=2e-3)
