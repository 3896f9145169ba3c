"""`gen refine` on a network: names, errors, what is not learnt; motors are changed files with exact solutions."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import gen
from gen.cli import cli
from gen.coefficients import parse
from gen.model.network_solution import NetworkSolution
from gen.runs import Run
from tests.refinement.network.motor import NOISE_K, ROW_S, Tree, profile, read, run, tree, wave, write


def files(motor: Tree, folder: Path, channels: dict[str, tuple[float, float]] | None = None) -> list[Path]:
    """Three runs of a motor: two to learn from, one to test."""
    read_as = read(motor)
    made = []
    for seed in (1, 2, 3):
        told = {name: wave(10 * seed + k, *ends) for k, (name, ends) in enumerate((channels or {}).items())}
        made.append(write(run(read_as, seed, told), folder / f"run_{seed}.csv"))
    return made


def refined(motor: Tree, folder: Path, channels: dict[str, tuple[float, float]] | None = None) -> gen.Refinement:
    path = folder / "small.json"
    path.write_text(json.dumps(tree()), encoding="utf-8")
    one, two, three = files(motor, folder, channels)
    return gen.refine(gen.load(path), fit=[one, two], test=[three])


def error_K(found: gen.Refinement, folder: Path) -> float:
    """On the test run, against what was read: what `gen simulate` gives for the refined file."""
    simulated, measured = gen.simulate(found.model, folder / "run_3.csv"), gen.read_run(folder / "run_3.csv")
    columns = [f"{name}_degC" for name in found.model.components]
    away = simulated[columns].to_numpy() - measured[columns].to_numpy()
    return float(np.sqrt(np.nanmean(away**2)))


def test_a_healthy_motor_lacks_nothing(tmp_path: Path) -> None:
    found = refined(tree(), tmp_path)
    assert (found.verdict, len(found.effects())) == ("nothing missing", 0)
    assert error_K(found, tmp_path) < 1.1 * NOISE_K


def test_nothing_is_sought_where_the_file_explains_its_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """However little it takes to begin a search: its numbers might be others, and each name is one too many."""
    monkeypatch.setattr("gen.refinement.network.tracing.search.ENOUGH", 0.0)
    found = refined(tree(), tmp_path)
    assert found.verdict == "nothing missing"
    assert [step["candidates"] for step in found.details()["considered"]] == [[]]


def test_a_mass_that_the_model_lacks_is_found_and_written(tmp_path: Path) -> None:
    motor = tree()
    motor["network"]["nodes"].append({"name": "fins", "capacity_J_per_K": 300})
    motor["network"]["paths"] += [
        {"between": ["casing", "fins"], "conductance_W_per_K": {"poly": [0.25]}},
        {"between": ["fins", "ambient"], "conductance_W_per_K": {"poly": [0.1]}},
    ]
    found = refined(motor, tmp_path)
    assert found.effects().iloc[0].to_dict()["effect"] == "hidden_node"
    assert found.verdict == "explained"
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    network = found.model.coefficients.model.network
    assert network is not None
    assert [node.name for node in network.hidden] == ["hidden1"]


def test_a_hidden_part_may_heat_by_any_power_of_speed(tmp_path: Path) -> None:
    """A load's current hardly changes with speed: heat that goes with the square would not do."""
    motor = tree()
    motor["network"]["nodes"].append({"name": "coil", "capacity_J_per_K": 90})
    motor["network"]["paths"].append({"between": ["casing", "coil"], "conductance_W_per_K": {"poly": [0.15]}})
    watts = {"power": {"constant": 0.0, "forced": 3.0, "exponent": 0.4}, "at_rest": 0.0}
    motor["network"]["heats"].append({"node": "coil", "power_W": watts})
    found = refined(motor, tmp_path)
    effect = found.details()["effects"][0]
    assert (effect["name"], effect["component"]) == ("hidden_node", "casing")
    assert effect["parameters"]["exponent"] == pytest.approx(0.4, abs=0.15)
    assert error_K(found, tmp_path) < 1.2 * NOISE_K


