"""The network's exact solution, against what does not share a line with it: the file's JSON integrated step by step."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

from gen.arrays import FloatArray, IntArray
from gen.coefficients import parse
from gen.model import ThermalModel
from gen.model import network_solution as module
from gen.model.network import Network
from gen.model.network_parts import Channel, Curve, Factor, Heat, Node, Path, PowerLaw, Sensor
from gen.model.network_solution import NetworkSolution
from gen.model.schedules import Polynomial
from tests.examples import ROOT

Tree = dict[str, Any]
FILES = {
    "two_nodes": ROOT / "examples" / "two_nodes" / "coeffs.json",
    "fan_motor": ROOT / "examples" / "network" / "coeffs.json",
    "every_key": ROOT / "tests" / "coefficients" / "version2" / "network_every_key.json",
    "sensor_gains": ROOT / "tests" / "coefficients" / "version2" / "sensor_gains.json",
    "sensor_drifts": ROOT / "tests" / "coefficients" / "version2" / "sensor_drifts.json",
}


def tree_of(name: str) -> Tree:
    return dict(json.loads(FILES[name].read_text(encoding="utf-8")))


@cache
def model_of(name: str) -> ThermalModel:
    return parse(FILES[name].read_bytes()).model


# The oracle: what docs/format.md says of the file, written down once more, and integrated by an adaptive method.


def curve(tree: Tree, entry: Tree, pwm: int) -> float:
    x = abs(pwm)
    if x == 0 and entry.get("at_rest") is not None:
        return float(entry["at_rest"])
    if tree["validity"]["outside"] == "hold":
        low, high = tree["validity"]["pwm"]
        x = low if x < low else high if x > high else x
    if "poly" in entry:
        return float(sum(c * x**k for k, c in enumerate(reversed(entry["poly"]))))
    if "exp1" in entry or "exp2" in entry:
        numbers = entry.get("exp1") or entry["exp2"]
        return float(sum(a * np.exp(b * x) for a, b in zip(numbers[::2], numbers[1::2], strict=True)))
    if "power" in entry:
        law = entry["power"]
        return float(law["constant"] + law["forced"] * (x / tree["input"]["full_scale"]) ** law["exponent"])
    table = entry["table"]
    inside = min(max(x, table["pwm"][0]), table["pwm"][-1])
    if table["interpolation"] == "linear":
        return float(np.interp(inside, table["pwm"], table["value"]))
    return float(PchipInterpolator(table["pwm"], table["value"])(inside))


def factor(tree: Tree, entries: list[Tree], told: dict[str, float]) -> float:
    product = 1.0
    for entry in entries:
        channel = next(c for c in tree["network"]["channels"] if c["column"] == entry["channel"])
        low, high = channel["range"]
        value = min(max(told.get(entry["channel"], channel["neutral"]), low), high)
        if "poly" in entry:
            product *= sum(c * value**k for k, c in enumerate(reversed(entry["poly"])))
        else:
            product *= float(np.interp(value, entry["table"]["at"], entry["table"]["value"]))
    return product


def change(tree: Tree, pwm: int, room: float, told: dict[str, float]) -> Callable[[float, FloatArray], FloatArray]:
    """dT/dt of the nodes, and of what the sensors show without their offsets."""
    network = tree["network"]
    nodes = network["nodes"]
    names = [node["name"] for node in nodes]
    sensed = [node for node in nodes if node.get("sensor") is not None]
    paths, heats = network["paths"], network["heats"]
    g = [curve(tree, w["conductance_W_per_K"], pwm) * factor(tree, w.get("factors", []), told) for w in paths]
    p = [curve(tree, h["power_W"], pwm) * factor(tree, h.get("factors", []), told) for h in heats]

    def rate(_: float, state: FloatArray) -> FloatArray:
        t = dict(zip([*names, "ambient"], [*state[: len(names)], room], strict=True))
        flow = dict.fromkeys([*names, "ambient"], 0.0)
        for path, conductance in zip(paths, g, strict=True):
            one, other = path["between"]
            heat = conductance * (t[other] - t[one])
            flow[one] += heat
            flow[other] -= heat
        for entry, power in zip(heats, p, strict=True):
            rise = t[entry["node"]] - entry.get("reference_degC", 25.0)
            flow[entry["node"]] += power * (1.0 + entry.get("per_K", 0.0) * rise)
        shown = []
        for k, node in enumerate(sensed):
            lag = node["sensor"].get("lag_s", 0.0)
            shown.append((t[node["name"]] - state[len(names) + k]) / lag if lag else 0.0)
        return np.array([*(flow[n["name"]] / n["capacity_J_per_K"] for n in nodes), *shown])

    return rate


def reading(node: Tree, temperature: FloatArray, room: FloatArray, elapsed_s: FloatArray) -> FloatArray:
    """What a node's sensor shows of a temperature behind its lag, so long after the start."""
    sensor = node["sensor"]
    base = room if sensor.get("gain_about", "ambient") == "ambient" else 0.0
    gain, offset = float(sensor.get("gain_error", 0.0)), float(sensor.get("offset_K", 0.0))
    drift = float(sensor.get("drift_K", 0.0)) * (1.0 - np.exp(-elapsed_s / 3600.0 / float(sensor.get("drift_h", 1.0))))
    return np.asarray(temperature + gain * (temperature - base) + offset + drift)


