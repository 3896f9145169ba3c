"""The motor's physics: an independent integration, the balance of energy, and what no passive body can do."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from gen.rig import NODES, Fault, HeatPath, HiddenPart, Motor, MotorConfig, my1016
from gen.rig.losses import Condition, Operation, heat, settled_speed

AMBIENT = 22.0
PARAMETERS = my1016()
RATED = 2650.0
PLAIN = MotorConfig(max_step_s=1.0)


def conductance(path: HeatPath, speed: float) -> float:
    return path.still_W_per_K + path.forced_W_per_K * float(speed**path.exponent)


class Reference:
    """The same equations, put together path by path and left to a general integrator with tight tolerances."""

    def __init__(self, duty: float, load: float, area: float, loss_per_K: float) -> None:
        self.duty, self.load, self.area, self.loss_per_K = duty, load, area, loss_per_K
        self.goal = settled_speed(PARAMETERS, duty, 1.0, load)

    def heats(self, t: float, T: np.ndarray, start: float) -> tuple[dict[str, float], float]:
        speed = self.goal + (start - self.goal) * np.exp(-t / PARAMETERS.electrical.spin_time_constant_s)
        factor = 1.0 + self.loss_per_K * (T[NODES.index("bearing")] - 30.0)
        made = heat(PARAMETERS, Operation(speed, self.duty, 1.0, self.load), Condition(losses=factor))
        watts = dict(zip(NODES, made.nodes, strict=True))
        watts["winding"] += made.current_A**2 * 0.35 * (1.0 + 0.0039 * (T[0] - 25.0))
        return watts, speed

    def slope(self, t: float, T: np.ndarray, start: float) -> np.ndarray:
        at = dict(zip(NODES, T, strict=True)) | {"ambient": AMBIENT}
        watts, speed = self.heats(t, T, start)
        for path in PARAMETERS.paths:
            flow = conductance(path, speed) * (at[path.a] - at[path.b])
            watts[path.a] -= flow
            if path.b != "ambient":
                watts[path.b] += flow
        watts["casing"] -= 5.670374419e-8 * self.area * ((at["casing"] + 273.15) ** 4 - (AMBIENT + 273.15) ** 4)
        return np.array([watts[name] / PARAMETERS.capacities_J_per_K[name] for name in NODES])


@pytest.mark.parametrize(
    ("load", "area", "loss_per_K"), [(0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.0, 0.03, -0.004), (0.6, 0.02, 0.003)]
)
def test_motor_agrees_with_a_general_integrator(load: float, area: float, loss_per_K: float) -> None:
    motor = Motor(MotorConfig(radiating_area_m2=area, loss_per_K=loss_per_K), ambient_degC=AMBIENT)
    T, speed, worst = motor.state, 0.0, 0.0
    for pwm, seconds in ((200, 40.0), (90, 700.0), (255, 1500.0), (140, 600.0)):
        reference = Reference(pwm / 255, load, area, loss_per_K)
        solved = solve_ivp(
            reference.slope, (0.0, seconds), T, args=(speed,), method="LSODA", rtol=1e-9, atol=1e-9, first_step=1e-3
        )
        T, speed = solved.y[:, -1], reference.goal
        motor.step(pwm, seconds, load_Nm=load)
        worst = max(worst, float(np.abs(motor.state - T).max()))
    assert worst < 5e-3


@pytest.mark.parametrize("pwm", [180, 60])
def test_heat_in_is_heat_stored_and_heat_given_to_ambient(pwm: int) -> None:
    """Trapezia over the motor's own record of a warm-up close the balance."""
    motor, dt, speed = Motor(ambient_degC=AMBIENT), 0.25, pwm / 255
    motor.step(pwm, 5.0)  # the speed settles
    made = heat(PARAMETERS, Operation(speed, speed))
    states = [motor.state]
    for _ in range(4000):
        motor.step(pwm, dt)
        states.append(motor.state)
    record = np.array(states)
    copper = made.current_A**2 * 0.35 * (1.0 + 0.0039 * (record[:, 0] - 25.0))
    heat_J = np.trapezoid(sum(made.nodes) + copper, dx=dt)
    out_J = sum(
        np.trapezoid(conductance(path, speed) * (record[:, NODES.index(path.a)] - AMBIENT), dx=dt)
        for path in PARAMETERS.paths
        if path.b == "ambient"
    )
    capacities = np.array([PARAMETERS.capacities_J_per_K[name] for name in NODES])
    stored_J = float(capacities @ (record[-1] - record[0]))
    assert out_J > 0.05 * heat_J
    assert heat_J == pytest.approx(stored_J + out_J, rel=1e-5)


