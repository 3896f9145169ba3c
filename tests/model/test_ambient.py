"""An ambient that moves: its changes pass each component's own dynamics, against an integration."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gen.arrays import FloatArray
from gen.coefficients import parse
from gen.model import Component, ThermalModel
from gen.model.exact import ExactSolution
from tests.model.examples import EXAMPLES, model

TIMES = np.array([0.0, 40.0, 41.0, 300.0, 700.0, 1500.0, 1500.25, 4000.0])
PWM = np.array([0, 200, 200, 90, 90, 255, 0, 0])
AMBIENT = np.array([21.0, 21.0, 24.5, 24.5, 12.0, 35.0, 30.25, 30.25])
START_K = 4.5
COMPONENTS = [("my1016", "brush"), ("my1016", "casing"), ("two_mass", "winding"), ("two_mass", "housing")]


def moving(name: str) -> ThermalModel:
    return replace(model(name), ambient_at_once=False)


def integrated(component: Component) -> FloatArray:
    """Temperature at :data:`TIMES`, degC: A(d/dt) T = K |PWM| + A(0) ambient, as it is written."""
    y = np.zeros(component.order)
    y[0] = AMBIENT[0] + START_K
    found = [y[0]]
    for k, step in enumerate(np.diff(TIMES)):
        a = component.denominator(PWM[k : k + 1])[0]
        drive = component.effective_gain(PWM[k : k + 1])[0] * PWM[k] + a[-1] * AMBIENT[k]

        def slope(_: float, x: FloatArray, a: FloatArray = a, drive: float = drive) -> FloatArray:
            return np.append(x[1:], drive - a[:0:-1] @ x)

        scale = np.abs(a[-1]) ** (np.arange(component.order) / component.order)
        y = solve_ivp(slope, (0.0, step), y, method="Radau", rtol=1e-11, atol=1e-10 * scale).y[:, -1]
        found.append(y[0])
    return np.array(found)


@pytest.mark.parametrize(("name", "part"), COMPONENTS)
def test_a_change_of_the_ambient_passes_the_dynamics(name: str, part: str) -> None:
    thermal = moving(name)
    rise = ExactSolution(thermal).over_ambient(TIMES, PWM, AMBIENT, {part: START_K})[part]
    np.testing.assert_allclose(rise + AMBIENT, integrated(thermal.component(part)), rtol=0, atol=2e-6)


@pytest.mark.parametrize(("name", "part"), COMPONENTS)
def test_at_once_it_is_added(name: str, part: str) -> None:
    thermal = replace(model(name), ambient_at_once=True)
    solution = ExactSolution(thermal)
    rise = solution.over_ambient(TIMES, PWM, AMBIENT, {part: START_K})[part]
    np.testing.assert_array_equal(rise, solution.simulate_times(TIMES, PWM, {part: START_K})[part])


@pytest.mark.parametrize("name", ["my1016", "two_mass"])
def test_one_that_stays_gives_the_rise_that_it_gave(name: str) -> None:
    still = np.full(TIMES.size, 17.25)
    thermal = moving(name)
    rises = ExactSolution(thermal).over_ambient(TIMES, PWM, still)
    for part, before in ExactSolution(thermal).simulate_times(TIMES, PWM).items():
        np.testing.assert_allclose(rises[part], before, rtol=0, atol=1e-10)


def test_lanes_and_grid_are_the_same_solution() -> None:
    thermal = moving("my1016")
    random = np.random.default_rng(7)
    pwm, over = random.integers(0, 256, (3, 400)), random.uniform(-30.0, 15.0, (3, 400))
    lanes = ExactSolution(thermal).simulate(pwm, {"brush": np.array([0.0, 5.0, -3.0])}, over)
    times = np.arange(401) * thermal.sample_time
    for lane, start in enumerate([0.0, 5.0, -3.0]):
        alone = ExactSolution(thermal).simulate(pwm[lane], {"brush": start}, over[lane])
        held = ExactSolution(thermal).simulate_times(
            times, np.append(pwm[lane], 0), {"brush": start}, np.append(over[lane], 0.0)
        )
        for part, rise in lanes.items():
            np.testing.assert_allclose(rise[lane], alone[part], rtol=0, atol=1e-10)
            np.testing.assert_allclose(rise[lane], held[part], rtol=0, atol=1e-10)


def test_the_reference_is_the_fixed_ambient_or_the_room() -> None:
    thermal = moving("my1016")
    assert thermal.ambient_reference == 30.0
    assert thermal.ambient_over == (-40.0, 20.0)
    assert replace(thermal, ambient_fixed=None).ambient_reference == 25.0
    assert replace(thermal, ambient_fixed=None, domain_ambient=(-40.0, 10.0)).ambient_reference == 10.0
    assert replace(thermal, ambient_at_once=True).ambient_over == (0.0, 0.0)


@pytest.mark.parametrize(("says", "effect"), [(False, False), (True, False), (False, True)])
def test_a_file_says_whether_its_parts_follow_the_ambient_at_once(*, says: bool, effect: bool) -> None:
    """By the key, or by an effect that says itself how the measured ambient acts."""
    tree = json.loads((EXAMPLES / "my1016" / "coeffs.json").read_text())
    tree["ambient"] = {"fixed_degC": 30.0, "channel": "ambient_degC"} | ({"at_once": True} if says else {})
    if effect:
        tree["effects"] = [{"name": "ambient", "component": "casing", "parameters": {"delayed": False}}]
    assert parse(json.dumps(tree).encode()).model.ambient_at_once is (says or effect)
