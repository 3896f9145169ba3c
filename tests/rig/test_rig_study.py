"""The motor against the study's tables: what it was calibrated to, checked through the simulation in time."""

from __future__ import annotations

import json
from functools import cache
from importlib import resources

import numpy as np
import pytest
from scipy import signal

from gen.rig import MEASURED, Motor, MotorConfig, my1016
from gen.rig.calibrate.unknowns import UNKNOWNS
from tests.model.published import PWM, SPEEDS_PERCENT, TRANSFER_FUNCTIONS
from tests.rig.published import AMBIENT_DEGC, DURATION_S, MEASURED_DEGC

TIME_S = np.arange(0.0, DURATION_S + 1.0, 30.0)


@cache
def recording(pwm: int) -> dict[str, np.ndarray]:
    """Three hours from cold, then on until nothing changes any more; the last entry is the settled temperature."""
    motor = Motor(MotorConfig(max_step_s=1.0))
    rows = [motor.state]
    for _ in TIME_S[1:]:
        motor.step(pwm, 30.0)
        rows.append(motor.state)
    motor.step(pwm, 24_000.0)
    rows.append(motor.state)
    return {name: np.array(rows)[:, motor.nodes.index(name)] for name in MEASURED}


@pytest.mark.parametrize("component", MEASURED)
@pytest.mark.parametrize(("place", "pwm"), list(enumerate(PWM)), ids=[f"{s} %" for s in SPEEDS_PERCENT])
def test_temperatures_are_within_2_K_of_those_measured(component: str, place: int, pwm: int) -> None:
    values = recording(pwm)[component]
    assert values[-2] == pytest.approx(MEASURED_DEGC[component][place], abs=2.0)
    assert values[-1] == pytest.approx(MEASURED_DEGC[component][place], abs=2.0)


@pytest.mark.parametrize("component", MEASURED)
@pytest.mark.parametrize(("place", "pwm"), list(enumerate(PWM)), ids=[f"{s} %" for s in SPEEDS_PERCENT])
def test_time_to_63_percent_is_near_that_of_the_identified_transfer_function(
    component: str, place: int, pwm: int
) -> None:
    numerator, denominator = TRANSFER_FUNCTIONS[component][place]
    _, theirs = signal.step(([numerator], denominator), T=TIME_S)
    mine = recording(pwm)[component][:-1] - AMBIENT_DEGC
    tolerance = 0.22 if component == "brush" else 0.12
    assert time_to_63(mine) == pytest.approx(time_to_63(theirs), rel=tolerance)


def time_to_63(rise: np.ndarray) -> float:
    assert np.all(np.diff(rise) > -1e-9), "a step from cold only warms"
    return float(np.interp(0.6321205588, rise / rise[-1], TIME_S))


def test_brush_is_hottest_near_60_percent_and_cooler_at_full_speed_for_two_reasons() -> None:
    settled = [recording(pwm)["brush"][-1] for pwm in PWM]
    assert max(settled) == settled[2]
    # Were convection the same at every speed as at 60 %, full speed would be clearly hotter than it is.
    frozen = json.loads(my1016().model_dump_json())
    for path in frozen["paths"]:
        path["still_W_per_K"] += path["forced_W_per_K"] * 0.6 ** path["exponent"]
        path["forced_W_per_K"] = 0.0
    motor = Motor(MotorConfig(parameters=type(my1016()).model_validate(frozen), max_step_s=5.0))
    motor.step(255, 40_000.0)
    assert motor.temperatures["brush"] > settled[4] + 4.0


def test_no_load_current_stays_below_the_measured_limit_at_every_speed() -> None:
    motor = Motor()
    for pwm in range(1, 256):
        assert 0.3 < motor.step(pwm, 5.0).current_A < 0.7


def test_speed_is_in_proportion_to_pwm_without_load() -> None:
    motor = Motor()
    for pwm in (255, 100, 1, -77):
        assert motor.step(pwm, 5.0).speed_rpm == pytest.approx(2650.0 * pwm / 255.0, abs=0.01)


def test_calibration_compares_with_the_numbers_that_the_study_printed() -> None:
    targets = json.loads((resources.files("gen.rig") / "targets.json").read_text(encoding="utf-8"))
    assert {name: tuple(values) for name, values in targets["table_4_1_degC"].items()} == MEASURED_DEGC
    for name, functions in TRANSFER_FUNCTIONS.items():
        found = [(entry["numerator"], tuple(entry["denominator"])) for entry in targets["table_4_3"][name]]
        assert found == list(functions)


def test_calibrated_parameters_lie_within_what_such_a_motor_can_have() -> None:
    parameters = my1016()
    bounds = {unknown.name: (unknown.low, unknown.high) for unknown in UNKNOWNS}
    for name, capacity in parameters.capacities_J_per_K.items():
        if name != "air":
            low, high = bounds[f"capacity.{name}"]
            assert low * 0.999 <= capacity <= high * 1.001
    total = sum(parameters.capacities_J_per_K.values())
    assert 0.35 <= total / 1000.0 / 2.0 <= 0.6, "2 kg of steel, copper and ferrite hold 0.39..0.8 kJ/(kg K)"
    for path in parameters.paths:
        low, high = bounds[f"still.{path.a}-{path.b}"]
        assert low * 0.999 <= path.still_W_per_K <= high * 1.001