def test_a_fan_is_found_by_its_channel(tmp_path: Path) -> None:
    motor = tree()
    motor["network"]["channels"] = [{"column": "fan_mps", "range": [0, 10], "neutral": 0}]
    motor["network"]["paths"][1]["factors"] = [{"channel": "fan_mps", "poly": [0.15, 1.0]}]
    found = refined(motor, tmp_path, {"fan_mps": (0.0, 6.0), "humidity_pct": (30.0, 60.0)})
    effect = found.details()["effects"][0]
    assert (effect["name"], effect["parameters"]["channel"]) == ("airflow", "fan_mps")
    assert effect["parameters"]["gain_at_most_flow"] == pytest.approx(0.9, rel=0.1)
    assert error_K(found, tmp_path) < 1.2 * NOISE_K


def test_a_flap_that_shuts_at_rest_leaves_next_to_nothing(tmp_path: Path) -> None:
    motor = tree()
    conductance = motor["network"]["paths"][1]["conductance_W_per_K"]
    conductance["at_rest"] *= 0.02
    found = refined(motor, tmp_path)
    row = found.effects().iloc[0].to_dict()
    assert row["effect"] == "standstill_cooling"
    assert max(row["parameters"].values()) < 0.1
    assert error_K(found, tmp_path) < 1.2 * NOISE_K


def test_another_heat_backwards_is_found_and_the_file_reads_the_sign_of_pwm(tmp_path: Path) -> None:
    motor = tree()
    motor["network"]["channels"] = [{"column": "pwm", "range": [-255, 255], "neutral": 0}]
    motor["network"]["heats"][0]["factors"] = [{"channel": "pwm", "table": {"at": [-1, 0], "value": [1.35, 1.0]}}]
    found = refined(motor, tmp_path)
    row = found.effects().iloc[0].to_dict()
    assert (row["effect"], row["component"]) == ("direction", "winding")
    assert row["parameters"]["more_backwards"] == pytest.approx(0.35, abs=0.05)
    assert error_K(found, tmp_path) < 1.2 * NOISE_K


def test_a_narrow_error_of_all_schedules_is_found_as_one(tmp_path: Path) -> None:
    """Such as a resonance: all heat grows by a fifth about half speed, within a tenth of full speed."""
    motor = tree()
    pwm = np.arange(0, 256, 5)
    bump = 1.0 + 0.2 * np.exp(-0.5 * ((pwm / 255.0 - 0.5) / 0.07) ** 2)
    for heat in motor["network"]["heats"]:
        watts = np.polyval(heat["power_W"]["poly"], pwm) * bump
        heat["power_W"] = {"table": {"pwm": pwm.tolist(), "value": watts.tolist(), "interpolation": "linear"}}
    found = refined(motor, tmp_path)
    effects = found.details()["effects"]
    assert [(effect["name"], effect["component"]) for effect in effects] == [("schedule_error", "motor")]
    assert error_K(found, tmp_path) < 1.5 * NOISE_K


def test_heat_that_has_grown_at_one_part_is_told_and_not_learnt(tmp_path: Path) -> None:
    motor = tree()
    motor["network"]["heats"][1]["power_W"] = {"poly": [0.03, 0.0]}
    found = refined(motor, tmp_path)
    assert found.effects().iloc[0].to_dict()["component"] == "casing"
    assert found.verdict == "partly explained"
    assert any("fault" in warning and "casing" in warning for warning in found.warnings)
    assert found.model.text == found.baseline.text
    assert "Nothing of it is in the file" in found.html()
    one, two, three = (tmp_path / f"run_{seed}.csv" for seed in (1, 2, 3))
    accepted = gen.refine(found.baseline, fit=[one, two], test=[three], accept_change=True)
    assert error_K(accepted, tmp_path) < 1.2 * NOISE_K
    assert "Nothing of it is in the file" not in accepted.html()


def test_grease_that_thins_as_it_warms_is_named_and_the_file_says_how_far_it_holds(tmp_path: Path) -> None:
    motor = tree()
    motor["network"]["heats"][1] |= {"per_K": -0.025, "reference_degC": 25}
    found = refined(motor, tmp_path)
    (effect,) = found.details()["effects"]
    assert (effect["name"], effect["component"]) == ("temperature_dependent_loss", "casing")
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    told = [re.search(r"is none at ([\d.]+) degC and negative at 200 degC", warning) for warning in found.warnings]
    assert [float(said[1]) for said in told if said] == [pytest.approx(65.0, abs=1.0)]


