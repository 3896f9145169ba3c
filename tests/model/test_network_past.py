"""Where hidden nodes probably are at a start: against pasts that are followed step by step."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.arrays import FloatArray
from gen.model.network import Network
from gen.model.network_parts import Curve, Heat, Node, Path, Sensor
from gen.model.network_past import Dynamics, network_start_weights, start_weights
from gen.model.network_solution import NetworkSolution
from gen.model.schedules import Polynomial
from tests.model.test_network import constant, made

SENSED, HEAVY, LIGHT = 300.0, 6000.0, 20.0


def motor(hidden_J_per_K: float, to_hidden: float = 0.8, watts: float = 20.0) -> NetworkSolution:
    """A sensed part that is heated, and one without a sensor behind it, which alone leads to the room."""
    nodes = [Node("casing", SENSED, Sensor()), Node("inside", hidden_J_per_K)]
    paths = [Path("casing", "inside", constant(to_hidden)), Path("inside", None, constant(0.2))]
    heats = [Heat("casing", Curve(Polynomial((watts,)), at_rest=0.0))]
    return NetworkSolution(made(nodes, paths, heats))


def weights(solution: NetworkSolution) -> FloatArray:
    network: Network = solution.network
    found = network_start_weights(network, 0, 255)
    assert found is not None
    return found


def test_starts_are_nearer_to_where_parts_are_than_where_they_would_rest() -> None:
    """After pasts of two speeds each, and of other lengths, that nothing was fitted to, by small explicit steps."""
    nodes = [Node("magnet", 300.0, Sensor()), Node("casing", 900.0, Sensor()), Node("rotor", 1200.0)]
    paths = [Path(nodes[i].name, nodes[j].name, constant(value)) for (i, j), value in CONDUCTANCES.items()]
    paths.append(Path("casing", None, constant(TO_ROOM)))
    heats = [Heat("rotor", Curve(Polynomial((W_PER_COUNT, 0.0)), at_rest=0.0))]
    solution = NetworkSolution(made(nodes, paths, heats))
    shares, at_rest = weights(solution), solution.network.rest_of_hidden[:, :-1]
    chance = np.random.default_rng(7)
    errors = []
    for _ in range(30):
        speeds, ran = chance.uniform(60.0, 255.0, 2), np.exp(chance.uniform(np.log(600.0), np.log(7200.0), 2))
        rested = float(np.exp(chance.uniform(np.log(120.0), np.log(7200.0))))
        rise = _rise(np.array([*(W_PER_COUNT * speeds), 0.0]), np.array([*ran, rested]))
        errors.append([float((one @ rise[:2])[0] - rise[2]) for one in (shares, at_rest)])
    likely_K, resting_K = np.sqrt(np.mean(np.square(errors), axis=0))
    assert resting_K > 3.0
    assert likely_K < 0.4 * resting_K


CAPACITIES = np.array([300.0, 900.0, 1200.0])
CONDUCTANCES = {(2, 0): 0.7, (0, 1): 1.5, (2, 1): 0.3}
TO_ROOM, W_PER_COUNT = 0.45, 0.12


def _rise(watts: FloatArray, lasts_s: FloatArray) -> FloatArray:
    """Of magnet, casing and rotor over the room, K, after heats in the rotor that last for some while each."""
    x, step = np.zeros(3), 2.0
    for heat, last in zip(watts, lasts_s, strict=True):
        for _ in range(int(last / step)):
            flows = np.array([0.0, -TO_ROOM * x[1], heat])
            for (i, j), conductance in CONDUCTANCES.items():
                flows[[i, j]] += np.array([-1.0, 1.0]) * conductance * (x[i] - x[j])
            x = x + step * flows / CAPACITIES
    return x


def test_a_light_part_begins_where_it_would_rest() -> None:
    assert weights(motor(LIGHT))[0, 0] == pytest.approx(0.8 / (0.8 + 0.2), abs=0.03)


@given(st.floats(5.0, 2e4), st.floats(0.05, 5.0))
def test_no_warmer_motor_begins_colder_inside(capacity: float, conductance: float) -> None:
    found = weights(motor(capacity, conductance))
    assert np.all(found >= 0.0)
    assert found.sum() < 8.0


def test_nothing_is_said_of_a_motor_that_nothing_heats() -> None:
    assert network_start_weights(motor(HEAVY, watts=0.0).network, 0, 255) is None


def test_a_speed_that_warms_without_end_tells_nothing() -> None:
    cools = np.array([[-2e-3, 1e-3], [1e-3, -2e-3]])
    resting, away = Dynamics(cools, np.zeros(2)), Dynamics(np.array([[1e-3, 0.0], [0.0, -1e-3]]), np.ones(2))
    assert start_weights(resting, [away], [0]) is None
    found = start_weights(resting, [away, Dynamics(cools, np.array([0.1, 0.0]))], [0])
    assert found is not None
    assert np.all(np.isfinite(found))
