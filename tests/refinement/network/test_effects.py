"""Each effect as a term of the fit: its derivatives, and that what is written is what was fitted."""

from __future__ import annotations

import json
import warnings
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from gen.coefficients import parse, with_network
from gen.model.network_solution import NetworkSolution
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects import NetworkEffect, candidates
from gen.refinement.network.effects.hidden_node import HiddenNode
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from tests.refinement.network.motor import read, run, tree, wave

CHANNELS = {"fan_mps": (0.0, 6.0), "current_A": (1.0, 5.0), "supply_V": (20.0, 26.0)}
#: Numbers at which every effect does something, by its name.
AT = {
    "airflow": (0.4,),
    "load_heating": (0.3, -0.2),
    "supply_voltage": (1.2, 0.8, 23.5),
    "standstill_cooling": (0.3, -0.2),
    "direction": (0.3,),
    "temperature_dependent_loss": (0.004,),
    "hidden_node": (4.0, -1.5, -3.0, 0.5, 1.3),
    "coupling": (-1.0,),
    "path_change": (-0.6,),
    "radiation": (-1.5,),
    "schedule_error": tuple(0.1 + 0.1 * np.sin(np.arange(21.0))),
    "sensor_offset": (1.0,),
    "sensor_gain": (0.05, 0.4),
    "sensor_lag": (20.0,),
    "drift": (0.3, 1.1),
    "ambient": (11.0, -0.5),
}


@cache
def bench() -> tuple[Bench, Anchored]:
    motor = read(tree())
    told = {name: wave(k, *ends) for k, (name, ends) in enumerate(CHANNELS.items())}
    data = make_data(motor, [("one", run(motor, 1, told)), ("two", run(motor, 2, told))])
    assert motor.model.network is not None
    made = Bench(data)
    made.weigh(np.full(2, 10.0))
    return made, Anchored.of(motor.model.network, 255, data.columns)


def every() -> list[NetworkEffect]:
    made, shape = bench()
    return candidates(shape.motor(), made.data.offered)


def name_of(effect: NetworkEffect) -> str:
    return "-".join([effect.name, effect.component, *effect.acts_by.values(), str(len(effect.numbers))])


def test_the_whole_library_is_offered() -> None:
    assert {effect.name for effect in every()} == set(AT)


def test_a_mass_that_makes_no_heat_is_no_hot_part() -> None:
    """Three quarters of a watt per kelvin, and a third of a watt or thirty."""
    (one, *_) = (effect for effect in every() if isinstance(effect, HiddenNode))
    assert "heatsink" in one.title_of((300.0, 0.5, 0.25, 0.36, 1.0))
    assert one.title_of((300.0, 0.5, 0.25, 30.0, 1.0)) == ""


@pytest.mark.parametrize("effect", every(), ids=name_of)
def test_derivatives_agree_with_differences(effect: NetworkEffect) -> None:
    made, base = bench()
    shape = base.with_effects(effect)
    problem = made.problem(shape)
    vector = problem.prior.mean + np.random.default_rng(3).normal(0.0, 0.02, problem.size)
    vector[shape.places[0].columns] = AT[effect.name][: len(effect.numbers)]
    _, slopes = problem.slopes(vector)
    later = made.data.is_later
    step = 1e-4
    places = [*shape.places[0].columns.tolist(), 0, shape.nodes, int(shape.offsets[0]) - 1]
    for place in places:
        up, down = vector.copy(), vector.copy()
        up[place] += step
        down[place] -= step
        wanted = (problem.evaluate(down).residual - problem.evaluate(up).residual)[later] / (2.0 * step)
        found = np.where(made.data.inputs.covered[later] > 0.0, slopes[later][..., place], 0.0)
        assert found == pytest.approx(wanted, rel=2e-3, abs=2e-3 * float(np.abs(wanted).max()) + 1e-4), place