def test_a_room_that_moves_is_read_from_its_column(tmp_path: Path) -> None:
    runs = files(tree(), tmp_path)
    fixed = tree()
    fixed["ambient"] = {"fixed_degC": 24}
    (tmp_path / "small.json").write_text(json.dumps(fixed), encoding="utf-8")
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=runs[:2], test=runs[2:])
    assert found.effects()["effect"].tolist() == ["ambient"]
    assert found.verdict == "explained"
    assert found.model.coefficients.model.ambient_channel == "ambient_degC"


def test_a_file_whose_room_was_taken_too_low_gets_no_effect_for_it(tmp_path: Path) -> None:
    """What somebody identified with 23.2 degC for a room of 24 settles 0.8 K too high above it, at each speed."""
    pwm = np.arange(0, 256, 5)
    outer = np.where(pwm == 0, 0.18, 0.2 + 0.3 * (pwm / 255.0) ** 0.8)
    fixed = tree()
    fixed["ambient"] = {"fixed_degC": 23.2}
    watts = np.polyval(fixed["network"]["heats"][1]["power_W"]["poly"], pwm) + 0.8 * outer
    fixed["network"]["heats"][1]["power_W"] = {
        "table": {"pwm": pwm.tolist(), "value": watts.tolist(), "interpolation": "pchip"}
    }
    runs = files(tree(), tmp_path)
    (tmp_path / "small.json").write_text(json.dumps(fixed), encoding="utf-8")
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=runs[:2], test=runs[2:])
    assert found.effects()["effect"].tolist() == ["ambient"]
    assert error_K(found, tmp_path) < 1.4 * NOISE_K


def test_a_room_that_moves_is_told_although_something_else_errs_by_more(tmp_path: Path) -> None:
    """A narrow error of the schedule moves the motor by ten times what the room does."""
    motor = tree()
    pwm = np.arange(0, 256, 5)
    factor = 1.0 + 1.5 * np.exp(-(((pwm - 150) / 40.0) ** 2))
    for heat in motor["network"]["heats"]:
        watts = factor * np.polyval(heat["power_W"]["poly"], pwm)
        heat["power_W"] = {"table": {"pwm": pwm.tolist(), "value": watts.tolist(), "interpolation": "pchip"}}
    runs = files(motor, tmp_path)
    fixed = tree()
    fixed["ambient"] = {"fixed_degC": 24}
    (tmp_path / "small.json").write_text(json.dumps(fixed), encoding="utf-8")
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=runs[:2], test=runs[2:])
    assert set(found.effects()["effect"]) == {"ambient", "schedule_error"}
    assert found.model.coefficients.model.ambient_channel == "ambient_degC"


def with_drift(made: Run, settles_h: float | None) -> Run:
    """A casing's sensor that moves by 0.8 K in the first hour, and on or not."""
    hours = (made.time_s - made.time_s[0]) / 3600.0
    drift = 0.8 * (hours if settles_h is None else settles_h * -np.expm1(-hours / settles_h))
    return replace(made, temps={**made.temps, "casing": made.temps["casing"] + drift})


@pytest.mark.parametrize("settles_h", [None, 1.5])
def test_a_sensor_that_drifts_is_named_and_its_drift_taken_off(settles_h: float | None, tmp_path: Path) -> None:
    (tmp_path / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    given = [write(with_drift(run(read(tree()), seed), settles_h), tmp_path / f"run_{seed}.csv") for seed in (1, 2, 3)]
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=given[:2], test=given[2:])
    effect = found.details()["effects"][0]
    assert (effect["name"], effect["component"]) == ("drift", "casing")
    assert "mend the sensor" in effect["evidence"]["note"]
    assert found.verdict == "explained"
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    network = found.model.coefficients.model.network
    assert network is not None
    sensor = network.nodes[network.index("casing")].sensor
    assert sensor is not None
    assert 3600.0 * sensor.drift / sensor.settling == pytest.approx(0.8, rel=0.15)
    # Runs with the same drift hold nothing new, and another drift is not put on top.
    again = gen.refine(found.model, fit=given[:2], test=given[2:])
    assert (again.verdict, len(again.effects())) == ("nothing missing", 0)


