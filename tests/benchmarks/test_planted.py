"""What is planted on the random motors: each change against a solution by hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from benchmarks.plants.course import Course, course
from benchmarks.plants.laws import Form, Law
from benchmarks.plants.plant import Plant, Source, Surface
from benchmarks.plants.planted import faults, losses, outside, paths, sensing, surroundings
from benchmarks.plants.planted.altered import Altered
from benchmarks.plants.planted.change import Change, Steps
from benchmarks.plants.profiles import Profile
from benchmarks.plants.rooms import Room
from gen.arrays import FloatArray
from tests.benchmarks.test_plants import LINEAR, LOSSES, by_hand

LONG = 60 * 3600.0
NODE = Plant(
    names=("part",),
    capacity=(200.0,),
    links=(),
    surfaces=(Surface(0, Law(0.5)),),
    sources=(Source(0, "friction", 40.0),),
    losses=LOSSES,
    sensed=(0,),
)
"""One node with 40 W for each unit of friction and 0.5 W/K to the room."""
FRICTION = 40.0 * LOSSES.friction(200 / 255)
"""W at PWM 200."""


def settled(plant: Plant, change: Change, pwm: int, signals: Mapping[str, float] | None = None) -> FloatArray:
    """Temperatures after a long time at one PWM in a room of 21 degC, what varies being held."""
    held = {name: Steps(0.0, (0.0,), (value,)) for name, value in (signals or {}).items()}
    motor = Altered(plant, (change,), held)
    return np.asarray(course(motor, Profile("run", ((pwm, LONG),)), Room(21.0), 3600.0).temperature[-1])


def run_of(motor: Altered | Plant, *holds: tuple[int, float], row_s: float = 2.0) -> Course:
    return course(motor, Profile("run", holds), Room(21.0), row_s)


def solved(a: FloatArray, heat: FloatArray, outlet: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.solve(a, -(heat + 21.0 * outlet)))


def test_an_added_mass_settles_as_a_fourth_equation_says() -> None:
    a, heat, outlet = by_hand(150)
    big = np.zeros((4, 4))
    big[:3, :3] = a
    big[[1, 3], [1, 3]] -= 0.6
    big[1, 3] = big[3, 1] = 0.6
    big[3, 3] -= 0.1
    change = paths.HiddenNode(node=1, capacity=150.0, conductance=0.6, outlet=0.1, kind="friction", share=7.0)
    friction = 7.0 * LOSSES.friction(150 / 255)
    expected = solved(big, np.append(heat, friction), np.append(outlet, 0.1))
    np.testing.assert_allclose(settled(LINEAR, change, 150), expected, atol=2e-3)


def test_a_mass_that_only_takes_up_heat_delays_and_changes_nothing_in_the_end() -> None:
    change = paths.HiddenNode(node=1, capacity=900.0, conductance=2.0, outlet=0.0, kind="friction", share=0.0)
    np.testing.assert_allclose(settled(LINEAR, change, 150)[:3], LINEAR.steady(150, 21.0), atol=2e-3)
    with_it, without = run_of(Altered(LINEAR, (change,), {}), (150, 1800.0)), run_of(LINEAR, (150, 1800.0))
    assert with_it.temperature[-1, 1] < without.temperature[-1, 1] - 0.5


def test_a_new_path_carries_what_it_conducts_for_each_kelvin() -> None:
    a, heat, outlet = by_hand(150)
    a[[0, 2], [0, 2]] -= 0.35
    a[0, 2] += 0.35
    a[2, 0] += 0.35
    found = settled(LINEAR, paths.Coupling(first=2, second=0, conductance=0.35), 150)
    np.testing.assert_allclose(found, solved(a, heat, outlet), atol=2e-3)


def test_other_cooling_at_rest_acts_at_rest_alone() -> None:
    still = paths.StandstillCooling(nodes=(0,), factor=3.0)
    motor = Altered(NODE, (still,), {})
    rows = run_of(motor, (200, 3600.0), (0, 1200.0))
    plain = run_of(NODE, (200, 3600.0), (0, 1200.0))
    turning = rows.time <= 3600.0
    np.testing.assert_allclose(rows.temperature[turning], plain.temperature[turning], atol=1e-9)
    rise = rows.temperature[rows.time == 3600.0, 0] - 21.0
    at_rest = rows.time >= 3600.0
    expected = 21.0 + rise * np.exp(-1.5 * (rows.time[at_rest] - 3600.0) / 200.0)
    np.testing.assert_allclose(rows.temperature[at_rest, 0], expected, atol=2e-3)


def test_moved_air_cools_as_the_correlation_says() -> None:
    # Incropera and DeWitt, example 7.4: 12.7 mm in air at 10 m/s, measured 102, by this correlation 96 W/m2 K
    assert paths.cross_flow(10.0, 0.0127) == pytest.approx(96.0, rel=0.03)
    assert paths.cross_flow(0.0, 0.05) == pytest.approx(0.3 * 0.027 / 0.05)
    change = paths.Airflow(nodes=(0,), area=0.004, diameter=0.05)
    forced = 0.004 * (paths.cross_flow(3.0, 0.05) - paths.cross_flow(0.0, 0.05))
    assert settled(NODE, change, 200, {"air": 3.0})[0] == pytest.approx(21.0 + FRICTION / (0.5 + forced), abs=2e-3)
    assert settled(NODE, change, 200, {"air": 0.0})[0] == pytest.approx(21.0 + FRICTION / 0.5, abs=2e-3)


def test_a_load_heats_by_the_square_of_the_whole_current() -> None:
    plant = replace(NODE, sources=(Source(0, "copper", 3.0), Source(0, "brush", 4.0)))
    duty = 200 / 255
    current = LOSSES.current(duty) + 0.4
    ripple = 0.2 * (4 * duty * (1 - duty)) ** 1.5
    watts = 3.0 * (0.5 * current**2 + ripple) + 4.0 * 0.1 * current * (1 - np.exp(-3 * current))
    found = settled(plant, losses.LoadHeating(torque=1.0), 200, {"load": 0.4})[0]
    assert found == pytest.approx(21.0 + watts / 0.5, abs=2e-3)
    assert settled(plant, losses.LoadHeating(torque=1.0), 0, {"load": 0.4})[0] == pytest.approx(21.0, abs=1e-3)


def test_a_lower_supply_turns_the_motor_as_a_lower_pwm_would() -> None:
    lower = settled(NODE, losses.SupplyVoltage(swing=0.1), 200, {"supply": 0.75})
    np.testing.assert_allclose(lower, NODE.steady(150, 21.0), atol=2e-3)
    fan = replace(NODE, surfaces=(Surface(0, Law(0.3, 2.0)),), sources=(Source(0, "iron", 30.0),))
    lower = settled(fan, losses.SupplyVoltage(swing=0.1), 200, {"supply": 0.75})
    np.testing.assert_allclose(lower, fan.steady(150, 21.0), atol=2e-3)
    assert LOSSES.copper(0.5) > replace(LOSSES, supply=0.8).copper(0.5)


def test_a_loss_that_depends_on_temperature_settles_where_its_balance_does() -> None:
    grows = settled(NODE, losses.TemperatureDependentLoss(source=0, per_K=0.006, thins=False), 200)[0]
    share = FRICTION * 0.006
    assert grows == pytest.approx((FRICTION - 25.0 * share + 0.5 * 21.0) / (0.5 - share), abs=5e-3)
    thins = settled(NODE, losses.TemperatureDependentLoss(source=0, per_K=0.02, thins=True), 200)[0]
    balance = brentq(lambda t: FRICTION * np.exp(-0.02 * (t - 25.0)) - 0.5 * (t - 21.0), 0.0, 200.0)
    assert thins == pytest.approx(balance, abs=2e-3)


def test_a_black_surface_loses_by_the_fourth_powers() -> None:
    def balance(t: float) -> float:
        return float(FRICTION - 0.5 * (t - 21.0) - 5.670374419e-8 * 0.03 * ((t + 273.15) ** 4 - (21.0 + 273.15) ** 4))

    found = settled(NODE, paths.Radiation(node=0, area=0.03), 200)[0]
    assert found == pytest.approx(brentq(balance, 0.0, 200.0), abs=2e-3)


def test_backwards_and_at_some_speeds_losses_are_otherwise() -> None:
    rubs = losses.Direction(sources=(0,), factor=1.5)
    assert settled(NODE, rubs, -200)[0] - 21.0 == pytest.approx(1.5 * FRICTION / 0.5, abs=2e-3)
    assert settled(NODE, rubs, 200)[0] - 21.0 == pytest.approx(FRICTION / 0.5, abs=2e-3)
    hums = losses.ScheduleError(sources=(0,), centre=200 / 255, width=25 / 255, gain=0.8)
    assert settled(NODE, hums, 200)[0] - 21.0 == pytest.approx(1.8 * FRICTION / 0.5, abs=2e-3)
    expected = 1.4 * 40.0 * LOSSES.friction(175 / 255) / 0.5
    assert settled(NODE, hums, -175)[0] - 21.0 == pytest.approx(expected, abs=2e-3)


def test_wear_heats_by_its_factor_and_grows_over_the_runs() -> None:
    assert settled(NODE, faults.Worn(sources=(0,), factor=2.0), 200)[0] - 21.0 == pytest.approx(
        2.0 * FRICTION / 0.5, abs=2e-3
    )
    grows = faults.Wearing(sources=(0,), gain=2.0)
    rng = np.random.default_rng(0)
    first, last = (grows.signals(rng, number, 14400.0)["wear"] for number in (0, 7))
    assert first.at(0.0) == pytest.approx(0.6)
    assert first.at(14399.0) < last.at(0.0) < last.at(14399.0) < 2.0
    assert settled(NODE, grows, 200, {"wear": 0.5})[0] - 21.0 == pytest.approx(1.5 * FRICTION / 0.5, abs=2e-3)


TIME = np.arange(0.0, 14400.0, 2.0)
TRUE = 30.0 + 10.0 * np.sin(TIME / 2000.0)
AIR = np.full(TIME.size, 21.0)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (sensing.SensorOffset(1, -2.5), TRUE - 2.5),
        (sensing.SensorGain(1, 0.1, of_rise=True), 21.0 + 1.1 * (TRUE - 21.0)),
        (sensing.SensorGain(1, -0.1, of_rise=False), 0.9 * TRUE),
        (sensing.Drift(1, 1.5, None), TRUE + 1.5 * TIME / 3600.0),
        (sensing.Drift(1, -2.0, 1.0), TRUE - 2.0 * (1.0 - np.exp(-TIME / 3600.0))),
        (outside.Ceiling(1, 35.0), np.minimum(TRUE, 35.0)),
    ],
)
def test_a_changed_sensor_reads_what_its_formula_says_and_the_others_are_as_they_were(
    change: sensing.SensorChange, expected: FloatArray
) -> None:
    np.testing.assert_allclose(change.seen(1, TRUE, TIME, AIR), expected, atol=1e-12)
    np.testing.assert_array_equal(change.seen(0, TRUE, TIME, AIR), TRUE)


def test_a_sensor_on_a_pad_answers_late() -> None:
    step = np.where(TIME < 100.0, 20.0, 60.0)
    seen = sensing.SensorLag(0, 400.0).seen(0, step, TIME, AIR)
    late = TIME >= 100.0
    np.testing.assert_allclose(seen[late], 60.0 - 40.0 * np.exp(-(TIME[late] - 98.0) / 400.0), atol=1e-9)
    assert np.all(seen[~late] == 20.0)


def test_what_ran_before_leaves_heat_inside() -> None:
    rng = np.random.default_rng(3)
    profile = surroundings.InitialState(ran=3600.0).profile(rng, Profile("run", ((0, 600.0),)))
    (level, ran), (rest, rested) = profile.before
    assert rest == 0
    assert 1800.0 <= ran <= 3600.0
    assert 30.0 <= rested <= 300.0
    found = course(NODE, profile, Room(21.0), 2.0).temperature[0, 0]
    hot = 40.0 * LOSSES.friction(level / 255) / 0.5 * (1.0 - np.exp(-ran / 400.0))
    assert found == pytest.approx(21.0 + hot * np.exp(-rested / 400.0), abs=5e-3)


def test_walls_follow_the_room_late_and_are_not_there_while_it_is_held() -> None:
    change = surroundings.Ambient(swing=6.0, walls=1.0, lag=5000.0)
    assert settled(NODE, change, 200)[0] == pytest.approx(21.0 + FRICTION / 0.5, abs=2e-3)
    opened = Room(21.0, jumps=((0.0, 4.0),))
    motor = Altered(NODE, (change,), {})
    run = course(motor, Profile("run", ((0, 4 * 3600.0),)), opened, 20.0)
    # a wall and then the node: two first orders in series
    late = 1.0 - (5000.0 * np.exp(-run.time / 5000.0) - 400.0 * np.exp(-run.time / 400.0)) / 4600.0
    np.testing.assert_allclose(run.temperature[:, 0], 21.0 + 4.0 * late, atol=2e-3)
    room = change.room(np.random.default_rng(1), Room(23.0), 14400.0)
    assert float(np.ptp(room.at(TIME))) > 5.0
    assert room.mean == 23.0


def test_what_melts_takes_up_its_latent_heat_once() -> None:
    closed = replace(NODE, surfaces=(Surface(0, Law(1e-9)),))
    change = outside.Melting(node=0, at=30.0, width=0.5, latent=3000.0)
    seconds = round((200.0 * 20.0 + 3000.0) / FRICTION)
    run = run_of(Altered(closed, (change,), {}), (200, float(seconds)), row_s=1.0)
    stored = FRICTION * seconds - 3000.0
    assert run.temperature[-1, 0] == pytest.approx(21.0 + stored / 200.0, abs=5e-3)


def test_a_ducts_air_comes_late_and_warms_by_what_it_carries() -> None:
    change = outside.Duct(first=0, second=2, delay=600.0, conductance=0.05)
    late = run_of(Altered(LINEAR, (change,), {}), (200, 3600.0))
    plain = run_of(LINEAR, (200, 3600.0))
    early = plain.time <= 240.0
    assert np.max(np.abs(late.temperature[early, :3] - plain.temperature[early])) < 0.02
    a, heat, outlet = by_hand(200)
    a[2, 0] += 0.05
    heat[2] -= 0.05 * 21.0
    np.testing.assert_allclose(settled(LINEAR, change, 200)[:3], solved(a, heat, outlet), atol=5e-3)


def test_a_bimetal_that_has_shut_opens_only_when_it_is_cooler() -> None:
    change = outside.Bimetal(node=0, shuts=40.0, opens=30.0, conductance=0.4)
    between = settled(NODE, change, 110)[0]
    free = 21.0 + 40.0 * LOSSES.friction(110 / 255) / 0.5
    assert 30.0 < free < 40.0
    assert between == pytest.approx(free, abs=5e-3)
    motor = Altered(NODE, (change,), {})
    after = run_of(motor, (255, 4000.0), (200, 8000.0), row_s=20.0).temperature[-1, 0]
    alone = run_of(motor, (200, 8000.0), row_s=20.0).temperature[-1, 0]
    assert alone == pytest.approx(after, abs=0.02)  # above 40 degC when free: both have shut
    assert after == pytest.approx(21.0 + FRICTION / 0.9, abs=0.05)


def test_what_varies_outside_of_the_library_varies_between_its_ends() -> None:
    rng = np.random.default_rng(5)
    cycle = outside.LoadCycle(torque=0.7, period=2400.0).signals(rng, 0, 14400.0)["cycle"]
    assert min(cycle.values) == 0.0
    assert max(cycle.values) == pytest.approx(0.7, abs=0.02)
    timer = outside.Neighbour(node=0, watts=5.0, period=3000.0, on=0.4)
    along = timer.signals(rng, 0, 144000.0)["neighbour"].along(np.arange(0.0, 144000.0, 10.0))
    assert np.mean(along) == pytest.approx(0.4, abs=0.02)
    assert set(along) == {0.0, 1.0}
    assert settled(NODE, timer, 200, {"neighbour": 1.0})[0] == pytest.approx(21.0 + (FRICTION + 5.0) / 0.5, abs=2e-3)
    sticks = outside.StickSlip(sources=(0,), below=0.5, factor=3.0)
    slow = 40.0 * LOSSES.friction(100 / 255)
    assert settled(NODE, sticks, 100, {"sticks": 1.0})[0] == pytest.approx(21.0 + 3.0 * slow / 0.5, abs=2e-3)
    assert settled(NODE, sticks, 200, {"sticks": 1.0})[0] == pytest.approx(21.0 + FRICTION / 0.5, abs=2e-3)
    dusty = settled(NODE, outside.Fouling(most=0.5), 200, {"dust": 0.2})[0]
    assert dusty == pytest.approx(21.0 + FRICTION / 0.4, abs=2e-3)


def test_the_sun_shines_once_in_a_run_and_clouds_pass() -> None:
    sun = outside.Sun(node=0, watts=4.0)
    for seed in range(8):
        along = sun.signals(np.random.default_rng(seed), 0, 14400.0)["sun"].along(np.arange(0.0, 14400.0, 60.0))
        lit = np.flatnonzero(along > 1e-9)
        assert 0.0 <= along.min() <= along.max() <= 1.0
        assert 0.15 < lit.size / along.size < 0.7
        assert np.all(np.diff(lit) == 1)
    assert settled(NODE, sun, 200, {"sun": 1.0})[0] == pytest.approx(21.0 + (FRICTION + 4.0) / 0.5, abs=2e-3)


def test_a_fan_that_nobody_logs_blows_as_any_other() -> None:
    logged, unlogged = (kind((0,), 0.01, 0.05) for kind in (paths.Airflow, outside.UnloggedFan))
    assert settled(NODE, unlogged, 200, {"air": 3.0}) == pytest.approx(settled(NODE, logged, 200, {"air": 3.0}))
    assert unlogged.columns(np.random.default_rng(1), {"air": np.ones(3)}) == {}


def test_a_thermometer_beside_the_motor_reads_a_share_of_its_rise() -> None:
    temperature = np.stack([np.full(TIME.size, 30.0), np.full(TIME.size, 61.0)], axis=1)
    seen = outside.WarmedThermometer(node=1, share=0.05, lag=300.0).room_seen(AIR, temperature, TIME)
    np.testing.assert_allclose(seen, 23.0)


def test_meters_see_what_varies() -> None:
    signals = {"load": Steps(0.0, (0.0, 10.0), (0.0, 0.5)), "supply": Steps(1.0, (20.0,), (0.9,))}
    motor = Altered(LINEAR, (losses.LoadHeating(1.0), losses.SupplyVoltage(0.1)), signals)
    time, pwm = np.array([0.0, 10.0, 20.0, 30.0]), np.array([100, 100, -100, 0])
    seen = motor.electric(time, pwm)
    lower = replace(LOSSES, supply=0.9)
    np.testing.assert_allclose(seen.voltage, [24.0, 24.0, 21.6, 21.6])
    duty = 100 / 255
    currents = [LOSSES.current(duty), LOSSES.current(duty) + 0.5, lower.current(duty) + 0.5, 0.0]
    np.testing.assert_allclose(seen.current, currents)
    np.testing.assert_allclose(seen.speed, [LOSSES.speed(duty), LOSSES.speed(duty), -lower.speed(duty), 0.0])


def test_blocked_vents_take_what_speed_adds_and_nothing_at_rest() -> None:
    node = replace(NODE, surfaces=(Surface(0, Law(0.5, gain=3.0, form=Form.LINEAR), natural=0.1),))
    change = faults.Blocked(nodes=(0,), share=0.4)
    speed = LOSSES.speed(200 / 255)
    found = change.plant(node).surfaces[0]
    assert found.law(0.0) == pytest.approx(0.5)
    assert found.law(speed) == pytest.approx(0.5 * (1.0 + 0.6 * 3.0 * speed))
    assert found.natural == pytest.approx(0.1)


def test_what_is_covered_loses_less_by_air_and_by_radiation() -> None:
    node = replace(NODE, surfaces=(Surface(0, Law(0.5, gain=3.0, form=Form.LINEAR), natural=0.1, radiating=0.02),))
    found = faults.Covered(nodes=(0,), share=0.25).plant(node).surfaces[0]
    assert found.law(0.7) == pytest.approx(0.75 * 0.5 * (1.0 + 3.0 * 0.7))
    assert (found.natural, found.radiating) == pytest.approx((0.075, 0.015))


def test_a_loosened_joint_settles_as_its_lower_conductance_says() -> None:
    a, heat, outlet = by_hand(150)
    link = LINEAR.links[0]
    lost = 0.6 * link.law(LOSSES.speed(150 / 255))
    i, j = link.first, link.second
    a[[i, j], [i, j]] += lost
    a[i, j] -= lost
    a[j, i] -= lost
    found = settled(LINEAR, faults.Loosened(link=0, share=0.6), 150)
    np.testing.assert_allclose(found, solved(a, heat, outlet), atol=2e-3)
