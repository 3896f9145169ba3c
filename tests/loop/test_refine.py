"""`gen refine` on run files whose truth is known."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import load, parse
from gen.errors import InputError
from gen.loop.refine import Refinement, refine
from gen.loop.residual import condense
from gen.model.exact import ExactSolution
from gen.runs import Run, read_run, write_run
from tests.loop.plant import COEFFICIENTS
from tests.loop.plant_effects import LIBRARY, OUTSIDE, make

FULL = os.environ.get("GEN_CAMPAIGN") == "full"
CAMPAIGN = (
    [((name,), seed) for name in (*LIBRARY, *OUTSIDE) for seed in range(2)] + [((), seed) for seed in range(5)]
    if FULL
    else [(("hidden_node",), 11), ((), 11), (("thermostat",), 11)]
)


def _refined(folder: Path, kinds: tuple[str, ...], seed: int) -> tuple[Refinement, float]:
    fit, test, floor = make(folder, kinds, seed)
    return refine(load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8"), fit, test), floor


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("kinds", "seed"),
    CAMPAIGN,
    ids=lambda value: "+".join(value) if value == () or isinstance(value, tuple) else str(value),
)
def test_planted_effect_is_named_and_no_other(tmp_path: Path, kinds: tuple[str, ...], seed: int) -> None:
    found, floor = _refined(tmp_path, kinds, seed)
    before, after = (errors.summary()["test"]["rmse_K"] for errors in (found.before, found.after))
    names = [effect["name"] for effect in found.effects]
    assert after <= 1.05 * before
    if not kinds:
        assert found.verdict == "nothing missing"
        assert names == []
        assert after <= 1.2 * floor
    elif kinds[0] in OUTSIDE:
        assert found.verdict in ("unexplained", "partly explained") or after <= 1.5 * floor
        assert found.verdict == "explained" or not any(effect["evidence"]["confident"] for effect in found.effects)
    else:
        assert names[0] == kinds[0]
        assert after <= max(1.2 * floor, 0.3 * before)


def test_test_runs_take_no_part(tmp_path: Path) -> None:
    """Spoiling the test runs changes their errors, and nothing else."""
    fit, test, _ = make(tmp_path, ("direction",), 4)
    baseline, raw = load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8")
    honest = refine(baseline, raw, fit, test)
    for path in test:
        run = read_run(path, baseline.model.component_names)
        write_run(path, replace(run, temps={name: values * 1.5 for name, values in run.temps.items()}))
    spoilt = refine(baseline, raw, fit, test)
    assert honest.text == spoilt.text
    assert honest.verdict == spoilt.verdict
    assert honest.after.summary()["fit"] == spoilt.after.summary()["fit"]
    assert honest.after.summary()["test"] != spoilt.after.summary()["test"]


def test_residual_of_irregular_rows_with_gaps_is_what_the_sensor_adds(tmp_path: Path) -> None:
    baseline = load(COEFFICIENTS)
    random = np.random.default_rng(1)
    time = np.cumsum(random.uniform(0.3, 3.0, 5000))
    time[2500:] += 1800.0
    pwm = np.where(time < 4000, 153, 0).astype(np.int64)
    rises = ExactSolution(baseline.model).simulate_times(time, pwm, dict.fromkeys(baseline.model.component_names, 5.0))
    temps = {name: rise + 30.0 + np.where(time > 3000, 2.0, 0.0) for name, rise in rises.items()}
    for values in temps.values():
        values[random.random(time.size) < 0.3] = np.nan
        values[:3] = 35.0
    path = tmp_path / "run.csv"
    write_run(path, Run(time, pwm, temps))
    condensed = condense(baseline, path)
    middle = 0.5 * (condensed.edges[1:] + condensed.edges[:-1])
    late = middle > 3100
    for trace in condensed.traces.values():
        good = np.isfinite(trace.residual)
        np.testing.assert_allclose(trace.residual[good & late], 2.0, atol=0.02)
        np.testing.assert_allclose(trace.residual[good & (middle < 2900)], 0.0, atol=0.02)


def test_a_declared_fault_is_not_learnt(tmp_path: Path) -> None:
    fit, test, _ = make(tmp_path, (), 3)
    for path in fit[:2]:
        run = read_run(path, load(COEFFICIENTS).model.component_names)
        hot = {name: values + 8.0 * (1.0 - np.exp(-run.time_s / 2000.0)) for name, values in run.temps.items()}
        write_run(path, replace(run, temps=hot, comments={"fault": "bearing"}))
    baseline, raw = load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8")
    found = refine(baseline, raw, fit, test)
    assert found.verdict == "nothing missing"
    assert [str(path) in " ".join(found.warnings) for path in fit] == [True, True] + [False] * 4
    assert set(found.before.fit) == {str(path) for path in fit[2:]}
    with pytest.raises(InputError, match="no run is left"):
        refine(baseline, raw, fit[:2], test)


def test_a_fault_that_nobody_declared_is_pointed_at(tmp_path: Path) -> None:
    """The casing gets 8 K too warm in one run of six, as with the study's degreased bearing."""
    fit, test, _ = make(tmp_path, (), 3)
    baseline, raw = load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8")
    run = read_run(fit[1], baseline.model.component_names)
    warm = run.temps["casing"] + 9.0 * (1.0 - np.exp(-run.time_s / 1000.0))
    write_run(fit[1], replace(run, temps={**run.temps, "casing": warm}))
    found = refine(baseline, raw, fit, test)
    assert any("in these runs only" in warning and str(fit[1]) in warning for warning in found.warnings)
    assert not found.effects or not any(effect["evidence"]["confident"] for effect in found.effects)


