"""`gen init`: from a model, or from logs, to a board that can be built and emulated, without copying an example."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from gen.cli import cli
from gen.coefficients import load
from gen.coefficients.wiring import Wiring
from gen.errors import InputError
from gen.model import ThermalModel
from gen.model.network_solution import NetworkSolution
from gen.runs import Run, read_run, write_run
from tests.examples import ALL, ROOT

NETWORK = ROOT / "examples" / "two_nodes" / "coeffs.json"
TAU_S, RISE_K = 500.0, 0.25  # rise per count


def invoke(*arguments: str | Path) -> Result:
    done = CliRunner().invoke(cli, [str(argument) for argument in arguments])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def gen(*arguments: str | Path) -> str:
    done = invoke(*arguments)
    assert done.exit_code == 0, done.output
    return done.output


def log(path: Path, pwm: int, seed: int, model: ThermalModel | None = None) -> Path:
    """A motor that heats and cools, in quarter degrees, with current and speed beside it."""
    time = np.arange(0.0, 5000.0, 5.0)
    command = np.where(time < 3000.0, pwm, 0)
    if model is None:
        on = RISE_K * pwm * -np.expm1(-np.minimum(time, 3000.0) / TAU_S)
        rise = on * np.exp(-np.maximum(time - 3000.0, 0.0) / TAU_S)
    else:
        rise = NetworkSolution(model).simulate_times(time, command, np.full(time.size, 25.0), {}, {})["casing"] - 25.0
    rng = np.random.default_rng(seed)
    casing = np.round((25.0 + rise + rng.normal(0.0, 0.1, time.size)) * 4.0) / 4.0
    extras = {"current_A": np.where(command > 0, 4.0, 0.0), "speed_rpm": command * 10.0}
    write_run(path, Run(time, command, {"casing": casing}, np.full(time.size, 25.0), extras))
    return path


def wiring(path: Path) -> Wiring:
    found = load(path).document.wiring
    assert found is not None
    return found


def emulated(coefficients: Path, folder: Path) -> Run:
    """Build the project, and let its firmware run for a while."""
    gen("build", coefficients, "--out", folder / "firmware")
    gen("emulate", coefficients, "--duration", "20", "--profile", "0:150", "--out", folder / "emulated.csv")
    return read_run(folder / "emulated.csv")


def test_an_identified_model_goes_on_to_the_emulated_board(tmp_path: Path) -> None:
    runs = [log(tmp_path / f"cold{pwm}.csv", pwm, pwm) for pwm in (100, 180)]
    healthy = [log(tmp_path / f"healthy{seed}.csv", 140, seed) for seed in (1, 2)]
    gen("identify", *runs, "--model", "parts", "--out", tmp_path / "identified.json", "--name", "small")
    gen("init", tmp_path / "identified.json", "--out", tmp_path / "motor.json")
    run = emulated(tmp_path / "motor.json", tmp_path)
    assert run.time_s[-1] > 15.0
    assert np.isfinite(run.temps["casing"]).all()
    assert set(np.unique(run.pwm[1:])) == {150}
    assert np.all(run.extras["alarms"] == 0)

    gen("init", *healthy, "--out", tmp_path / "rules.json")
    gen(
        "thresholds",
        tmp_path / "identified.json",
        *healthy,
        "--rules",
        tmp_path / "rules.json",
        "--out",
        tmp_path / "t.json",
    )
    document = load(tmp_path / "t.json").document
    assert [rule.name for rule in document.alarms] == ["casing_hot", "casing_limit"]
    assert all("healthy runs" in rule.note for rule in document.alarms)
    made = wiring(tmp_path / "t.json")
    assert made.encoder is not None
    run = emulated(tmp_path / "t.json", tmp_path)
    assert run.extras["speed_rpm"][-1] > 0.0
    assert np.isfinite(run.extras["current_A"]).all()


def test_a_network_goes_on_to_the_emulated_board(tmp_path: Path) -> None:
    said = gen("init", NETWORK, "--out", tmp_path / "motor.json")
    assert "no rule compares with the model: the file declares no error" in said
    assert np.isfinite(emulated(tmp_path / "motor.json", tmp_path).temps["casing"]).all()

    healthy = [log(tmp_path / f"healthy{seed}.csv", 140, seed, load(NETWORK).model) for seed in (1, 2)]
    gen("init", NETWORK, *healthy, "--out", tmp_path / "rules.json")
    gen("thresholds", NETWORK, *healthy, "--rules", tmp_path / "rules.json", "--out", tmp_path / "t.json")
    assert [rule.name for rule in load(tmp_path / "t.json").document.alarms] == ["casing_hot", "casing_limit"]
    assert np.isfinite(emulated(tmp_path / "t.json", tmp_path).temps["casing"]).all()


def test_ten_hours_of_logs_give_a_rule_that_hears_heat_in_minutes(tmp_path: Path) -> None:
    """And its thresholds; shorter ones are told what they lack."""
    runs = [log(tmp_path / f"cold{pwm}.csv", pwm, pwm) for pwm in (100, 180)]
    healthy = [log(tmp_path / f"healthy{seed}.csv", 140, seed) for seed in range(8)]
    gen("identify", *runs, "--model", "parts", "--out", tmp_path / "identified.json", "--name", "small")
    said = gen("init", *healthy[:7], "--out", tmp_path / "short.json")
    assert "no rule on missing heat, which hears a fault in minutes" in said
    assert "these runs last 9.7 h" in said
    said = gen("init", *healthy, "--out", tmp_path / "rules.json")
    assert "no rule on missing heat" not in said
    made = tmp_path / "t.json"
    gen("thresholds", tmp_path / "identified.json", *healthy, "--rules", tmp_path / "rules.json", "--out", made)
    rules = {rule.name: rule for rule in load(made).document.alarms}
    assert list(rules) == ["motor_heat", "casing_hot", "casing_limit"]
    assert "one false alarm in 1000 h" in rules["motor_heat"].note
    assert np.all(emulated(made, tmp_path).extras["alarms"] == 0)


def without(path: Path, target: Path, *keys: str) -> Path:
    tree = {key: value for key, value in json.loads(path.read_text()).items() if key not in keys}
    target.write_text(json.dumps(tree))
    return target


@pytest.mark.parametrize("name", ALL)
def test_a_start_fits_every_model(name: str, tmp_path: Path) -> None:
    source = ROOT / "examples" / name / "coeffs.json"
    bare = without(source, tmp_path / "bare.json", "wiring", "alarms")
    gen("init", bare, "--out", tmp_path / "motor.json")
    before, after = load(bare), load(tmp_path / "motor.json")
    assert before.document == after.document.model_copy(update={"wiring": None, "alarms": ()})
    chips = [chip.channel for chip in wiring(tmp_path / "motor.json").thermocouples]
    names = before.model.component_names
    assert chips[: len(names)] == list(names)
    assert ("ambient" in chips) == (before.model.ambient_channel is not None or "ambient" in str(before.effects))
    limits = {rule.component: rule for rule in after.document.alarms if rule.kind == "over_temperature"}
    assert set(limits) == set(names)
    assert all(rule.persistence_s <= 1.0 for rule in limits.values())  # a part warms 8 K/s
    reads = {channel.column for channel in before.model.network.channels} if before.model.network else set()
    for applied in before.effects:
        reads |= set(applied.columns(names))
    found = {channel.column for channel in wiring(tmp_path / "motor.json").channels} | set(chips)
    assert reads - {"pwm"} <= found


def objects(value: object) -> list[dict[str, Any]]:
    """The objects of a tree that hold a pin or are a rule."""
    if isinstance(value, list):
        return [item for part in value for item in objects(part)]
    if not isinstance(value, dict):
        return []
    own = [value] if "kind" in value or any(re.search(r"(^|_)(pin|cs)$", key) for key in value) else []
    return own + [item for part in value.values() for item in objects(part)]


def test_every_pin_and_every_rule_says_why(tmp_path: Path) -> None:
    runs = [log(tmp_path / f"run{pwm}.csv", pwm, 0) for pwm in (60, 180)]
    rig = without(ROOT / "examples" / "my1016_rig" / "coeffs.json", tmp_path / "rig.json", "wiring", "alarms")
    for given in ([*runs], [rig]):
        gen("init", *given, "--out", tmp_path / "start.json")
        tree = json.loads((tmp_path / "start.json").read_text())
        found = objects({"wiring": tree["wiring"], "alarms": tree["alarms"]})
        assert len(found) > 5
        assert all(item.get("note") or item.get("description") for item in found)


def test_the_logs_say_at_which_speeds_the_rules_hold(tmp_path: Path) -> None:
    runs = [log(tmp_path / f"run{pwm}.csv", pwm, 0) for pwm in (60, 180)]
    gen("init", *runs, "--out", tmp_path / "rules.json")
    rules = {rule["name"]: rule for rule in json.loads((tmp_path / "rules.json").read_text())["alarms"]}
    low, high = rules["casing_hot"]["speed_percent"]
    assert 59 < low * 2.55 <= 60
    assert high == 100
    assert "threshold_K" not in rules["casing_hot"]
    assert "limit_degC" not in rules["casing_limit"]


def test_with_a_model_other_temperatures_of_the_logs_are_columns(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    head = "time_s,pwm,casing_degC,gear box_degC,shaft_degC,empty_degC,casing_model_degC\n"
    path.write_text(head + "0,9,20,21,22,,20\n5,9,20,21,22,,20\n")
    said = gen("init", NETWORK, path, "--out", tmp_path / "rules.json")
    chips = json.loads((tmp_path / "rules.json").read_text())["wiring"]["thermocouples"]
    assert [chip["channel"] for chip in chips] == ["casing", "ambient", "shaft_degC"]
    assert "gear box_degC: left out" in said


def test_sixteen_parts_have_a_limit_each(tmp_path: Path) -> None:
    tree = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    tree = {key: value for key, value in tree.items() if key not in ("wiring", "alarms", "provenance", "effects")}
    long = "a_very_long_name_of_part"
    tree["components"] = [
        {
            "name": f"{long[:22]}{chr(97 + i)}{chr(97 + i)}",
            "order": 1,
            "gain": {"poly": [RISE_K / TAU_S]},
            "poles": [{"real": {"poly": [-1.0 / TAU_S]}}],
        }
        for i in range(16)
    ]
    (tmp_path / "many.json").write_text(json.dumps(tree))
    gen("init", tmp_path / "many.json", "--out", tmp_path / "motor.json")
    document = load(tmp_path / "motor.json").document
    assert sorted(rule.component for rule in document.alarms) == sorted(document.component_names)


def test_what_is_there_already_is_kept(tmp_path: Path) -> None:
    full = ROOT / "examples" / "my1016_rig" / "coeffs.json"
    wired = without(full, tmp_path / "wired.json", "alarms")
    assert "wiring: kept as it is" in gen("init", wired, "--out", tmp_path / "motor.json")
    assert wiring(tmp_path / "motor.json") == wiring(full)
    done = invoke_refused("init", full, "--out", tmp_path / "again.json")
    assert "has wiring and alarm rules already" in done
    assert not (tmp_path / "again.json").exists()


def invoke_refused(*arguments: str | Path) -> str:
    with pytest.raises(InputError) as caught:
        CliRunner().invoke(cli, [str(argument) for argument in arguments], catch_exceptions=False)
    return str(caught.value)


RUN = "time_s,pwm,casing_degC\n0,9,20\n5,9,21\n"


@pytest.mark.parametrize(
    ("files", "message"),
    [
        ({"run.csv": RUN.replace("casing", "winding 1")}, 'run.csv: column winding 1_degC: "winding 1" is not a C'),
        ({"run.csv": RUN.replace("casing_degC", "power_W")}, "run.csv: header: no column with a temperature"),
        ({"run.csv": RUN.replace("9,21", "fast,21")}, "run.csv: line 3, column pwm"),
        ({"a.json": NETWORK.read_text(), "b.json": NETWORK.read_text()}, "b.json: is a second coefficient file"),
        ({"a.json": "{"}, "a.json: line 1, column 2: not valid JSON"),
        ({}, "missing.csv: there is no such file; expected a run file"),
    ],
)
def test_what_cannot_be_started_is_told_and_nothing_written(
    files: dict[str, str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in files.items():
        Path(name).write_text(text)
    assert invoke_refused("init", *(files or ["missing.csv"]), "--out", "start.json").startswith(message)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(files)