def integrated(
    tree: Tree,
    time: FloatArray,
    pwm: IntArray,
    room: FloatArray,
    told: dict[str, FloatArray],
    nodes: dict[str, float],
) -> dict[str, FloatArray]:
    """Readings from nodes that start at these temperatures, their sensors in balance."""
    entries = tree["network"]["nodes"]
    sensed = [node for node in entries if node.get("sensor") is not None]
    state = np.array([*(nodes[n["name"]] for n in entries), *(nodes[n["name"]] for n in sensed)])
    states = [state]
    for k in range(time.size - 1):
        now = {name: float(values[k]) for name, values in told.items()}
        rate = change(tree, int(pwm[k]), float(room[k]), now)
        solved = solve_ivp(rate, (time[k], time[k + 1]), state, method="DOP853", rtol=1e-12, atol=1e-10)
        state = solved.y[:, -1]
        states.append(state)
    made = np.array(states)
    readings = {}
    for k, node in enumerate(sensed):
        lag = node["sensor"].get("lag_s", 0.0)
        own = made[:, len(entries) + k] if lag else made[:, [n["name"] for n in entries].index(node["name"])]
        readings[node["name"]] = reading(node, own, room, time - time[0])
    return readings


def a_run(name: str, rows: int, seed: int = 0) -> tuple[FloatArray, IntArray, FloatArray, dict[str, FloatArray]]:
    """Irregular times, a room and channels that move at every row and leave their ranges; both directions."""
    random = np.random.default_rng(seed)
    time = 5.0 + np.concatenate([[0.0], np.cumsum(random.uniform(0.3, 400.0, rows - 1))])
    pwm = random.choice([0, 0, 7, -140, 195, 200], rows)
    told = {
        c["column"]: random.uniform(c["range"][0] - 1.0, 1.2 * c["range"][1], rows)
        for c in tree_of(name)["network"].get("channels", [])
    }
    return time, pwm, random.uniform(15.0, 35.0, rows), told


@pytest.mark.parametrize("name", FILES)
def test_it_is_what_step_by_step_integration_of_the_file_gives(name: str) -> None:
    tree = tree_of(name)
    time, pwm, room, told = a_run(name, 40)
    found = NetworkSolution(model_of(name)).simulate_times(time, pwm, room, told)
    expected = integrated(tree, time, pwm, room, told, {n["name"]: room[0] for n in tree["network"]["nodes"]})
    assert list(found) == list(expected)
    for node, values in expected.items():
        np.testing.assert_allclose(found[node], values, rtol=0.0, atol=1e-7)
    assert all(np.ptp(values) > 3.0 for values in found.values())  # else it would show nothing


