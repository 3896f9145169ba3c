"""The board's reference against the exact solution for every effect, and that against hand-written equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gen.arrays import FloatArray
from gen.lowering.effects.program import Channel
from gen.lowering.kinds import Arithmetic
from gen.lowering.program import Program
from gen.reference.model import ReferenceModel
from gen.verification.effects import course_with_effects
from gen.verification.held import HeldSolution
from tests.effects.cases import CASES, case, lowered

LIMIT_K = {"fixed": 1e-5, "float": 1e-3}
#: Channels that keep the parts within twice what the baseline can reach, in thousandths.
REALISTIC = {
    "current_A": (-12_000, 12_000),
    "voltage_V": (18_000, 30_000),
    "fan": (0, 2_000),
    "gearbox_degC": (0, 90_000),
}


def _realistic(program: Program) -> Program:
    assert program.effects is not None

    def narrowed(channel: Channel) -> Channel:
        low, high = REALISTIC.get(channel.column, (channel.low, channel.high))
        return replace(channel, low=low, high=high)

    return replace(program, effects=replace(program.effects, channels=tuple(map(narrowed, program.effects.channels))))


@pytest.mark.parametrize("arithmetic", get_args(Arithmetic))
@pytest.mark.parametrize("label", CASES)
def test_every_effect_stays_within_the_limit(label: str, arithmetic: Arithmetic) -> None:
    program = _realistic(lowered(label, arithmetic))
    course = course_with_effects(program, case(label).effects, lanes=6, length=120)
    assert max(course.largest().values()) < LIMIT_K[arithmetic]
    assert min(course.error_K[name][-1] for name in course.error_K) > 0.0, "lanes must have counted to the end"


# Slope of (T, z) given T, z, second: T' of the casing or bearing without the effect is added to it.
Heat = Callable[[float, float, float], tuple[float, float]]
PWM, START_K, SECONDS = -180, 20.0, 300.0
BY_HAND: dict[str, tuple[str, Heat, float]] = {
    "hidden_node": ("casing", lambda T, z, t: (6e-3 * z, (180 / 255 - z) / 1200.0), 0.0),
    "radiation": (
        "casing",
        lambda T, z, t: (-1e-4 * (((T + 298.15) / 100) ** 4 - (298.15 / 100) ** 4), 0.0),
        0.0,
    ),
    "initial_state": ("casing", lambda T, z, t: (1e-3 * z, -z / 600.0), START_K),
    "airflow": ("casing", lambda T, z, t: (-3e-4 * 1.5 * T, 0.0), 0.0),
}


@pytest.mark.parametrize("label", BY_HAND)
def test_the_exact_solution_and_the_board_obey_hand_written_equations(label: str) -> None:
    name, heat, inner = BY_HAND[label]
    coefficients, program = case(label), lowered(label, "fixed")
    component = coefficients.model.component(name)
    rate = float(component.denominator([abs(PWM)])[0, 1])
    drive = float(component.effective_gain([abs(PWM)])[0]) * abs(PWM)

    def slope(t: float, y: FloatArray) -> list[float]:
        warmer, dz = heat(float(y[0]), float(y[1]), t)
        return [drive - rate * y[0] + warmer, dz]

    solved = solve_ivp(slope, (0.0, SECONDS), [START_K, inner], method="DOP853", rtol=1e-12, atol=1e-12)
    assert program.effects is not None
    told = np.array([[25_000] if c.column == "ambient_degC" else [1_500] for c in program.effects.channels])
    names = program.model.component_names
    board = ReferenceModel(program, {n: [round(START_K * 1000)] for n in names}, told)
    exact = HeldSolution(
        program.model, coefficients.effects, dict.fromkeys(names, np.array([START_K])), told[0] / 1000.0
    )
    channels = {c.column: told[i] / 1000.0 for i, c in enumerate(program.effects.channels)}
    for _ in range(round(SECONDS / 0.25)):
        board.set_channels(told)
        board.step(np.array([PWM]))
        exact.step(np.array([PWM]), told[0] / 1000.0, channels)
    place = names.index(name)
    plain = START_K + (drive / rate - START_K) * -np.expm1(-rate * SECONDS)
    assert abs(solved.y[0, -1] - plain) > 0.05, "the effect must be visible"
    assert exact.shown()[place, 0] == pytest.approx(solved.y[0, -1], abs=1e-9)
    assert board.rises[place, 0] == pytest.approx(solved.y[0, -1], abs=1e-5)


def test_what_leaves_its_range_is_held_counted_and_flagged() -> None:
    program = lowered("load_heating", "fixed")
    board = ReferenceModel(program, [0], np.array([[25_000], [10**9]]))
    board.step(np.array([0]))
    assert program.effects is not None
    record = board.record()
    assert record["channel.current_A"][0] == program.effects.channels[1].high
    assert record["limited"][0] > 0
    assert record["flags"][0] & 0x10
    assert not board.within_ranges[0]
