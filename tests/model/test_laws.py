"""Paths with a law, against closed forms and an adaptive method on the equations as docs/format.md has them."""

from __future__ import annotations

import copy
import json
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from gen.arrays import FloatArray
from gen.coefficients import parse
from gen.errors import InputError
from gen.model.laws import Convection, Radiation
from gen.model.network_solution import NetworkSolution
from tests.examples import ROOT

Tree = dict[str, Any]
EXAMPLE = ROOT / "examples" / "natural_cooling" / "coeffs.json"


def example() -> Tree:
    return dict(json.loads(EXAMPLE.read_text(encoding="utf-8")))


def one_node(path: Tree) -> Tree:
    """A node of 100 J/K that cools along one path of 0.5 W/K."""
    tree = copy.deepcopy(example())
    tree["network"] = {
        "nodes": [{"name": "casing", "capacity_J_per_K": 100, "sensor": {}}],
        "paths": [{"between": ["casing", "ambient"], "conductance_W_per_K": {"poly": [0.5]}, **path}],
        "heats": [{"node": "casing", "power_W": {"poly": [0.02, 0]}}],
    }
    return tree


def change(tree: Tree, pwm: int, room: float) -> Any:  # noqa: ANN401
    """dT/dt of the nodes, written down once more."""
    network = tree["network"]
    names = [node["name"] for node in network["nodes"]]

    def curve(entry: Tree) -> float:
        if "poly" in entry:
            return float(np.polyval(entry["poly"], pwm))
        law = entry["power"]
        return float(law["constant"] + law["forced"] * (pwm / tree["input"]["full_scale"]) ** law["exponent"])

    def rate(_: float, state: FloatArray) -> list[float]:
        t = dict(zip([*names, "ambient"], [*state, room], strict=True))
        flow = dict.fromkeys(t, 0.0)
        for path in network["paths"]:
            one, other = path["between"]
            heat = curve(path["conductance_W_per_K"]) * (t[other] - t[one])
            if "convection" in path:
                heat *= np.polyval(path["convection"]["poly"], abs(t[other] - t[one]))
            if "radiation" in path:
                a, b, c = (x + 273.15 for x in (t[one], t[other], path["radiation"]["reference_degC"]))
                heat = curve(path["conductance_W_per_K"]) * (b**4 - a**4) / (4.0 * c**3)
            flow[one] += heat
            flow[other] -= heat
        for heat in network["heats"]:
            rise = t[heat["node"]] - heat.get("reference_degC", 25.0)
            flow[heat["node"]] += curve(heat["power_W"]) * (1.0 + heat.get("per_K", 0.0) * rise)
        return [flow[node["name"]] / node["capacity_J_per_K"] for node in network["nodes"]]

    return rate