@pytest.mark.parametrize("name", FILES)
def test_long_runs_of_which_every_row_differs_are_solved_in_parts_and_come_to_the_same(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    time, pwm, room, told = a_run(name, 300, seed=1)
    solution = NetworkSolution(model_of(name))
    whole = solution.simulate_times(time, pwm, room, told)
    asked: list[int] = []
    steps = NetworkSolution.steps

    def counted(self: NetworkSolution, pwm: IntArray, *rest: Any) -> module.Steps:  # noqa: ANN401
        asked.append(len(pwm))
        return steps(self, pwm, *rest)

    monkeypatch.setattr(NetworkSolution, "steps", counted)
    monkeypatch.setattr(module, "_CHUNK", 400)
    parts = solution.simulate_times(time, pwm, room, told)
    assert len(asked) > 2 and sum(asked) == 299  # it was solved in parts, each row once
    for node, values in whole.items():
        np.testing.assert_allclose(parts[node], values, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("name", FILES)
def test_rows_in_between_change_nothing(name: str) -> None:
    """Irregular times are as good as a regular grid on which inputs are held as long."""
    random = np.random.default_rng(3)
    counts = random.integers(1, 40, 30)
    time = np.concatenate([[0.0], np.cumsum(counts) * 0.25])
    _, pwm, room, told = a_run(name, 31, seed=4)
    row = np.repeat(np.arange(31), [*counts, 1])
    solution = NetworkSolution(model_of(name))
    start = {node.name: 20.0 + 5.0 * k for k, node in enumerate(solution.network.sensed)}
    coarse = solution.simulate_times(time, pwm, room, told, start)
    grid = np.arange(row.size) * 0.25
    fine = solution.simulate_times(grid, pwm[row], room[row], {n: v[row] for n, v in told.items()}, start)
    at = np.concatenate([[0], np.cumsum(counts)])
    for node, values in coarse.items():
        np.testing.assert_allclose(fine[node][at], values, rtol=0.0, atol=1e-10)


def made(
    nodes: list[Node], paths: list[Path], heats: list[Heat], channels: list[Channel] | None = None
) -> ThermalModel:
    network = Network(tuple(nodes), tuple(paths), tuple(heats), tuple(channels or ()))
    return ThermalModel("made", 0.25, 255, (0, 255), "hold", (0, 255), (0, 50), (0, 150), 25.0, None, (), network)


def constant(value: float) -> Curve:
    return Curve(Polynomial((value,)))


def test_one_node_follows_its_closed_form() -> None:
    """C dT/dt = G (T_room - T) + P (1 + k (T - 20)), from T_0: an exponential towards its own steady state."""
    c, g, p, k, room, first = 500.0, 0.8, 30.0, 0.0039, 22.0, 35.0
    model = made(
        [Node("only", c, Sensor())], [Path("only", None, constant(g))], [Heat("only", constant(p), (), k, 20.0)]
    )
    rate = (g - p * k) / c
    steady = (g * room + p * (1.0 - 20.0 * k)) / (g - p * k)
    time = np.array([0.0, 0.25, 10.0, 1000.0, 5000.0, 1e5])
    found = NetworkSolution(model).simulate_times(time, np.zeros(6, dtype=np.int64), room, start={"only": first})[
        "only"
    ]
    np.testing.assert_allclose(found, steady + (first - steady) * np.exp(-rate * time), rtol=1e-13)


@pytest.mark.parametrize("name", FILES)
def test_it_settles_where_all_flows_balance(name: str) -> None:
    """A linear system written from the file: what flows in is what flows out, at every speed."""
    tree = tree_of(name)
    names = [node["name"] for node in tree["network"]["nodes"]]
    for pwm in (0, 60, 200):
        rate = change(tree, pwm, 30.0, {})
        n = len(names)
        zero = rate(0.0, np.zeros(2 * n))[:n]
        jacobian = np.column_stack([rate(0.0, np.eye(2 * n)[k])[:n] - zero for k in range(n)])
        settled = np.linalg.solve(jacobian, -zero)
        held = np.array([pwm, pwm])
        found = NetworkSolution(model_of(name)).simulate_times(np.array([0.0, 1e7]), held, 30.0)
        for node in tree["network"]["nodes"]:
            if node.get("sensor") is not None:
                shown = reading(node, settled[names.index(node["name"])], np.array(30.0), np.array(1e7))
                assert found[node["name"]][-1] == pytest.approx(float(shown), abs=1e-8)


def test_no_energy_is_lost() -> None:
    """What the nodes hold more at the end is what heats brought, less what the ambient took (trapezoids over 1 s)."""
    tree = tree_of("fan_motor")
    for node in tree["network"]["nodes"]:
        node["sensor"] = {}
    model = parse(json.dumps(tree).encode()).model
    time = np.arange(0.0, 4001.0)
    pwm = np.where(time < 2000.0, 255, 0)
    found = NetworkSolution(model).simulate_times(time, pwm, 21.0, {"fan_percent": np.full(time.size, 30.0)})
    held = sum(
        node["capacity_J_per_K"] * (found[node["name"]][-1] - found[node["name"]][0])
        for node in tree["network"]["nodes"]
    )

    def power(row: int, k: int) -> float:
        total = 0.0
        for entry in tree["network"]["heats"]:
            rise = found[entry["node"]][k] - entry.get("reference_degC", 25.0)
            total += curve(tree, entry["power_W"], int(pwm[row])) * (1.0 + entry.get("per_K", 0.0) * rise)
        for path in tree["network"]["paths"]:
            if "ambient" in path["between"]:
                node = path["between"][0]
                conductance = curve(tree, path["conductance_W_per_K"], int(pwm[row]))
                conductance *= factor(tree, path.get("factors", []), {"fan_percent": 30.0})
                total -= conductance * (found[node][k] - 21.0)
        return total

    brought = sum((power(k, k) + power(k, k + 1)) / 2.0 for k in range(time.size - 1))
    assert held == pytest.approx(brought, rel=1e-5)
    assert held > 5000.0


def test_a_change_of_the_room_passes_the_masses() -> None:
    """A noisy ambient sensor does not shake the model: 1 K for a second moves it by its share of heat at most."""
    time = np.arange(0.0, 3.0)
    pwm = np.zeros(3, dtype=np.int64)
    solution = NetworkSolution(model_of("two_nodes"))
    still = solution.simulate_times(time, pwm, 20.0)["casing"]
    shaken = solution.simulate_times(time, pwm, np.array([20.0, 21.0, 20.0]), start={"casing": 20.0})["casing"]
    assert 0.0 < (shaken - still)[2] < 1.0 / 1500.0


def test_hidden_nodes_rest_between_their_neighbours_and_the_ambient_at_the_start() -> None:
    """Two hidden nodes in a row, 40 - a - b - 20 degC with conductances 1, 2, 4: a series of resistances."""
    nodes = [Node("a", 100.0), Node("b", 50.0), Node("hot", 900.0, Sensor(offset=2.0))]
    paths = [
        Path("hot", "a", constant(1.0)),
        Path("a", "b", Curve(Polynomial((9.0,)), at_rest=2.0)),
        Path("b", None, constant(4.0)),
    ]
    solution = NetworkSolution(made(nodes, paths, [Heat("a", constant(5.0), (), 0.01)]))
    a = 40.0 - 20.0 * (1.0 / 1.0) / (1.0 + 0.5 + 0.25)
    b = 20.0 + 20.0 * 0.25 / (1.0 + 0.5 + 0.25)
    np.testing.assert_allclose(solution.start({"hot": 42.0}, 20.0), [a, b, 40.0], rtol=1e-14)
    np.testing.assert_allclose(solution.start({}, 20.0), [20.0, 20.0, 20.0], rtol=1e-14)
    lanes = solution.start({"hot": np.array([42.0, 22.0])}, np.array([20.0, 20.0]))
    np.testing.assert_allclose(lanes, [[a, b, 40.0], [20.0, 20.0, 20.0]], rtol=1e-14)
    weights = solution.network.hidden_at_start
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(weights @ [40.0, 20.0], [a, b], rtol=1e-14)


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0, 2.5])
def test_a_hidden_node_may_start_warmer_than_it_would_rest(factor: float) -> None:
    nodes = [Node("seen", 900.0, Sensor()), Node("inside", 100.0, start_factor=factor)]
    paths = [Path("seen", "inside", constant(3.0)), Path("inside", None, constant(1.0))]
    solution = NetworkSolution(made(nodes, paths, []))
    rests = 20.0 + 40.0 * 3.0 / (3.0 + 1.0)
    np.testing.assert_allclose(solution.start({"seen": 60.0}, 20.0), [60.0, 20.0 + factor * (rests - 20.0)], rtol=1e-14)
    np.testing.assert_allclose(solution.network.hidden_at_start.sum(axis=1), 1.0, rtol=1e-14)


