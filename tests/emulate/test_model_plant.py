"""A coefficient file as the plant: its temperatures against other solvers of the file's equations, and its faults."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gen.arrays import FloatArray
from gen.coefficients import Coefficients, parse
from gen.emulate.plants.courses import Course, PartsCourse
from gen.emulate.plants.model_faults import ModelFault, parse_faults
from gen.emulate.plants.model_plant import ModelPlant, course_of
from gen.emulate.plants.plant import STEP_S, Ran
from gen.errors import InputError
from gen.model.dynamics import Component
from gen.model.extended import ExtendedSolution
from tests.effects.cases import CASES, case
from tests.examples import ROOT
from tests.model.test_network import integrated

Tree = dict[str, Any]

TWO_NODES = ROOT / "examples" / "two_nodes" / "coeffs.json"


def example(name: str) -> Tree:
    tree: Tree = json.loads((ROOT / "examples" / name / "coeffs.json").read_text(encoding="utf-8"))
    return tree


def read(tree: Tree) -> Coefficients:
    return parse(json.dumps(tree).encode())


def degrees(word: int) -> float:
    return (word >> 3) / 4.0


def run(course: Course, pwm: int, seconds: float, *, room: float = 25.0, active: tuple[ModelFault, ...] = ()) -> None:
    course.step(pwm, seconds, room, {}, active)


def test_a_network_s_readings_are_what_integration_of_the_file_gives() -> None:
    """With a fan, copper loss that grows with temperature, a sensor that lags and one that is off."""
    tree = example("network")
    random = np.random.default_rng(5)
    time = np.arange(0.0, 1200.0, 60.0)
    pwm = random.choice([0, 60, -140, 255], time.size)
    room, fan = random.uniform(10.0, 35.0, time.size), random.uniform(-5.0, 110.0, time.size)
    names = [node["name"] for node in tree["network"]["nodes"]]
    course = course_of(read(tree), (), dict.fromkeys(names, 40.0) | {"winding": 70.0}, float(room[0]))
    expected = integrated(tree, time, pwm, room, {"fan_percent": fan}, dict.fromkeys(names, 40.0) | {"winding": 70.0})
    for k in range(time.size):
        for name, values in expected.items():
            assert course.shown[name] == pytest.approx(values[k], abs=1e-8)
        for _ in range(240):
            course.step(int(pwm[k]), STEP_S, float(room[k]), {"fan_percent": float(fan[k])}, ())
    assert course.parts["casing"] == pytest.approx(course.shown["casing"] + 0.3)  # the sensor's offset


def test_natural_convection_and_radiation_are_what_integration_gives() -> None:
    from tests.model import test_laws

    tree = example("natural_cooling")
    course = course_of(read(tree), (), {"casing": 80.0, "magnet": 75.0, "winding": 90.0}, 20.0)
    state = [80.0, 75.0, 90.0]
    for pwm, room in ((255, 20.0), (0, 35.0), (120, 5.0)):
        for _ in range(400):
            run(course, pwm, STEP_S, room=room)
        rate = test_laws.change(tree, pwm, room)
        state = solve_ivp(rate, (0.0, 100.0), state, method="DOP853", rtol=1e-12, atol=1e-11).y[:, -1].tolist()
        assert list(course.parts.values()) == pytest.approx(state, abs=1e-6)


def slope(component: Component, pwm: int, over: float, state: FloatArray) -> FloatArray:
    """(T, T', ..) by A(d/dt) T = K |PWM| + A(0) over."""
    a = component.denominator([abs(pwm)])[0]
    forced = float(component.effective_gain([abs(pwm)])[0]) * abs(pwm) + a[-1] * over
    return np.array([*state[1:], forced - a[:0:-1] @ state])


@pytest.mark.parametrize("fault", [None, "heat:winding=+20%@300", "heat:winding=-4K@300"])
def test_transfer_functions_are_what_integration_gives(fault: str | None) -> None:
    """The ambient's moves, and a fault's heat, pass the part's own dynamics."""
    loaded = read(example("two_mass"))
    faults = parse_faults(fault, 0.0, 1.0) if fault else ()
    plant = ModelPlant(loaded, ["winding"], faults=faults, ambient_degC=lambda t: 30.0 if t < 200.0 else 22.0)
    plant.step(0, STEP_S)
    component = loaded.model.component("winding")
    state = np.zeros(component.order)
    for begin, end, pwm in ((0.0, 200.0, 150), (200.0, 300.0, -240), (300.0, 600.0, 240)):
        for _ in range(round((end - begin) / STEP_S)):
            plant.step(pwm, STEP_S)
        over = 0.0 if begin < 200.0 else -8.0
        if begin == 300.0 and fault:
            over += -4.0 if "K" in fault else 0.2 * float(component.steady_rise([240])[0])
        solved = solve_ivp(
            lambda _, y, acts, away: slope(component, acts, away, y),
            (begin, end),
            state,
            method="Radau",
            args=(pwm, over),
            rtol=1e-10,
            atol=1e-14,
        )
        state = solved.y[:, -1]
        assert plant.temperatures["winding"] == pytest.approx(30.0 + state[0], abs=1e-6)


@pytest.mark.parametrize("label", CASES)
def test_effects_are_what_the_solution_of_a_whole_run_gives(label: str) -> None:
    made = case(label)
    random = np.random.default_rng(7)
    time = np.arange(0.0, 3000.0, STEP_S)
    pwm = np.repeat(random.choice([0, 60, -140, 200, 255], 12), time.size // 12)
    told = {
        column: np.repeat(random.uniform(low, high, 12), time.size // 12)
        for column, low, high in (
            ("current_A", 0.0, 8.0),
            ("voltage_V", 22.0, 26.0),
            ("fan", 0.0, 1.0),
            ("gearbox_degC", 30.0, 60.0),
        )
    }
    start = {name: 38.0 + 2.0 * k for k, name in enumerate(made.model.component_names)}
    brought = any(applied.effect.replaces_ambient for applied in made.effects)
    room = np.full(time.size, 33.0)
    counted = np.full(time.size, made.model.ambient_fixed) if brought else room
    expected = ExtendedSolution(made.model, made.effects).simulate_times(
        time, pwm, counted, room, told, {name: value - float(counted[0]) for name, value in start.items()}
    )
    course = course_of(made, (), start, 33.0)
    for k in range(time.size):
        if k % 400 == 0:
            for name, values in expected.items():
                assert course.shown[name] == pytest.approx(values[k], abs=2e-3), (name, k)
        course.step(int(pwm[k]), STEP_S, 33.0, {column: float(values[k]) for column, values in told.items()}, ())


def test_a_heat_that_grows_is_the_steady_rise_of_the_network_by_hand() -> None:
    """8e-4 200^2 = 32 W through 0.5 + 0.9 (200/255)^0.8 W/K: both nodes settle where all heat goes out."""
    loaded = parse(TWO_NODES.read_bytes())
    way_out = 0.5 + 0.9 * (200 / 255) ** 0.8
    for text, watts, outside, inside in (
        (None, 32.0, 1.0, 1.0),
        ("heat:winding=+20%", 32.0 * 1.2, 1.0, 1.0),
        ("heat:winding=+5W", 37.0, 1.0, 1.0),
        ("heat:casing=-2.5W", 32.0, 1.0, 1.0),
        ("path:casing-ambient=-50%", 32.0, 0.5, 1.0),
        ("path:winding-casing=+100%,heat:winding=+20%", 32.0 * 1.2, 1.0, 2.0),
    ):
        faults = parse_faults(text, 0.0, 1.0) if text else ()
        course = course_of(loaded, faults, {}, 25.0)
        run(course, 200, 1e6, active=faults)
        through = watts - (2.5 if text and "casing=-2.5W" in text else 0.0)
        casing = 25.0 + through / (way_out * outside)
        assert course.parts["casing"] == pytest.approx(casing, abs=1e-6)
        assert course.parts["winding"] == pytest.approx(casing + watts / (1.6 * inside), abs=1e-6)


def test_heat_in_watts_is_there_while_the_motor_is_driven() -> None:
    loaded = parse(TWO_NODES.read_bytes())
    faults = parse_faults("heat:winding=+5W", 0.0, 1.0)
    course = course_of(loaded, faults, {}, 25.0)
    run(course, 0, 1e6, active=faults)
    assert course.parts["winding"] == pytest.approx(25.0)


def test_a_fault_begins_on_the_boards_clock_and_severity_is_its_share() -> None:
    loaded = parse(TWO_NODES.read_bytes())
    half = parse_faults("heat:winding=+40%", 50.0, 0.5)
    assert half == parse_faults("heat:winding=+20%@50", 0.0, 1.0)
    healthy, faulty = (ModelPlant(loaded, ["casing"], faults=faults) for faults in ((), half))
    healthy.step(0, STEP_S), faulty.step(0, STEP_S)
    apart = []
    for k in range(400):
        healthy.step(178, STEP_S)
        faulty.step(178, STEP_S)
        if healthy.temperatures != faulty.temperatures:
            apart.append(k * STEP_S)
    assert apart[0] == pytest.approx(50.0, abs=2 * STEP_S)


@pytest.mark.parametrize(
    ("example_name", "text", "message"),
    [
        ("two_nodes", "heat:rotor=+5%", 'no part "rotor"; it has casing, winding'),
        ("two_nodes", "heat:casing=+5%", 'no heat of two_nodes acts at "casing"'),
        ("two_nodes", "heat:winding=+5K", "is a network; expected % or W"),
        ("two_nodes", "path:winding-ambient=+5%", "no such path; it has winding-casing, casing-ambient"),
        ("two_nodes", "path:winding-casing=+5W", "a path's change in %"),
        ("two_nodes", "heat:winding=-101%", "at least -100%"),
        ("two_nodes", "bearing", "expected heat:NODE"),
        ("two_mass", "path:winding-housing=+5%", "no paths"),
        ("two_mass", "heat:winding=+5W", "% or K"),
    ],
)
def test_a_fault_that_the_plant_cannot_have_is_refused(example_name: str, text: str, message: str) -> None:
    with pytest.raises(InputError, match="--fault") as refused:
        ModelPlant(read(example(example_name)), ["ambient"], faults=parse_faults(text, 0.0, 1.0))
    assert message in refused.value.message


def test_words_are_the_temperatures_and_pulses_the_speed() -> None:
    tree = example("two_nodes")
    plant = ModelPlant(
        read(tree), ["casing", "winding", "ambient"], start={"casing": 61.0, "winding": 45.5}, ambient_degC=22.25
    )
    words = plant.step(0, STEP_S).words
    assert {name: degrees(word) for name, word in words.items()} == {"casing": 61.0, "winding": 45.5, "ambient": 22.25}
    plant = ModelPlant(read(tree), ["casing"], pulses_per_revolution=500)
    plant.step(0, STEP_S)
    pulses = sum(plant.step(-204, STEP_S).pulses for _ in range(400))
    assert pulses == pytest.approx(100.0 * 2650.0 * 0.8 / 60.0 * 500.0, abs=1.0)


def test_hidden_nodes_start_between_the_others_or_as_told() -> None:
    loaded = parse(TWO_NODES.read_bytes())
    assert ModelPlant(loaded, ["casing"], start={"casing": 60.0}).temperatures["winding"] == pytest.approx(60.0)
    assert ModelPlant(loaded, ["casing"], start={"winding": 60.0}).temperatures["casing"] == 30.0


@pytest.mark.parametrize("name", ["two_nodes", "two_mass", "two_mass_refined"])
def test_what_it_ran_before_is_what_it_would_have_run(name: str) -> None:
    loaded = read(example(name))
    before = ModelPlant(loaded, ["ambient"], start=Ran(200, 600.0))
    stepped = ModelPlant(loaded, ["ambient"])
    for _ in range(2400):
        stepped.step(200, STEP_S)
    assert before.temperatures == pytest.approx(stepped.temperatures, abs=2e-3)


def test_channels_are_told_or_stay_neutral() -> None:
    loaded = read(example("network"))
    still, blown = (ModelPlant(loaded, ["casing"], told=told) for told in ({}, {"fan_percent": 100.0}))
    assert still.untold == {"fan_percent": 0.0} and not blown.untold
    readings = [plant.step(200, STEP_S).channels for plant in (still, blown)]
    assert [reading["fan_percent"] for reading in readings] == [0.0, 100.0]
    assert readings[0]["speed_rpm"] == pytest.approx(2650.0 * 200 / 255)
    for _ in range(4000):
        still.step(200, STEP_S), blown.step(200, STEP_S)
    assert blown.temperatures["casing"] < still.temperatures["casing"] - 1.0


def test_a_part_that_the_board_reads_and_the_plant_lacks() -> None:
    loaded = parse(TWO_NODES.read_bytes())
    with pytest.raises(
        InputError, match=r'two_nodes, has no part "gearbox"; it has casing, winding; .* gearbox_degC=DEGC'
    ):
        ModelPlant(loaded, ["casing", "gearbox_degC"])
    told = ModelPlant(loaded, ["gearbox_degC", "winding_degC"], told={"gearbox_degC": 48.0})
    words = told.step(0, STEP_S).words
    assert [degrees(words[name]) for name in ("gearbox_degC", "winding_degC")] == [48.0, 30.0]


@pytest.mark.parametrize(("about", "first", "then"), [("ambient", 52.0, 58.0), ("zero_degC", 40.0, 40.0)])
def test_a_sensor_whose_gain_is_wrong_shows_its_part_so(about: str, first: float, then: float) -> None:
    """At 60 degC, in a room of 20 and then of 50 degC, for a moment: 0.8 of what lies over the base."""
    tree = json.loads(TWO_NODES.read_bytes())
    casing = next(node for node in tree["network"]["nodes"] if node["name"] == "casing")
    casing["sensor"] = {"gain_error": -0.2, "gain_about": about, "offset_K": 0.0 if about == "ambient" else -8.0}
    course = course_of(read(tree), (), {"casing": 60.0}, 20.0)
    assert course.parts["casing"] == pytest.approx(60.0, abs=1e-9)
    assert course.shown["casing"] == pytest.approx(first, abs=1e-9)
    course.step(0, 1e-3, 50.0, {}, ())
    assert course.parts["casing"] == pytest.approx(60.0, abs=1e-3)
    assert course.shown["casing"] == pytest.approx(then, abs=1e-3)


def test_an_ambient_that_acts_at_once_is_added_to_the_rise() -> None:
    tree = example("two_mass")
    tree["ambient"]["at_once"] = True
    course = course_of(read(tree), (), {"winding": 50.0}, 30.0)
    assert isinstance(course, PartsCourse)
    before = course.parts["winding"]
    course.step(0, 1e-3, 20.0, {}, ())
    assert course.parts["winding"] == pytest.approx(before - 10.0, abs=1e-3)
