"""A file that holds a sensor's wrong gain is refined beside that gain, and a gain that is found is written into it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse, with_network
from gen.errors import InputError
from gen.lowering.lower import lower
from gen.model.network_solution import NetworkSolution
from gen.refinement.network.changing.freed import freed
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.sensors import SensorGain, SensorOffset
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.tracing.judged import judged
from tests.refinement.network.motor import read, run, tree


def with_sensor(**sensor: Any) -> Coefficients:  # noqa: ANN401
    """The small motor with another sensor at its winding."""
    file = tree()
    file["network"]["nodes"][0]["sensor"] = sensor
    return read(file)


def sensor_of(writer: NetworkWriter) -> dict[str, float | str]:
    written = parse(with_network(json.dumps(tree()), writer.entry, "a test").encode())
    assert written.document.network is not None
    entry = written.document.network.nodes[0].sensor
    assert entry is not None
    return entry.model_dump(exclude_unset=True)


def writer_of(motor: Coefficients) -> NetworkWriter:
    assert motor.document.network is not None
    return NetworkWriter(motor.document.network, 255, {}, 0.25)


@pytest.mark.parametrize("about", ["ambient", "zero_degC"])
def test_a_gain_that_was_found_multiplies_the_one_that_is_there(about: str) -> None:
    writer = writer_of(with_sensor(gain_error=-0.4, gain_about=about, offset_K=0.5, lag_s=7.0))
    made = writer.wrong_gain
    made("winding", 0.25, "ambient" if about == "ambient" else "zero_degC")
    # What is found of an offset lies before the gain of the file, not before the one that was found with it.
    writer.sensor("winding", offset_K=1.0)
    assert sensor_of(writer) == pytest.approx(
        {"offset_K": 0.5 + 0.6, "lag_s": 7.0, "gain_error": 0.6 * 1.25 - 1.0, "gain_about": about}
    )


def test_a_gain_about_another_base_is_refused_in_words() -> None:
    writer = writer_of(with_sensor(gain_error=-0.4))
    with pytest.raises(InputError, match=r'the gain of "winding" is wrong about the ambient in the file, .* 0 degC'):
        writer.wrong_gain("winding", 0.1, "zero_degC")


def test_a_gain_beyond_what_a_file_holds_is_refused() -> None:
    writer = writer_of(with_sensor(gain_error=-0.8))
    with pytest.raises(ValueError, match="gain_error"):
        writer.wrong_gain("winding", -0.6, "ambient")


@pytest.mark.parametrize("about", ["ambient", "zero_degC"])
def test_runs_are_freed_of_the_gain_and_of_nothing_else(about: str) -> None:
    """As the same motor's sensor shows them without the gain, by the exact solution of another file."""
    wrong = with_sensor(gain_error=-0.4, gain_about=about, offset_K=0.5, lag_s=7.0)
    right = with_sensor(offset_K=0.5, lag_s=7.0)
    measured = run(right, 1)
    assert measured.ambient is not None
    told = {**measured.extras, "pwm": measured.pwm.astype(np.float64)}
    shown = [
        NetworkSolution(motor.model).simulate_times(measured.time_s, measured.pwm, measured.ambient, told)
        for motor in (wrong, right)
    ]
    network = wrong.model.network
    assert network is not None
    one = freed(type(measured)(measured.time_s, measured.pwm, shown[0], measured.ambient), network, measured.ambient)
    for name, values in shown[1].items():
        np.testing.assert_allclose(one.temps[name], values, atol=1e-9)


@pytest.mark.parametrize(("about", "of_rise"), [("ambient", True), ("zero_degC", False)])
def test_a_file_with_a_gain_predicts_runs_with_it_and_a_further_gain_is_found_beside_it(
    about: str, of_rise: bool
) -> None:
    """The gain is known: nothing is missing. Once more the sensor comes off: that is found, and the product written."""
    file = with_sensor(gain_error=-0.3, gain_about=about, offset_K=0.4)
    network = file.model.network
    assert network is not None
    same = make_data(file, [("one", run(file, 1)), ("two", run(file, 2))])
    shape = Anchored.of(network, 255, same.columns)
    bench = Bench(same)
    assert judged(same, bench.first(shape), bench.as_it_is(shape)).floors < 1.1
    further = with_sensor(gain_error=0.7 * 0.85 - 1.0, gain_about=about, offset_K=0.4 + 0.7 * 2.0)
    data = make_data(file, [("one", run(further, 1)), ("two", run(further, 2))])
    bench = Bench(data)
    motor = shape.motor()
    effects = (SensorGain(motor, 0, of_rise=of_rise), SensorOffset(motor, 0))
    found = bench.first(shape.with_effects(*effects))
    writer = writer_of(file)
    found.shape.write(writer, found.vector, effects)
    written = sensor_of(writer)
    assert written["gain_about"] == about
    assert written["gain_error"] == pytest.approx(0.7 * 0.85 - 1.0, abs=0.02)
    refined = parse(with_network(json.dumps(tree()), writer.entry, "a test").encode())
    assert lower(refined, "fixed", "table").network  # with a guaranteed bound, or it raises
    measured = run(further, 3, noise_K=0.0)
    assert measured.ambient is not None
    start = {name: float(values[0]) for name, values in measured.temps.items()}
    for motor_file, least, most in ((refined, 0.0, 0.4), (file, 2.0, 100.0)):
        told = {**measured.extras, "pwm": measured.pwm.astype(np.float64)}
        solution = NetworkSolution(motor_file.model)
        shown = solution.simulate_times(measured.time_s, measured.pwm, measured.ambient, told, start)
        off = float(np.abs(shown["winding"] - measured.temps["winding"]).max())
        assert least <= off < most