def test_a_hidden_node_that_nothing_reaches_at_rest_starts_at_the_ambient() -> None:
    nodes = [Node("hidden", 100.0), Node("behind", 100.0), Node("seen", 900.0, Sensor())]
    only_turning = Curve(Polynomial((1.0, 0.0)))
    paths = [
        Path("hidden", "seen", only_turning),
        Path("behind", "hidden", constant(1.0)),
        Path("seen", None, constant(1.0)),
    ]
    solution = NetworkSolution(made(nodes, paths, []))
    np.testing.assert_array_equal(solution.start({"seen": 50.0}, 20.0), [20.0, 20.0, 50.0])


def test_channels_are_held_to_their_range_and_neutral_until_told() -> None:
    solution = NetworkSolution(model_of("fan_motor"))
    time, pwm = np.array([0.0, 3600.0]), np.array([255, 255])
    at = {
        fan: solution.simulate_times(time, pwm, 25.0, {"fan_percent": fan})["casing"][-1]
        for fan in (-50.0, 0.0, 30.0, 100.0, 400.0)
    }
    assert at[-50.0] == at[0.0] > at[30.0] > at[100.0] == at[400.0]
    assert solution.simulate_times(time, pwm, 25.0, {"other": 3.0})["casing"][-1] == at[0.0]