def test_the_solution_is_that_of_the_files_own_equations() -> None:
    tree = example()
    solution = NetworkSolution(parse(EXAMPLE.read_bytes()).model)
    time = np.arange(0.0, 600.0, 0.25)
    pwm = np.where(time // 100 % 2 == 0, 255, 40)
    room = np.where(time < 250.0, 25.0, 44.0)
    first = {"casing": 90.0, "magnet": 20.0}
    found = solution.simulate_times(time, pwm, room, start=first)
    rows = np.unique(
        np.concatenate([[0], np.flatnonzero(np.diff(pwm) | np.diff(room).astype(int)) + 1, [time.size - 1]])
    )
    state = solution.start(first, 25.0)
    for begin, end in pairwise(rows.tolist()):
        span = (time[begin], time[end])
        rate = change(tree, int(pwm[begin]), float(room[begin]))
        state = solve_ivp(rate, span, state, method="DOP853", rtol=1e-12, atol=1e-11).y[:, -1]
        assert found["casing"][end] == pytest.approx(state[0], abs=5e-9)
        assert found["magnet"][end] == pytest.approx(state[1], abs=5e-9)


@pytest.mark.parametrize("row_s", [0.25, 1.0, 5.0, 20.0, 60.0])
@pytest.mark.parametrize("uneven", [False, True])
def test_a_room_that_moves_in_every_row_is_followed(row_s: float, uneven: bool) -> None:
    """With one node that follows within three seconds, so that rows are longer than it takes."""
    tree = example()
    tree["network"]["nodes"].append({"name": "lead", "capacity_J_per_K": 4})
    tree["network"]["paths"] += [
        {"between": ["casing", "lead"], "conductance_W_per_K": {"poly": [0.5]}},
        {"between": ["lead", "ambient"], "conductance_W_per_K": {"poly": [0.4]}, "radiation": {"reference_degC": 25}},
    ]
    rng = np.random.default_rng([int(4 * row_s), uneven])
    time = row_s * np.arange(60.0)
    time[1:] += row_s * rng.uniform(-0.2, 0.2, 59) * uneven
    pwm = np.repeat(rng.integers(0, 256, 6), 10)
    room = 25.0 + rng.normal(0.0, 0.3, 60)
    solution = NetworkSolution(parse(json.dumps(tree).encode()).model)
    found = solution.states_along(time, pwm, room, start={"casing": 60.0})
    state = found[0]
    for k in range(59):
        rate = change(tree, int(pwm[k]), float(room[k]))
        state = solve_ivp(rate, (time[k], time[k + 1]), state, method="DOP853", rtol=1e-12, atol=1e-11).y[:, -1]
        assert np.allclose(found[k + 1], state, rtol=0.0, atol=5e-9)


def test_a_fan_that_changes_in_every_row_is_followed() -> None:
    """Derivatives of one row serve for rows of other channels; the rate is each row's own."""
    tree = example()
    tree["network"]["channels"] = [{"column": "fan_rpm", "range": [0, 3000], "neutral": 1000}]
    tree["network"]["paths"][-1]["factors"] = [{"channel": "fan_rpm", "poly": [1e-4, 0.9]}]
    plain = example()
    rng = np.random.default_rng(8)
    time, pwm, fan = 5.0 * np.arange(60.0), np.repeat([200, 60], 30), rng.uniform(0.0, 3000.0, 60)
    solution = NetworkSolution(parse(json.dumps(tree).encode()).model)
    found = solution.states_along(time, pwm, 25.0, {"fan_rpm": fan}, {"casing": 60.0})
    state = found[0]
    for k in range(59):
        scaled = copy.deepcopy(plain)
        path = scaled["network"]["paths"][-1]["conductance_W_per_K"]
        path.update(scaled_curve(path, 1e-4 * fan[k] + 0.9))
        rate = change(scaled, int(pwm[k]), 25.0)
        state = solve_ivp(rate, (time[k], time[k + 1]), state, method="DOP853", rtol=1e-12, atol=1e-11).y[:, -1]
        assert np.allclose(found[k + 1], state, rtol=0.0, atol=5e-9)


def scaled_curve(entry: Tree, by: float) -> Tree:
    if "poly" in entry:
        return {"poly": [by * value for value in entry["poly"]]}
    law = entry["power"]
    return {"power": {**law, "constant": by * law["constant"], "forced": by * law["forced"]}}


def test_rows_of_any_length_give_the_same() -> None:
    solution = NetworkSolution(parse(EXAMPLE.read_bytes()).model)
    fine, coarse = np.arange(0.0, 1201.0, 0.5), np.arange(0.0, 1201.0, 60.0)
    made = [solution.simulate_times(t, np.full(t.size, 200), 10.0, start={"casing": 60.0}) for t in (fine, coarse)]
    for name, shown in made[1].items():
        assert np.allclose(made[0][name][::120], shown, rtol=0.0, atol=1e-8)


def test_convection_that_grows_with_the_difference_cools_as_its_closed_form() -> None:
    """T' = -k d |d| has d = d0 / (1 + k d0 t)."""
    tree = one_node({"convection": {"poly": [0.05, 1e-9]}})
    solution = NetworkSolution(parse(json.dumps(tree).encode()).model)
    time = np.arange(0.0, 900.0, 0.25)
    for start in (90.0, -9.0):
        found = solution.simulate_times(time, np.zeros(time.size, dtype=int), 25.0, start={"casing": start})["casing"]
        rise, k = start - 25.0, 0.5 * 0.05 / 100.0
        assert np.allclose(found, 25.0 + rise / (1.0 + k * abs(rise) * time), rtol=0.0, atol=2e-6)


def test_radiation_to_the_cold_cools_as_its_closed_form() -> None:
    """T' = -k T^4 has T = (T0^-3 + 3 k t)^(-1/3), in kelvin."""
    tree = one_node({"radiation": {"reference_degC": 25}})
    solution = NetworkSolution(parse(json.dumps(tree).encode()).model)
    time = np.arange(0.0, 900.0, 1.0)
    found = solution.simulate_times(time, np.zeros(time.size, dtype=int), -273.15, start={"casing": 100.0})["casing"]
    k = 0.5 / 100.0 / (4.0 * 298.15**3)
    assert np.allclose(found + 273.15, (373.15**-3 + 3.0 * k * time) ** (-1.0 / 3.0), rtol=0.0, atol=1e-8)


@given(st.floats(-50, 200), st.floats(-50, 200), st.floats(0.01, 30))
@settings(max_examples=60)
def test_heat_grows_with_one_end_and_falls_with_the_other(one: float, other: float, more: float) -> None:
    for law in (Convection((4e-7, -1.12e-4, 0.0132, 0.76)), Radiation(25.0)):
        assert law.driving(one + more, other) > law.driving(one, other) > law.driving(one, other + more)
        assert law.driving(one, other) == pytest.approx(-law.driving(other, one))
        steps = (law.driving(one + 1e-4, other) - law.driving(one - 1e-4, other)) / 2e-4
        assert law.slope(one, other) == pytest.approx(float(steps), rel=1e-3)
        low, high = law.slope_ends(-50.0, 230.0)
        assert low * (1 - 1e-12) <= law.slope(one, other) <= high * (1 + 1e-12)
        near, far = law.slope(one, other), law.slope(one + more, other)
        assert abs(far - near) <= law.steepest(-50.0, 230.0) * more * (1 + 1e-9)


@pytest.mark.parametrize(
    ("path", "place", "message"),
    [
        ({"convection": {"poly": [-0.01, 1.0]}}, "convection", "never falls"),
        ({"convection": {"poly": [1.0, -20.0, 90.0, 1.0]}}, "convection", "never falls"),
        ({"convection": {"poly": [0.01, 0.0]}}, "nodes[0]", "no way to the ambient"),
        ({"convection": {"poly": [1.0]}, "radiation": {}}, "radiation", "a path for each"),
        ({"convection": {"poly": [1, 2, 3, 4, 5]}}, "convection.poly", "4"),
        ({"convection": {}}, "convection", "poly"),
        ({"radiation": {"reference_degC": -200}}, "radiation.reference_degC", "-100"),
        ({"radiation": {"emissivity": 0.9}}, "radiation", "emissivity"),
    ],
)
def test_what_is_no_law_is_refused_with_its_place(path: Tree, place: str, message: str) -> None:
    with pytest.raises(InputError) as found:
        parse(json.dumps(one_node(path)).encode())
    assert place in str(found.value)
    assert message in str(found.value)


def test_radiation_between_two_nodes_is_refused() -> None:
    tree = example()
    tree["network"]["paths"][2] = {**tree["network"]["paths"][2], "radiation": {}}
    with pytest.raises(
        InputError, match=r'paths\[2\].radiation: found a path between two nodes, expected one to "ambient"'
    ):
        parse(json.dumps(tree).encode())


def test_two_paths_of_a_kind_are_refused() -> None:
    tree = example()
    tree["network"]["paths"].append(tree["network"]["paths"][-1])
    with pytest.raises(
        InputError, match=r"paths\[6\].between: joins the same as paths\[5\]; expected one path of a kind"
    ):
        parse(json.dumps(tree).encode())


def test_a_law_that_is_too_fast_is_refused() -> None:
    tree = one_node({"convection": {"poly": [1.0, 1.0]}})
    with pytest.raises(InputError, match="time constant"):
        parse(json.dumps(tree).encode())
