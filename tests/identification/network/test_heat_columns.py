"""Heat that comes by a measured column: a second heater's watts, a current's square."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.linalg import expm

import gen
from gen.arrays import FloatArray, IntArray
from gen.cli import cli
from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.identify import identify_network
from gen.identification.network.telling.as_json import as_json
from gen.identification.network.telling.document import network_text
from gen.identification.network.telling.summary import Summary
from gen.identification.network.telling.text import text
from gen.identification.settings import Settings
from gen.lowering.lower import lower
from gen.model.network_solution import NetworkSolution
from gen.runs import Run, write_run
from tests.identification.network.plant import ROOM, ROW_S, TWO, holds
from tests.identification.network.test_identify import FLOOR, NOISE

HEATED = 1  # the casing
WATTS = (0.0, 25.0, 10.0, 40.0, 0.0, 15.0)


def true_temperatures(pwm: IntArray, watts: FloatArray) -> FloatArray:
    """`TWO` with so many watts more at its casing, by matrix exponentials of its own, shape (N, 2), degC."""
    state, made, steps = np.full(2, ROOM), np.empty((pwm.size, 2)), {}
    for k, level in enumerate(pwm.tolist()):
        if level not in steps:
            w = level / 255.0
            m = np.array([[-0.8, 0.8], [0.8, -0.8 - 0.3 - 0.4 * w]])
            force = np.array([[0.0, 6.0 * w + 14.0 * w * w], [1.0, (0.3 + 0.4 * w) * ROOM]])
            whole = np.zeros((4, 4))
            whole[:2] = np.hstack([m, force]) / np.array([[120.0], [300.0]])
            steps[level] = expm(whole * ROW_S)
        made[k] = state
        step = steps[level]
        state = step[:2, :2] @ state + step[:2, 2] * watts[k] + step[:2, 3]
    return made


def logged(pwm: IntArray, seed: int, columns: Sequence[str] = ("heater_W",)) -> Run:
    rng = np.random.default_rng(seed)
    held = np.repeat(rng.permutation(WATTS), -(-pwm.size // len(WATTS)))[: pwm.size]
    true = true_temperatures(pwm, held)
    temps = {
        name: np.round((true[:, node] + rng.normal(0.0, NOISE, pwm.size)) * 4.0) / 4.0
        for name, node in TWO.sensed.items()
    }
    every = {
        "heater_W": held,
        "current_A": np.sqrt(held / 0.1) * rng.choice([-1.0, 1.0], pwm.size),
        "decoy_W": np.repeat(rng.uniform(0.0, 30.0, 9), -(-pwm.size // 9))[: pwm.size],
    }
    time = ROW_S * np.arange(pwm.size, dtype=np.float64)
    return Run(time, pwm, temps, np.full(pwm.size, ROOM), {name: every[name] for name in columns})


PROFILES = (
    holds((200, 50), (60, 50), (0, 40)),
    holds((90, 50), (255, 40), (0, 30)),
    holds((0, 40), (150, 60), (30, 30)),
)
FRESH = holds((180, 40), (0, 40), (100, 50))


def identified(heat: Sequence[str], columns: Sequence[str] = ("heater_W",)) -> tuple[Coefficients, Summary]:
    runs = [Source(f"run_{k}.csv", logged(pwm, k, columns)) for k, pwm in enumerate(PROFILES)]
    result = identify_network(make_network_data(runs, None, heat=heat), lambda _: None, 0)
    return network_text(result, Settings("plant"))[1], Summary(result)


def off(loaded: Coefficients, run: Run, watts: FloatArray) -> float:
    """Root mean square of model minus truth, K."""
    start = dict.fromkeys(TWO.sensed, ROOM)
    assert run.ambient is not None
    shown = NetworkSolution(loaded.model).simulate_times(run.time_s, run.pwm, run.ambient, run.extras, start)
    true = true_temperatures(run.pwm, watts)
    return float(np.sqrt(np.mean([(shown[name] - true[:, node]) ** 2 for name, node in TWO.sensed.items()])))


@pytest.mark.parametrize("column", ["heater_W", "current_A"])
def test_what_a_column_heats_is_found_and_predicted(column: str) -> None:
    fresh = logged(FRESH, 77, ("heater_W", column))
    watts = fresh.extras["heater_W"]
    loaded, summary = identified([column], [column])
    assert off(loaded, fresh, watts) < FLOOR
    without, _ = identified([], [column])
    assert off(without, fresh, watts) > 5.0 * FLOOR
    network = loaded.model.network
    assert network is not None
    assert [channel.column for channel in network.channels] == [column]
    # Nearly all of it at the casing, by the column's largest.
    fed = {heat["node"]: heat["power_W"]["value"] for heat in as_json(summary)["heats_by_column"]}
    assert fed["casing"] > 10.0 * fed.get("winding", 0.0)
    assert f"by {column}" in text(summary)
    assert f"steady rise (K) by PWM, without the heat of {column}" in text(summary)
    assert lower(loaded, "fixed", "table").network is not None


def test_a_column_that_heats_nothing_does_no_harm() -> None:
    fresh = logged(FRESH, 78, ("heater_W", "decoy_W"))
    loaded, _ = identified(["heater_W", "decoy_W"], ["heater_W", "decoy_W"])
    assert off(loaded, fresh, fresh.extras["heater_W"]) < 2.0 * FLOOR


@pytest.mark.filterwarnings("error")
def test_columns_that_might_heat_are_told() -> None:
    """Not one without any value, which is let pass without a word."""
    _, summary = identified([])
    assert "not used: heater_W; what else heats the motor, and the board can measure, tell with --heat" in text(summary)


@pytest.mark.parametrize(
    ("heat", "said"),
    [
        (["drag_N"], "found no values of drag_N"),
        (["heater_W", "heater_W^1"], r"found 'heater_W\^1' twice"),
        (["heater_W^3"], "found 'heater_W\\^3', expected a column such as"),
        (["current_A^1"], "no heat is below 0"),
    ],
)
def test_a_column_that_cannot_heat_is_refused(heat: Sequence[str], said: str) -> None:
    run = logged(PROFILES[0], 1, ("heater_W", "current_A"))
    with pytest.raises(InputError, match=said):
        make_network_data([Source("run.csv", run)], None, heat=heat)


@pytest.mark.parametrize("heat", [["heater_W^1"], ["heater_W^1", "heater_W^2"]])
def test_a_meter_may_read_a_little_below_nothing_and_heat_go_with_value_and_square(
    heat: Sequence[str],
) -> None:
    """As a current's does where brushes drop a voltage and copper has a resistance; the board measures it once."""
    runs = [Source(f"run_{k}.csv", logged(pwm, k, ("heater_W",))) for k, pwm in enumerate(PROFILES)]
    for source in runs:
        source.run.extras["heater_W"][:] += np.random.default_rng(5).normal(0.0, 0.4, source.run.time_s.size)
    assert min(float(source.run.extras["heater_W"].min()) for source in runs) < -0.5
    data = make_network_data(runs, None, heat=heat)
    assert [(one.power, one.low) for one in data.driving] == [(power, 0.0) for power in range(1, len(heat) + 1)]
    result = identify_network(data, lambda _: None, 0)
    loaded = network_text(result, Settings("plant"))[1]
    network = loaded.model.network
    assert network is not None
    assert [(channel.column, channel.low) for channel in network.channels] == [("heater_W", 0.0)]
    fresh = logged(FRESH, 77)
    assert off(loaded, fresh, fresh.extras["heater_W"]) < 4.0 * FLOOR  # what is cut off at nothing is a mean of 0.16 W
    assert "heats nothing that is seen" not in text(Summary(result))