def test_stiff_long_and_short_intervals_stand_beside_each_other() -> None:
    """A node of seconds beside one of days, and an interval of a week beside one of a quarter second."""
    nodes = [Node("quick", 5.0, Sensor()), Node("slow", 2e5, Sensor())]
    paths = [Path("quick", "slow", constant(1.0)), Path("slow", None, constant(0.5))]
    heats = [Heat("quick", constant(2.0))]
    time = np.array([0.0, 0.25, 6e5, 6e5 + 0.25, 1.2e6])
    found = NetworkSolution(made(nodes, paths, heats)).simulate_times(time, np.zeros(5, dtype=np.int64), 20.0)
    m = np.array([[-0.2, 0.2], [5e-6, -7.5e-6]])
    values, vectors = np.linalg.eig(m)
    settled = np.array([20.0 + 2.0 / 0.5 + 2.0 / 1.0, 20.0 + 2.0 / 0.5])
    weights = np.linalg.solve(vectors, 20.0 - settled)
    expected = settled + (vectors @ (weights[:, None] * np.exp(values[:, None] * time))).T
    np.testing.assert_allclose(np.column_stack(list(found.values())), expected, rtol=1e-12)


def test_increments_keep_their_precision_over_a_day_of_short_steps() -> None:
    time = np.arange(0.0, 86_400.25, 0.25)
    solution = NetworkSolution(model_of("fan_motor"))
    short = solution.simulate_times(time, np.full(time.size, 200), 25.0)
    long = solution.simulate_times(time[[0, -1]], np.array([200, 200]), 25.0)
    for node, values in long.items():
        assert short[node][-1] == pytest.approx(values[-1], abs=1e-9)