@settings(max_examples=15, deadline=None)
@given(
    pwm=st.lists(st.integers(-255, 255), min_size=1, max_size=6),
    load=st.floats(0.0, 1.0),
    ambient=st.floats(-10.0, 45.0),
    start=st.floats(-10.0, 120.0),
)
def test_nothing_gets_colder_than_the_coldest_and_hotter_stays_hotter(
    pwm: list[int], load: float, ambient: float, start: float
) -> None:
    cool = Motor(PLAIN, start_degC=dict.fromkeys(NODES, start), ambient_degC=ambient)
    warm = Motor(PLAIN, start_degC=dict.fromkeys(NODES, start + 5.0), ambient_degC=ambient)
    for level in pwm:
        for motor in (cool, warm):
            motor.step(level, 200.0, load_Nm=load)
        assert cool.state.min() >= min(start, ambient) - 1e-9
        assert np.all(warm.state >= cool.state - 1e-9)
        assert np.all(np.isfinite(warm.state))


@settings(max_examples=15, deadline=None)
@given(temperatures=st.lists(st.floats(0.0, 150.0), min_size=6, max_size=6))
def test_at_rest_the_hottest_and_the_coldest_part_approach_ambient(temperatures: list[float]) -> None:
    motor = Motor(PLAIN, start_degC=dict(zip(NODES, temperatures, strict=True)), ambient_degC=25.0)
    spread = np.abs(motor.state - 25.0).max()
    for _ in range(5):
        motor.step(0, 600.0)
        now = np.abs(motor.state - 25.0).max()
        assert now <= spread + 1e-9
        spread = now


def test_a_hot_motor_cools_more_slowly_at_rest_than_turning() -> None:
    hot = dict.fromkeys(NODES, 90.0)
    rest, turning = Motor(start_degC=hot), Motor(start_degC=hot)
    idle = Motor(start_degC=dict.fromkeys(NODES, 30.0))
    rest.step(0, 3600.0)
    turning.step(255, 3600.0)
    idle.step(255, 3600.0)
    # The turning motor also makes heat: what the same time makes of a cold motor is taken off.
    cooled = 90.0 - (turning.state - (idle.state - 30.0))
    assert np.all(
        cooled[[NODES.index(n) for n in ("winding", "brush", "magnet", "casing")]]
        > 1.05 * (90.0 - rest.state)[[0, 1, 3, 4]]
    )


def test_settled_temperatures_change_smoothly_with_speed_down_to_rest() -> None:
    def settled(pwm: int) -> np.ndarray:
        motor = Motor(MotorConfig(max_step_s=5.0))
        motor.step(pwm, 25_000.0)
        return motor.state

    steps = np.diff([settled(pwm) for pwm in range(15, 256, 15)], axis=0)
    assert np.abs(steps).max() < 10.0
    assert np.abs(np.diff(steps, axis=0)).max() < 4.0
    low = np.array([settled(pwm) for pwm in (0, 1, 2, 4, 8, 15)])
    assert np.all(np.diff(low, axis=0) > 0.0)
    assert np.all(np.diff(low, axis=0) < 8.0)


def test_load_slows_the_motor_draws_current_and_heats_by_its_square() -> None:
    rises = []
    for load in (0.0, 0.2, 0.4, 0.8):
        motor = Motor(MotorConfig(max_step_s=5.0))
        drive = motor.step(255, 200.0, load_Nm=load)
        rises.append((drive.current_A, drive.speed_rpm, motor.temperatures["winding"]))
    currents, speeds, windings = (np.array(column) for column in zip(*rises, strict=True))
    np.testing.assert_allclose(np.diff(currents), np.diff([0.0, 0.2, 0.4, 0.8]) / 0.0865, rtol=0.05)
    assert speeds[0] == pytest.approx(RATED)
    assert np.all(np.diff(speeds) < -30.0)
    extra = (windings - windings[0])[1:]
    squares = currents[1:] ** 2 - currents[0] ** 2
    np.testing.assert_allclose(extra / extra[-1], squares / squares[-1], atol=0.1)


def test_too_much_load_stalls_the_motor_and_the_winding_limits_the_current() -> None:
    drive = Motor().step(51, 5.0, load_Nm=10.0)
    assert drive.speed_rpm == 0.0
    assert drive.current_A == pytest.approx(24.0 * 0.2 / 0.35)


def test_supply_voltage_scales_speed() -> None:
    assert Motor().step(255, 5.0, voltage_V=12.0).speed_rpm == pytest.approx(RATED / 2)
    assert Motor().step(255, 5.0, voltage_V=0.0).speed_rpm == 0.0
    assert Motor().step(255, 5.0, voltage_V=12.0).voltage_V == pytest.approx(12.0)  # what its instrument shows


def test_rotor_follows_within_a_fraction_of_a_second_and_reverses() -> None:
    motor = Motor()
    assert 0.5 * RATED < motor.step(255, 0.25).speed_rpm < RATED
    assert motor.step(255, 1.0).speed_rpm == pytest.approx(RATED, rel=0.01)
    assert motor.step(-255, 2.0).speed_rpm == pytest.approx(-RATED, rel=0.01)
    assert 0.0 < motor.revolutions < 3.25 * RATED / 60.0


def test_one_long_step_is_many_short_ones() -> None:
    long, short = Motor(), Motor()
    for pwm in (120, 0, -255):
        long.step(pwm, 50.0)
        for _ in range(200):
            short.step(pwm, 0.25)
    np.testing.assert_allclose(long.state, short.state, rtol=0.0, atol=1e-10)
    assert long.revolutions == pytest.approx(short.revolutions)