def test_a_column_that_never_changes_is_refused() -> None:
    run = logged(PROFILES[0], 1)
    run.extras["heater_W"][:] = 4.0
    with pytest.raises(InputError, match="column heater_W is 4 in every row of every run"):
        make_network_data([Source("run.csv", run)], None, heat=["heater_W"])


def test_parts_take_no_heat_and_auto_takes_the_network(tmp_path: Path) -> None:
    """By the command, too, whose page tells of it."""
    write_run(tmp_path / "run.csv", logged(PROFILES[0], 1))
    with pytest.raises(InputError, match="parts take none, expected a network"):
        gen.identify([tmp_path / "run.csv"], model="parts", heat="heater_W")
    arguments = [
        "identify",
        "run.csv",
        "--heat",
        "heater_W",
        "--max-hidden",
        "0",
        "--out",
        "m.json",
        "--report",
        "m.html",
    ]
    with chdir(tmp_path):
        said = CliRunner().invoke(cli, arguments)
    assert said.exit_code == 0, said.output
    assert "of them by heater_W" in said.output
    (channel,) = json.loads((tmp_path / "m.json").read_text())["network"]["channels"]
    assert channel == {"column": "heater_W", "range": [0.0, 50.0], "neutral": 0.0}
    page = (tmp_path / "m.html").read_text()
    assert "Heats by measured columns" in page


def test_a_temperature_heats_nothing() -> None:
    source = Source("pump.csv", logged(PROFILES[0], 0))
    with pytest.raises(
        InputError, match=r"found the temperature casing_degC, .* it is the ambient: name it ambient_degC"
    ):
        make_network_data([source], None, heat=["casing_degC"])