@pytest.mark.parametrize(
    "effect",
    # Radiation goes with temperatures as they were measured, so it is right for its own runs only: `test_laws.py`.
    # An ambient sensor that a motor warms no file holds.
    [e for e in every() if e.name != "radiation" and (e.name, e.component) != ("sensor_gain", "ambient")],
    ids=name_of,
)
def test_what_is_written_is_what_was_fitted(effect: NetworkEffect) -> None:
    """The file's own exact solution gives the fit's curves: tables and rounding are between."""
    made, base = bench()
    shape = base.with_effects(effect)
    problem = made.problem(shape)
    chance = np.random.default_rng(4)
    vector = problem.prior.mean.copy()
    vector[: shape.size] += chance.normal(0.0, 0.05, shape.size)
    vector[shape.places[0].columns] = AT[effect.name][: len(effect.numbers)]
    motor = read(tree())
    assert motor.document.network is not None
    writer = NetworkWriter(motor.document.network, 255, made.data.offered.ranges, 0.25)
    shape.write(writer, vector, [effect])
    text = with_network(json.dumps(tree()), writer.entry, "a test")
    written = parse(text.encode())
    one = run(motor, 1, {name: wave(k, *ends) for k, (name, ends) in enumerate(CHANNELS.items())})
    told = {**one.extras, "pwm": one.pwm.astype(np.float64)}
    assert one.ambient is not None
    assert written.model.network is not None
    room = float(one.ambient[0])
    sensors = {node.name: node.sensor for node in written.model.network.sensed if node.sensor is not None}
    start = {name: float(sensor.shown(room, room)) for name, sensor in sensors.items()}
    shown = NetworkSolution(written.model).simulate_times(one.time_s, one.pwm, one.ambient, told, start)
    inputs = problem.inputs
    row = inputs.rows[0]
    # The fit's start: all nodes at the ambient.
    vector[problem.columns(0)[shape.size :]] = float(one.ambient[0]) - inputs.begin[0, -1]
    vector[problem.columns(0)[shape.size : shape.size + shape.sensors]] = (
        float(one.ambient[0]) - inputs.begin[0, : shape.sensors]
    )
    evaluated = problem.evaluate(vector)
    edges = inputs.runs[0].edges
    for s, name in enumerate(motor.model.component_names):
        fitted = inputs.target[row, s] - evaluated.residual[row, s]
        bins = [(one.time_s >= a) & (one.time_s < b) for a, b in pairwise(edges)]
        exact = np.array([shown[name][inside].mean() for inside in bins])
        assert float(np.abs(fitted - exact).max()) < 0.12, name


@pytest.mark.parametrize("end", ["casing", "ambient"])
def test_a_path_is_written_no_better_than_the_board_can_follow(end: str) -> None:
    motor = read(tree())
    assert motor.document.network is not None
    writer = NetworkWriter(motor.document.network, 255, {}, 0.25)
    writer.path("winding", end, 1e5)
    written = parse(with_network(json.dumps(tree()), writer.entry, "a test").encode())
    assert written.model.network is not None
    matrices, _, _ = written.model.network.matrices(np.arange(256))
    fastest = 1.0 / float(-np.diagonal(matrices, axis1=1, axis2=2).min())
    assert 10 * 0.25 < fastest < 15 * 0.25


def test_heat_that_falls_with_speed_is_none_at_rest() -> None:
    """A power below zero has no value there, and warns."""
    motor = read(tree())
    assert motor.document.network is not None
    writer = NetworkWriter(motor.document.network, 255, {}, 0.25)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        writer.heat_over_speed("casing", lambda w: 2.0 * w**-0.5)
    written = parse(with_network(json.dumps(tree()), writer.entry, "a test").encode())
    assert written.model.network is not None
    assert motor.model.network is not None
    pwm = np.array([0, 64, 255])
    casing, capacity = 1, 400.0
    more = written.model.network.matrices(pwm)[2] - motor.model.network.matrices(pwm)[2]
    assert more[:, casing] * capacity == pytest.approx([0.0, 2.0 * (64 / 255) ** -0.5, 2.0], rel=1e-3)


def test_no_heat_shrinks_below_none_at_temperatures_that_were_reached() -> None:
    made, _ = bench()
    hottest = made.data.offered.hottest("casing")
    gone = -1.0 / (hottest - 25.0)
    named = [one for one in every() if (one.name, one.component) == ("temperature_dependent_loss", "casing")]
    effect = named[0]  # about 25 degC; the other about what the casing usually is
    assert effect.doubts([0.9 * gone]) == []
    assert effect.doubts([1.1 * gone]) == [f"heat would be less than none at {hottest:.0f} degC, which was reached"]


def test_what_sensors_reached_is_known_although_one_is_missing_in_a_run() -> None:
    motor = read(tree())
    whole, other = run(motor, 1), run(motor, 2)
    without = replace(other, temps={"winding": other.temps["winding"]})
    offered = make_data(motor, [("one", whole), ("two", without)]).offered
    assert offered.hottest("casing") == pytest.approx(float(np.nanmax(whole.temps["casing"])), abs=0.5)
    assert offered.hottest("winding") >= float(np.quantile(other.temps["winding"], 0.99))
    assert offered.hottest("rotor, which has no sensor") == max(offered.hottest_degC.values())