def test_what_is_found_beside_a_drift_is_right_once_that_is_gone(tmp_path: Path) -> None:
    (tmp_path / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    motor = tree()
    motor["network"]["paths"][1]["conductance_W_per_K"]["at_rest"] = 0.5
    given = [write(with_drift(run(read(motor), seed), None), tmp_path / f"run_{seed}.csv") for seed in (1, 2, 3)]
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=given[:2], test=given[2:])
    assert {(one["name"], one["component"]) for one in found.details()["effects"]} == {
        ("standstill_cooling", "motor"),
        ("drift", "casing"),
    }
    assert found.verdict == "explained"
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    # The sensor is mended, and its drift taken out of the file.
    mended = json.loads(found.model.text)
    for node in mended["network"]["nodes"]:
        for key in ("drift_K", "drift_h"):
            node.get("sensor", {}).pop(key, None)
    (tmp_path / "mended.json").write_text(json.dumps(mended), encoding="utf-8")
    sound = write(run(read(motor), 4), tmp_path / "sound.csv")
    shown = gen.simulate(gen.load(tmp_path / "mended.json"), sound)
    for name, seen in gen.read_run(sound).items():
        if name in ("winding_degC", "casing_degC"):
            assert float(np.sqrt(np.mean((shown[name] - seen) ** 2))) < 1.5 * NOISE_K


@pytest.mark.parametrize(
    ("name", "number", "planted"),
    [("sensor_offset", "offset_K", -6.5), ("sensor_gain", "gain_error", -0.35)],
)
def test_a_sensor_that_is_far_off_is_named_and_measured(name: str, number: str, planted: float, tmp_path: Path) -> None:
    """Each run then begins at a wrong reading: the start is as wrong as the sensor, and the motor is as it was."""
    (tmp_path / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    given = []
    for seed in (1, 2, 3):
        made = run(read(tree()), seed)
        assert made.ambient is not None
        wrong = planted if name == "sensor_offset" else planted * (made.temps["casing"] - made.ambient)
        given.append(
            write(
                replace(made, temps=made.temps | {"casing": made.temps["casing"] + wrong}), tmp_path / f"run_{seed}.csv"
            )
        )
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=given[:2], test=given[2:])
    effect = found.details()["effects"][0]
    assert (effect["name"], effect["component"]) == (name, "casing")
    assert effect["parameters"][number] == pytest.approx(planted, rel=0.02)
    assert found.verdict == "explained"
    assert error_K(found, tmp_path) < 1.1 * NOISE_K


def test_a_sensor_that_lags_by_half_an_hour_is_measured(tmp_path: Path) -> None:
    (tmp_path / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    given, lag_s = [], 1500.0
    for seed in (1, 2, 3):
        made = run(read(tree()), seed)
        true, shown = made.temps["casing"], [float(made.temps["casing"][0])]
        for before, now in zip(true[:-1].tolist(), true[1:].tolist(), strict=True):
            shown.append(shown[-1] + (0.5 * (before + now) - shown[-1]) * -np.expm1(-ROW_S / lag_s))
        noise = np.random.default_rng(seed).normal(0.0, NOISE_K, true.size)
        lagging = np.round(4.0 * (np.array(shown) + noise)) / 4.0
        given.append(write(replace(made, temps=made.temps | {"casing": lagging}), tmp_path / f"run_{seed}.csv"))
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=given[:2], test=given[2:])
    effect = found.details()["effects"][0]
    assert (effect["name"], effect["component"]) == ("sensor_lag", "casing")
    assert effect["parameters"]["lag_s"] == pytest.approx(lag_s, rel=0.05)


def test_what_is_printed_is_what_simulate_gives(tmp_path: Path) -> None:
    motor = tree()
    motor["network"]["paths"][0]["conductance_W_per_K"] = {"poly": [0.3]}
    found = refined(motor, tmp_path)
    told = found.details()["after"]["test"]["rmse_K"]
    assert told == pytest.approx(error_K(found, tmp_path), rel=1e-6)