def test_forced_convection_is_the_same_exactly_and_in_floats() -> None:
    law = PowerLaw(0.3, 0.9, 0.8, 200)
    counts = np.arange(256)
    np.testing.assert_allclose(law(counts.astype(np.float64)), [float(law.exact(int(x))) for x in counts], rtol=1e-15)
    assert float(law.exact(0)) == 0.3
    assert float(law.exact(200)) == pytest.approx(1.2, rel=1e-15)
    assert float(law.exact(100)) == pytest.approx(0.3 + 0.9 * 0.5**0.8, rel=1e-15)


def test_turning_points_hold_the_least_and_the_greatest_of_a_factor() -> None:
    random = np.random.default_rng(0)
    for _ in range(200):
        cubic = Factor("x", polynomial=tuple(random.normal(size=random.integers(1, 5))))
        at = np.sort(random.uniform(-3.0, 3.0, 5))
        table = Factor("x", at=tuple(at), value=tuple(random.uniform(0.0, 2.0, 5)))
        for drawn in (cubic, table):
            points = drawn(drawn.turning_points(-2.0, 1.5))
            everywhere = drawn(np.linspace(-2.0, 1.5, 4001))
            assert points.min() <= everywhere.min() + 1e-12
            assert points.max() >= everywhere.max() - 1e-12
            assert points.min() >= everywhere.min() - 1e-2  # they are points of the range


@pytest.mark.parametrize(
    ("time", "pwm", "start"),
    [
        ([0.0, 1.0, 1.0], [0, 0, 0], {}),
        ([0.0, 1.0], [0, 0, 0], {}),
        ([0.0, 1.0], [0, 256], {}),
        ([], np.zeros(0, dtype=np.int64), {}),
    ],
)
def test_what_is_no_run_is_refused(time: Any, pwm: Any, start: dict[str, float]) -> None:  # noqa: ANN401
    with pytest.raises(ValueError, match=r"."):
        NetworkSolution(model_of("two_nodes")).simulate_times(time, pwm, 20.0, start=start)


def test_a_start_of_no_sensed_node_is_refused() -> None:
    with pytest.raises(KeyError, match="winding"):
        NetworkSolution(model_of("two_nodes")).simulate_times([0.0, 1.0], [0, 0], 20.0, start={"winding": 30.0})


def test_transfer_functions_are_no_network() -> None:
    tree = copy.deepcopy(json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text()))
    with pytest.raises(ValueError, match="two_mass is no network"):
        NetworkSolution(parse(json.dumps(tree).encode()).model)


@pytest.mark.parametrize("name", ["two_nodes", "fan_motor", "sensor_gains", "sensor_drifts"])
def test_intervals_one_after_the_other_are_the_whole_run(name: str) -> None:
    """Two lanes side by side, each with inputs and intervals of its own, against each run solved at once."""
    model = model_of(name)
    solution, network = NetworkSolution(model), model.network
    assert network is not None
    rng = np.random.default_rng(5)
    pwm, step = rng.choice([0, 90, 200], (2, 30)), rng.uniform(1.0, 400.0, (2, 30))
    ambient = rng.uniform(15.0, 30.0, (2, 30))
    told = {channel.column: channel.neutral for channel in network.channels}
    states = solution.start({}, ambient[:, 0])
    for k in range(30):
        states = solution.advance(states, pwm[:, k], step[:, k], ambient[:, k], told)
    shown = solution.shown(states, ambient[:, -1])
    for lane in range(2):
        time = np.concatenate([[0.0], np.cumsum(step[lane])])
        whole = solution.simulate_times(
            time, np.append(pwm[lane], 0), np.append(ambient[lane], ambient[lane, -1]), told, {}
        )
        for part, course in whole.items():
            assert shown[part][lane] == pytest.approx(course[-1], abs=1e-9)
