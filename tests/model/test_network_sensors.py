"""What a network's sensors show of its temperatures: lag, gain and offset, by their closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from gen.model.network_parts import Node, Path, Sensor
from gen.model.network_solution import NetworkSolution
from tests.model.test_network import constant, made, model_of


def test_a_reading_lags_by_its_closed_form_and_lies_off_by_its_offset() -> None:
    """A node that cools with tau, seen through a lag of s: two exponentials; at first both are in balance."""
    tau, lag, room, first = 400.0, 30.0, 20.0, 60.0
    sensor = Sensor(offset=-1.5, lag=lag)
    model = made([Node("only", 800.0, sensor)], [Path("only", None, constant(2.0))], [])
    time = np.array([0.0, 1.0, 30.0, 200.0, 3000.0])
    pwm = np.zeros(5, dtype=np.int64)
    found = NetworkSolution(model).simulate_times(time, pwm, room, start={"only": first - 1.5})["only"]
    shown = room + (first - room) * (tau * np.exp(-time / tau) - lag * np.exp(-time / lag)) / (tau - lag)
    np.testing.assert_allclose(found, shown - 1.5, rtol=1e-13)


@pytest.mark.parametrize(("about_ambient", "base"), [(True, 20.0), (False, 0.0)])
@pytest.mark.parametrize("gain", [-0.6, 0.25])
def test_a_reading_whose_gain_is_wrong_follows_its_closed_form(gain: float, about_ambient: bool, base: float) -> None:
    """The same cooling: lag, then gain, then offset; the start undoes all of them."""
    tau, lag, room, first = 400.0, 30.0, 20.0, 60.0
    sensor = Sensor(-1.5, lag, gain, about_ambient)
    model = made([Node("only", 800.0, sensor)], [Path("only", None, constant(2.0))], [])
    time, pwm = np.array([0.0, 1.0, 30.0, 200.0, 3000.0]), np.zeros(5, dtype=np.int64)
    begin = base + (1.0 + gain) * (first - base) - 1.5
    solution = NetworkSolution(model)
    np.testing.assert_allclose(solution.start({"only": begin}, room), [first, first], rtol=1e-14)
    found = solution.simulate_times(time, pwm, room, start={"only": begin})["only"]
    behind = room + (first - room) * (tau * np.exp(-time / tau) - lag * np.exp(-time / lag)) / (tau - lag)
    np.testing.assert_allclose(found, base + (1.0 + gain) * (behind - base) - 1.5, rtol=1e-13)


def test_a_gain_of_the_rise_counts_from_the_ambient_at_its_own_time() -> None:
    """A mass that barely moves while the room does: the reading moves against the room, at the very row."""
    model = made([Node("mass", 1e9, Sensor(gain_error=-0.5))], [Path("mass", None, constant(1.0))], [])
    room = np.array([20.0, 30.0, 30.0, 10.0])
    found = NetworkSolution(model).simulate_times(
        np.arange(4.0), np.zeros(4, dtype=np.int64), room, start={"mass": 30.0}
    )
    np.testing.assert_allclose(found["mass"], 0.5 * 40.0 + 0.5 * room, atol=1e-6)


def test_a_sensor_that_lags_starts_in_balance() -> None:
    solution = NetworkSolution(model_of("every_key"))
    found = solution.simulate_times(
        np.array([0.0, 1.0]), np.array([0, 0]), 25.0, start={"bearing": 41.0, "casing": 33.0, "cover": 28.0}
    )
    assert [values[0] for values in found.values()] == [41.0, 33.0, 28.0]
    states = solution.start({"bearing": 41.0}, 25.0)
    assert states.tolist()[1] == states.tolist()[5] == 41.4  # the bearing, and what its sensor shows, less its offset


def test_a_reading_that_was_not_measured_begins_at_the_ambient_with_its_offset() -> None:
    found = NetworkSolution(model_of("every_key")).simulate_times([0.0, 1.0], [0, 0], 25.0)
    assert found["bearing"][0] == 25.0 - 0.4