def test_the_command_writes_file_summary_and_report(tmp_path: Path) -> None:
    motor = tree()
    motor["network"]["paths"][1]["conductance_W_per_K"]["at_rest"] = 0.5
    one, two, three = files(motor, tmp_path)
    (tmp_path / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    out, summary, report = (tmp_path / name for name in ("out.json", "summary.json", "report.html"))
    given = [str(tmp_path / "small.json"), "--fit", str(one), str(two), "--test", str(three)]
    written = ["--out", str(out), "--json", str(summary), "--report", str(report)]
    result = CliRunner().invoke(cli, ["refine", *given, *written])
    assert result.exit_code == 0, result.output
    assert "standstill_cooling" in result.output
    assert parse(out.read_bytes()).model.network is not None
    said = json.loads(summary.read_text(encoding="utf-8"))
    assert said["effects"][0]["name"] == "standstill_cooling"
    assert set(said["before"]) == {"fit", "test", "per_run"}
    page = report.read_text(encoding="utf-8")
    assert "standstill_cooling" in page
    assert "<svg" in page
    # What the caption says: paths to the room are grey like all others, but for those that conduct otherwise.
    assert "Orange is what was added, what conducts otherwise than before" in page
    assert "svg .way.out {" not in page
    before, after = re.findall(r'<svg [^>]*class="network".*?</svg>', page, re.DOTALL)
    assert "added" not in before
    assert re.search(r'class="way out added', after)
    places = [re.findall(r'<circle class="node[^"]*" (c[^/]*)', picture) for picture in (before, after)]
    assert len(places[0]) == 2
    assert places[0] == places[1]
    assert "model before" in page


def test_runs_that_begin_warm_inside_are_told_and_the_file_starts_so(tmp_path: Path) -> None:
    """Sensors sit outside; each run begins a minute after another one."""
    made = tree()
    made["network"]["nodes"][0].pop("sensor")
    made["provenance"]["fit"].pop("winding")
    given = []
    for seed in (1, 2, 3):
        pwm = np.concatenate([np.full(1500, 140 + 30 * seed), np.zeros(15), profile(seed)]).astype(np.int64)
        time, room = ROW_S * np.arange(pwm.size), np.full(pwm.size, 24.0)
        shown = NetworkSolution(read(made).model).simulate_times(time, pwm, room, None, {"casing": 24.0})["casing"]
        shown = shown + np.random.default_rng(seed).normal(0.0, NOISE_K, pwm.size)
        later = Run(time[1515:] - time[1515], pwm[1515:], {"casing": shown[1515:]}, room[1515:])
        given.append(write(later, tmp_path / f"run_{seed}.csv"))
    (tmp_path / "small.json").write_text(json.dumps(made), encoding="utf-8")
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=given[:2], test=given[2:])
    assert found.effects()["effect"].tolist() == ["initial_state"]
    assert found.verdict == "explained"
    node = found.model.coefficients.model.network
    assert node is not None
    assert node.hidden[0].start_factor > 1.1
    before, after = (found.details()[when]["test"]["rmse_K"] for when in ("before", "after"))
    assert before > 4.0 * NOISE_K
    assert after < 0.5 * before


def test_runs_that_begin_behind_a_room_that_moved_have_no_effect_of_that_name(tmp_path: Path) -> None:
    """Nothing has run before: the part without a sensor still is as warm as the room was half an hour ago."""
    made = tree()
    made["network"]["nodes"][0].pop("sensor")
    made["network"]["nodes"][0]["capacity_J_per_K"] = 1500
    made["provenance"]["fit"].pop("winding")
    given = []
    for seed in (1, 2, 3, 4, 5):
        pwm = np.concatenate([np.zeros(5400), profile(seed)]).astype(np.int64)
        time = ROW_S * np.arange(pwm.size)
        room = 24.0 + 10.0 * np.sin(time / 2500.0 + 2.0 + np.pi * seed)
        shown = NetworkSolution(read(made).model).simulate_times(time, pwm, room, None, {"casing": 24.0})["casing"]
        shown = shown + np.random.default_rng(seed).normal(0.0, 0.5 * NOISE_K, pwm.size)
        later = Run(time[5400:] - time[5400], pwm[5400:], {"casing": shown[5400:]}, room[5400:])
        given.append(write(later, tmp_path / f"run_{seed}.csv"))
    (tmp_path / "small.json").write_text(json.dumps(made), encoding="utf-8")
    found = gen.refine(gen.load(tmp_path / "small.json"), fit=given[:4], test=given[4:])
    assert found.effects()["effect"].tolist() == []
    assert len([warning for warning in found.warnings if "room as it was before" in warning]) == 1
    node = found.model.coefficients.model.network
    assert node is not None
    # At these phases it is 9.82 K from the room where the casing, at which it would rest, is 7.81 K from it.
    assert node.hidden[0].start_factor == pytest.approx(9.82 / 7.81, rel=0.02)
    before, after = (found.details()[when]["test"]["rmse_K"] for when in ("before", "after"))
    assert before > 5.0 * NOISE_K
    assert after < NOISE_K