def test_bad_inputs_are_refused() -> None:
    for bad in (
        {"pwm": 256},
        {"pwm": -300},
        {"dt_s": 0.0},
        {"load_Nm": -1.0},
        {"airflow_m_s": -1.0},
        {"voltage_V": -1.0},
    ):
        with pytest.raises(ValueError, match="expected"):
            Motor().step(**({"pwm": 100, "dt_s": 1.0} | bad))
    with pytest.raises(ValueError, match="no node is called 'rotor'"):
        Motor(start_degC={"rotor": 20.0})
    with pytest.raises(ValueError, match="no heat path"):
        MotorConfig(coupling=(HeatPath(a="brush", b="hidden", still_W_per_K=1.0),))


def rise(config: MotorConfig, pwm: int = 153, seconds: float = 3600.0, **inputs: float) -> dict[str, float]:
    motor = Motor(config)
    motor.step(pwm, seconds, **inputs)
    return {name: value - 30.0 for name, value in motor.temperatures.items()}


def test_each_deviation_does_what_its_name_says() -> None:
    plain = rise(PLAIN)

    def with_(**changes: object) -> MotorConfig:
        return MotorConfig(max_step_s=1.0, **changes)  # type: ignore[arg-type]

    assert rise(with_(radiating_area_m2=0.02))["casing"] < plain["casing"] - 1.0
    assert rise(with_(loss_per_K=0.01))["casing"] > plain["casing"] + 0.5
    assert rise(with_(wear_per_hour=1.0))["brush"] > plain["brush"] + 0.5
    assert rise(PLAIN, airflow_m_s=2.0)["casing"] < plain["casing"] - 3.0
    assert rise(PLAIN, voltage_V=20.0)["casing"] != pytest.approx(plain["casing"], abs=0.5)
    assert rise(PLAIN, load_Nm=0.3)["winding"] > plain["winding"] + 3.0
    assert rise(PLAIN, pwm=-153) == pytest.approx(plain)
    assert rise(with_(reverse_losses=1.5), pwm=-153)["casing"] > plain["casing"] + 1.0
    assert rise(with_(reverse_losses=1.5)) == pytest.approx(plain)
    coupling = (HeatPath(a="brush", b="bearing", still_W_per_K=0.5),)
    coupled = rise(with_(coupling=coupling))
    assert coupled["brush"] - coupled["bearing"] < 0.6 * (plain["brush"] - plain["bearing"])
    # Standstill: nothing while turning, faster cooling at rest.
    assert rise(with_(standstill_cooling=2.0))["casing"] == pytest.approx(plain["casing"], abs=0.05)
    hot = dict.fromkeys(NODES, 80.0)
    ends = []
    for factor in (0.5, 1.0, 2.0):
        motor = Motor(with_(standstill_cooling=factor), start_degC=hot)
        motor.step(0, 1800.0)
        ends.append(motor.temperatures["casing"])
    assert ends[0] > ends[1] + 2.0 > ends[2] + 4.0


def test_a_hidden_part_makes_its_neighbour_go_on_rising_after_cut_off_and_leaves_it_alone_when_settled() -> None:
    hidden = HiddenPart(heat_from="winding", share=0.6, node="brush", capacity_J_per_K=200.0, conductance_W_per_K=0.05)
    motor, plain = Motor(MotorConfig(hidden=hidden)), Motor()
    for each in (motor, plain):
        each.step(153, 7200.0)
    before = motor.temperatures["brush"], plain.temperatures["brush"]
    after = []
    for each in (motor, plain):
        each.step(0, 300.0)
        after.append(each.temperatures["brush"])
    assert after[0] > before[0] + 0.5
    assert after[1] < before[1]
    own = MotorConfig(hidden=HiddenPart(heat_from="brush", share=0.9, node="brush"), max_step_s=5.0)
    settled = [Motor(own), Motor(MotorConfig(max_step_s=5.0))]
    for each in settled:
        each.step(153, 30_000.0)
    assert settled[0].temperatures["brush"] == pytest.approx(settled[1].temperatures["brush"], abs=1e-3)
    assert settled[0].temperatures["hidden"] > settled[0].temperatures["brush"] + 5.0


def test_deviations_and_faults_combine() -> None:
    everything = MotorConfig(
        faults=(Fault("bearing"), Fault("brush")),
        hidden=HiddenPart(),
        coupling=(HeatPath(a="hidden", b="ambient", still_W_per_K=0.01),),
        standstill_cooling=0.5,
        radiating_area_m2=0.01,
        loss_per_K=-0.001,
        reverse_losses=1.2,
        wear_per_hour=0.01,
    )
    motor = Motor(everything)
    for pwm in itertools.chain(
        (255, -120, 0, 30),
    ):
        motor.step(pwm, 300.0, load_Nm=0.1, voltage_V=23.0, airflow_m_s=0.5, ambient_degC=18.0)
    assert 18.0 < motor.state.min() < motor.state.max() < 120.0