def _gen(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "gen", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_command_writes_all_that_users_rely_on(tmp_path: Path) -> None:
    fit, test, _ = make(tmp_path, ("sensor_gain",), 5)
    names = ["--fit", *(path.name for path in fit), "--test", *(path.name for path in test)]
    out = ["--out", "refined.json", "--json", "summary.json", "--report", "report.html"]
    done = _gen(tmp_path, "refine", str(COEFFICIENTS), *names, *out)
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    for when in ("before", "after"):
        assert {"fit", "test", "per_run"} <= set(summary[when])
        assert set(summary[when]["per_run"]) == {path.name for path in (*fit, *test)}
        for run in summary[when]["per_run"].values():
            for errors in run.values():
                assert 0.0 <= errors["rmse_K"] <= errors["max_abs_K"]
    assert summary["verdict"] == "explained"
    assert summary["effects"][0]["name"] == "sensor_gain"
    assert set(summary["effects"][0]) == {"name", "component", "parameters", "evidence"}
    refined = parse((tmp_path / "refined.json").read_bytes())
    assert [e.name for e in refined.document.effects] == [e["name"] for e in summary["effects"]]
    _check_by_simulation(tmp_path, test[0].name, summary)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "sensor_gain" in page
    assert page.count("<svg") >= 12
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert "https://" not in page


def _check_by_simulation(folder: Path, run: str, summary: dict[str, Any]) -> None:
    """`gen simulate` with the refined file gives the error that the summary states, but for the noise of the start."""
    assert _gen(folder, "simulate", "refined.json", run, "--out", "model.csv").returncode == 0
    measured = read_run(folder / run, load(COEFFICIENTS).model.component_names)
    model = np.genfromtxt(folder / "model.csv", delimiter=",", names=True, skip_header=2)
    for name, errors in summary["after"]["per_run"][run].items():
        rmse = float(np.sqrt(np.mean((measured.temps[name] - model[f"{name}_degC"]) ** 2)))
        assert rmse == pytest.approx(errors["rmse_K"], abs=0.25)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--fit", "a.csv", "--test", "b.csv", "--out", "x.json"], "a.csv"),
        (["--fit", "--test", "b.csv", "--out", "x.json"], "--fit"),
        (["--test", "b.csv", "--out", "x.json"], "--fit"),
        (["--fit", "run.csv", "--test", "run.csv", "--out", "x.json"], "must take no part"),
    ],
)
def test_bad_usage_is_one_message_and_status_2(tmp_path: Path, arguments: list[str], message: str) -> None:
    (tmp_path / "run.csv").write_text("time_s,pwm,casing_degC\n0,0,30\n1,0,30\n", encoding="utf-8")
    done = _gen(tmp_path, "refine", str(COEFFICIENTS), *arguments)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "x.json").exists()


def test_the_tracer_never_sees_the_truth() -> None:
    folder = Path(__file__).parents[2] / "gen" / "loop"
    for path in folder.rglob("*.py"):
        assert "gen.rig" not in path.read_text(encoding="utf-8"), path
