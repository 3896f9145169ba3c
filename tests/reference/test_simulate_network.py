"""`gen simulate` with a network: what a run drives it with, and where it starts."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.coefficients import load
from gen.errors import InputError
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.model.network_solution import NetworkSolution
from gen.reference.simulate import simulate_run
from gen.runs import Run
from tests.examples import ROOT, example

NAN = float("nan")
TIME = np.array([10.0, 10.25, 40.0, 400.0, 3000.0, 3000.5])
PWM = np.array([255, 255, -128, 0, 60, 60])
ROOM = np.array([20.0, 20.5, 24.0, 23.0, 22.0, 22.0])
FAN = np.array([0.0, 30.0, 100.0, 100.0, 10.0, 0.0])


def run(ambient: FloatArray | None = None, extras: dict[str, FloatArray] | None = None, **temps: FloatArray) -> Run:
    return Run(TIME, PWM, dict(temps), ambient, extras or {})


def test_it_is_the_exact_solution_with_what_the_run_measured() -> None:
    network = example("network")
    casing = np.array([31.0, 31.0, 30.0, 29.0, 28.0, 28.0])
    shown = simulate_run(network, run(ROOM, {"fan_percent": FAN}, casing=casing), "exact", "auto", "run.csv")
    start = {"casing": 31.0}
    solved = NetworkSolution(network.model).simulate_times(TIME, PWM, ROOM, {"fan_percent": FAN}, start)
    assert list(shown) == ["time_s", "bearing_degC", "brush_degC", "magnet_degC", "casing_degC"]
    for name, values in solved.items():
        np.testing.assert_array_equal(shown[f"{name}_degC"], values)
    assert shown["casing_degC"][0] == pytest.approx(31.0, abs=1e-12)
    assert shown["bearing_degC"][0] == 20.0


def test_the_fixed_ambient_holds_where_none_was_measured() -> None:
    shown = simulate_run(example("two_nodes"), run(), "exact", "auto", "run.csv")
    solved = NetworkSolution(example("two_nodes").model).simulate_times(TIME, PWM, 25.0)
    np.testing.assert_array_equal(shown["casing_degC"], solved["casing"])


def test_it_starts_at_ambient_if_that_is_asked_for() -> None:
    warm = np.full(TIME.size, 60.0)
    shown = simulate_run(example("two_nodes"), run(ROOM, casing=warm), "exact", "ambient", "run.csv")
    assert shown["casing_degC"][0] == 20.0
    with pytest.raises(InputError, match="no measured temperature to start from") as caught:
        simulate_run(example("two_nodes"), run(ROOM), "exact", "measured", "run.csv")
    assert caught.value.place == "column casing_degC"


def test_a_channel_that_the_network_reads_must_be_there() -> None:
    empty = {"fan_percent": np.full(TIME.size, NAN)}
    for extras in ({}, {"fan": FAN}, empty):
        with pytest.raises(InputError) as caught:
            simulate_run(example("network"), run(ROOM, extras), "exact", "auto", "run.csv")
        assert str(caught.value) == "run.csv: header: the network needs the column fan_percent"


def test_gaps_in_a_channel_are_held() -> None:
    gaps = {"fan_percent": np.array([NAN, 30.0, NAN, NAN, 10.0, NAN])}
    held = {"fan_percent": np.array([30.0, 30.0, 30.0, 30.0, 10.0, 10.0])}
    shown = simulate_run(example("network"), run(ROOM, gaps), "exact", "auto", "run.csv")
    expected = simulate_run(example("network"), run(ROOM, held), "exact", "auto", "run.csv")
    for name, values in expected.items():
        np.testing.assert_array_equal(shown[name], values)


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("start", ["auto", "ambient"])
def test_the_board_shows_wrong_gains_as_the_exact_solution_does(
    start: Literal["auto", "ambient"], arithmetic: Arithmetic
) -> None:
    """In a room that jumps: a gain of the rise counts from the ambient of the row itself, also at the last one."""
    motor = load(ROOT / "tests" / "coefficients" / "version2" / "sensor_gains.json")
    room = np.array([20.0, 30.0, 24.0, 13.0, 22.0, 40.0])
    given = run(room, brush=np.full(TIME.size, 31.0))
    exact = simulate_run(motor, given, "exact", start, "run.csv")
    board = simulate_run(motor, given, arithmetic, start, "run.csv")
    on_grid = (TIME - TIME[0]) % 0.25 == 0.0
    assert on_grid.all()
    network = lower(motor, arithmetic, "table").network
    assert network is not None
    for part in network.components():
        # A start is told in whole thousandths.
        away = np.abs(board[f"{part.name}_degC"] - exact[f"{part.name}_degC"])
        assert away.max() <= part.proof.bound_K + 0.0005
    first = {"brush": 31.0 if start == "auto" else 20.7, "casing": 1.06 * 20.0, "mount": 19.7}
    for name, reading in first.items():
        assert exact[f"{name}_degC"][0] == pytest.approx(reading, abs=1e-9)
        assert board[f"{name}_degC"][0] == pytest.approx(reading, abs=6e-4)
