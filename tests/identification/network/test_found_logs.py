"""Logs as people have them: a network from input that is never held, a room that nothing says, a day as one log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import gen
from gen.arrays import FloatArray
from tests.identification.network.plant import ROW_S, Plant

ROOM = 22.0
JOINT = Plant(
    capacity=(60.0, 300.0),
    links=((0, 1, 0.5),),
    surfaces=((0, 0.02, 0.0), (1, 0.4, 0.15)),
    heats=((0, 3.0, 12.0),),
    sensed={"joint": 0, "beside": 1},
)


def steps(rng: np.random.Generator, hours: float, every_s: float = 30.0) -> FloatArray:
    """Random |PWM| every half minute, none of them held."""
    rows = round(every_s / ROW_S)
    count = int(hours * 3600.0 / every_s)
    return np.repeat(rng.integers(40, 256, count).astype(np.float64), rows)


def log(rng: np.random.Generator, pwm: FloatArray, start: float | None, *, room: bool = False) -> pd.DataFrame:
    """What a logger shows, from a sensor of 0.1 K; without the ambient unless it is asked for."""
    level = pwm.astype(np.int64)
    true = JOINT.true(level, np.full(level.size, ROOM), start)
    columns = {"time_s": ROW_S * np.arange(level.size), "pwm": level}
    for name, node in JOINT.sensed.items():
        columns[f"{name}_degC"] = np.round(true[:, node] + rng.normal(0.0, 0.05, level.size), 1)
    if room:
        columns["ambient_degC"] = np.full(level.size, ROOM)
    return pd.DataFrame(columns).set_index("time_s")


def rmse(model: gen.Model, run: pd.DataFrame, part: str = "joint") -> float:
    """Of a run that took no part, K."""
    shown = gen.simulate(model, run)[f"{part}_degC"].to_numpy(dtype=np.float64)
    return float(np.sqrt(np.mean((shown - run[f"{part}_degC"].to_numpy(dtype=np.float64)) ** 2)))


@pytest.mark.parametrize("starts", [(34.0, 44.0), (ROOM, 40.0)])
def test_a_room_that_nothing_says_is_estimated_from_warm_runs(starts: tuple[float, ...]) -> None:
    """Two parts of one morning, begun 12 to 22 K over the room: the rise is some 25 K, the room is not in the log."""
    rng = np.random.default_rng(5)
    found = gen.identify([log(rng, steps(rng, 1.0), start) for start in starts], model="network")
    said = found.details()["ambient"]
    assert not said["measured"]
    assert any("nothing says the ambient" in warning for warning in found.warnings)
    assert said["unsure_K"] > 0.0
    test = log(rng, steps(rng, 1.0), 37.0)
    moved = float(np.ptp(test["joint_degC"]))
    assert rmse(found.model, test) < 0.08 * moved


def test_runs_that_begin_at_one_level_stand_in_a_room_of_that() -> None:
    """Of steps the level of the room is next to unknown: it was found 3 K off, and the test by as much."""
    rng = np.random.default_rng(8)
    held = [np.full(round(2.0 * 3600.0 / ROW_S), float(pwm)) for pwm in (70, 140, 210)]
    found = gen.identify([log(rng, pwm, None)[["pwm", "joint_degC"]] for pwm in held], model="network")
    assert found.details()["ambient"]["fixed_degC"] == pytest.approx(ROOM, abs=0.6)


@pytest.mark.parametrize("starts", [(34.0, 34.5), (34.0, 34.0, 34.5)])
def test_runs_that_begin_warm_at_one_level_say_so_themselves(starts: tuple[float, ...]) -> None:
    """A protocol with breaks begins each run where the one before did, 12 K over the room."""
    rng = np.random.default_rng(1)
    found = gen.identify([log(rng, steps(rng, 1.0), start) for start in starts], model="network")
    assert found.details()["ambient"]["fixed_degC"] == pytest.approx(ROOM, abs=2.0)
    assert any("begin at one level as if they were cold" in warning for warning in found.warnings)
    assert rmse(found.model, log(rng, steps(rng, 1.0), 37.0)) < 0.3


def test_the_parts_of_a_day_that_begin_warm_are_no_reason_to_refuse() -> None:
    """No run begins cold, and the neighbour is far from the part: there was no ambient, and a refusal."""
    rng = np.random.default_rng(6)
    runs = []
    for start in (38.0, 46.0):
        run = log(rng, steps(rng, 0.7), start)
        run["far_degC"] = 30.0 + 2.0 * np.sin(np.arange(len(run)) / 300.0)
        runs.append(run)
    found = gen.identify(runs, model="network")
    assert "joint" in found.model.components


def test_one_long_log_is_judged_on_what_was_cut_out_of_it() -> None:
    rng = np.random.default_rng(7)
    found = gen.identify([log(rng, steps(rng, 4.0), None, room=True)], model="network")
    test = log(rng, steps(rng, 1.5), None, room=True)
    left_out = found.details()["left_out_K"]
    assert rmse(found.model, test) < 0.6
    assert rmse(found.model, test) < 4.0 * max(left_out, 0.1)


def switched(duties: list[float], every_s: int, seed: int) -> pd.DataFrame:
    """A light heater that is switched on and off every 47 s, with duties of 40 minutes each, as a logger reads it."""
    rng = np.random.default_rng(seed)
    second = np.arange(2400 * len(duties))
    on = (second % 47) / 47.0 < np.repeat(duties, 2400)
    true, temperature = np.empty(second.size), ROOM
    for k, heated in enumerate(on):
        true[k] = temperature
        temperature += (100.0 * heated - 1.5 * (temperature - ROOM)) / 60.0
    rows = second[::every_s]
    read = np.round(true[rows] + rng.normal(0.0, 0.1, rows.size), 2)
    columns = {"time_s": rows, "pwm": 255 * on[rows], "heater_degC": read, "ambient_degC": np.full(rows.size, ROOM)}
    return pd.DataFrame(columns).set_index("time_s")


@pytest.mark.parametrize("every_s", [10, 30])
def test_a_log_that_is_coarser_than_its_input_gives_no_model_that_is_called_good(every_s: int) -> None:
    """Its readings jump as those of a bad sensor do, and the sensor has 0.1 K."""
    found = gen.identify([switched([0.0, 0.4, 0.8, 0.0, 0.6, 0.2, 0.0], every_s, 1)], model="network", max_hidden=1)
    missed = rmse(found.model, switched([0.0, 0.7, 0.3, 0.9, 0.0], every_s, 2), "heater")
    assert missed > 1.0
    assert not found.verdict.startswith("Good")
    assert "heater by" in found.verdict
    assert any("switches between rows as well" in warning for warning in found.warnings)


def test_a_heater_that_is_switched_on_for_a_third_of_the_time_is_a_load_like_others() -> None:
    """Its input rests for most of every bin: no bin was one of a speed."""
    rng = np.random.default_rng(11)
    rows = round(3.0 * 3600.0 / ROW_S)
    on = np.arange(rows) % 3 == 0
    level = np.repeat([200.0, 120.0, 0.0], rows // 3)
    runs = [log(rng, np.where(on, levels, 0.0), None, room=True) for levels in (level, level[::-1])]
    found = gen.identify(runs, model="network", drives="heater")
    assert found.model.coefficients.document.validity.pwm == (0, 200)
    test = log(rng, np.where(on, np.repeat([0.0, 160.0], rows // 2), 0.0), None, room=True)
    assert rmse(found.model, test) < 0.5


def test_a_run_that_holds_the_input_alone_is_no_reason_to_lose_the_report(tmp_path: Path) -> None:
    rng = np.random.default_rng(12)
    levels = [np.repeat([200.0, 0.0, 90.0], 600), np.repeat([60.0, 255.0, 0.0], 600), np.full(900, 100.0)]
    *runs, empty = (log(rng, pwm, None, room=True) for pwm in levels)
    found = gen.identify([*runs, empty[["pwm", "ambient_degC"]]], model="network")
    found.report(tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text().count("<svg") > 2 * len(runs)
