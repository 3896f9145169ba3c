"""`gen refine` on run files whose truth is known."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import load, parse
from gen.errors import InputError
from gen.model.exact import ExactSolution
from gen.refinement.admission import admitted
from gen.refinement.condense import check_apart, check_measured, condense, free_run
from gen.refinement.parts.page import page
from gen.refinement.parts.refine import Refinement, refine
from gen.runs import Run, read_run, write_run
from tests.campaign import FULL
from tests.command import gen
from tests.refinement.plant import COEFFICIENTS, NAMES
from tests.refinement.plant_effects import LIBRARY, OUTSIDE, make

FAN = {"name": "airflow", "component": "casing", "parameters": {"channel": "fan", "cooling_per_s": 0.001}}
CAMPAIGN = (
    [((name,), seed) for name in (*LIBRARY, *OUTSIDE) for seed in range(2)] + [((), seed) for seed in range(5)]
    if FULL
    else [(("hidden_node",), 11), ((), 11), (("thermostat",), 11)]
)


WIDE = [((name,), seed) for name in LIBRARY for seed in range(2)] if FULL else [(("supply_voltage",), 12)]


def _refined(folder: Path, kinds: tuple[str, ...], seed: int, wide: bool = False) -> tuple[Refinement, float]:
    fit, test, floor = make(folder, kinds, seed, wide=wide)
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


@pytest.mark.campaign
@pytest.mark.parametrize(("kinds", "seed"), WIDE, ids=lambda value: str(value))
def test_a_form_that_the_library_does_not_have_does_no_harm(tmp_path: Path, kinds: tuple[str, ...], seed: int) -> None:
    """Whether the name is right then is for the campaign to count; an error may not grow, nor a claim be empty."""
    found, floor = _refined(tmp_path, kinds, seed, wide=True)
    before, after = (errors.summary()["test"]["rmse_K"] for errors in (found.before, found.after))
    assert after <= 1.05 * before
    assert found.verdict != "explained" or after <= 1.5 * floor
    assert found.verdict != "nothing missing" or before <= 2.0 * floor


def test_an_effect_that_one_run_alone_excites_is_asked_for_and_not_named(tmp_path: Path) -> None:
    """Heat in reverse; of six runs to fit, one reverses. Something else about that run could as well be the cause."""
    fit, test, _ = make(tmp_path, (), 6)
    baseline, raw = load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8")
    for path in (*fit, *test):
        run = read_run(path, baseline.model.component_names)
        pwm = np.abs(run.pwm)
        temps = dict(run.temps)
        if path == fit[3]:
            pwm[500:] = -pwm[500:]
            added = np.zeros(run.time_s.size)
            for k, h in enumerate(np.diff(run.time_s)):
                added[k + 1] = added[k] + h * ((0.006 if pwm[k] < 0 else 0.0) - added[k] / 1500.0)
            temps["casing"] = temps["casing"] + added
        write_run(path, replace(run, pwm=pwm, temps=temps))
    found = refine(baseline, raw, fit, test)
    assert found.verdict == "unexplained"
    assert found.effects == []
    assert "casing: direction would fit, but one run alone excites it: run that again" in page(found, baseline)


def test_a_reading_that_jumps_with_pwm_is_no_hidden_part(tmp_path: Path) -> None:
    """Interference adds 3 K at full PWM at once: a hidden node with time constants at their limits would fit it."""
    fit, test, _ = make(tmp_path, (), 8)
    baseline, raw = load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8")
    for path in (*fit, *test):
        run = read_run(path, baseline.model.component_names)
        jump = 3.0 * np.abs(np.concatenate([[0], run.pwm[:-1]])) / 255.0
        write_run(path, replace(run, temps={**run.temps, "magnet": run.temps["magnet"] + jump}))
    found = refine(baseline, raw, fit, test)
    assert "hidden_node" not in [effect["name"] for effect in found.effects]
    assert not any(effect["evidence"]["confident"] for effect in found.effects)


def test_an_effect_has_to_hold_without_an_offset_at_its_limit(tmp_path: Path) -> None:
    """A sensor sits otherwise in every run: with an offset of 1.1 K beside it, direction fits what reverses."""
    found, _ = _refined(tmp_path, ("per_run",), 72007)
    before, after = (errors.summary()["test"]["rmse_K"] for errors in (found.before, found.after))
    assert after <= 1.05 * before
    assert not any(effect["evidence"]["confident"] for effect in found.effects)


def test_a_boards_own_columns_are_no_cause(tmp_path: Path) -> None:
    """A log of the firmware holds its model's temperatures: a residual goes with them, but they heat nothing."""
    fit, _, _ = make(tmp_path, (), 9)
    baseline = load(COEFFICIENTS)
    run = read_run(fit[0], baseline.model.component_names)
    extra = {f"{name}_model_degC": values for name, values in run.temps.items()} | {"flags": 0.0 * run.time_s}
    write_run(fit[0], replace(run, extras={**run.extras, **extra}))
    assert set(condense(baseline, fit[0]).channels) == set(run.extras)


def test_a_thinned_log_gives_the_same_residual(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fit, _, _ = make(tmp_path, ("sensor_gain",), 2)
    baseline = load(COEFFICIENTS)
    whole = condense(baseline, fit[0])
    monkeypatch.setattr("gen.refinement.condense.MOST_ROWS", 700)
    thin = condense(baseline, fit[0])
    for name, trace in whole.traces.items():
        middle = 0.5 * (whole.edges[1:] + whole.edges[:-1])
        own = 0.5 * (thin.edges[1:] + thin.edges[:-1])
        good = np.isfinite(thin.traces[name].residual)
        again = np.interp(middle, own[good], thin.traces[name].residual[good])
        assert float(np.sqrt(np.mean((again - trace.residual) ** 2))) < trace.noise_K
        # Both start from the mean of the first minute's samples, of which the thinned log has fewer.
        np.testing.assert_allclose(
            np.interp(whole.edges, thin.edges, thin.traces[name].base), trace.base, atol=trace.noise_K
        )


def test_every_thinned_run_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fit, test, _ = make(tmp_path, (), 11)
    monkeypatch.setattr("gen.refinement.condense.MOST_ROWS", 700)
    found = refine(load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8"), fit, test)
    told = [warning.split(":")[0] for warning in found.warnings if "errors are of these" in warning]
    assert told == [str(path) for path in (*fit, *test)]


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


def test_a_run_that_is_fitted_and_tested_is_named_as_it_was_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    fit = [Path("a.csv"), tmp_path / "b.csv"]
    check_apart(fit, [Path("c.csv")])
    with pytest.raises(InputError, match="must take no part") as refused:
        check_apart(fit, [Path("c.csv"), Path("b.csv"), Path("a.csv")])
    assert refused.value.file == "b.csv"


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        ("time_s,pwm,casing_degC", "{},10,hot", "line 2, column casing_degC"),
        ("time_s,pwm,casing_degC", "5,10,30", "line 3, column time_s"),
        ("time_s,pwm,elsewhere_degC", "{},10,30", "no component's temperature was measured"),
        ("time_s,pwm,casing_degC", "{},10,", "no component's temperature was measured"),
    ],
)
def test_a_test_run_that_cannot_be_judged_is_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, header: str, row: str, message: str
) -> None:
    fit, test, _ = make(tmp_path, (), 3)
    test[-1].write_text("\n".join([header, *(row.format(i) for i in range(20))]) + "\n")

    def work(*_: object) -> None:
        raise AssertionError("work began")

    for step in ("condense", "trace"):
        monkeypatch.setattr(sys.modules[refine.__module__], step, work)
    with pytest.raises(InputError, match=message) as refused:
        refine(load(COEFFICIENTS), COEFFICIENTS.read_text(encoding="utf-8"), fit, test)
    assert refused.value.file == str(test[-1])


@pytest.mark.parametrize(
    ("rows", "change", "message"),
    [
        (7, {}, "found 7 rows, expected at least 8"),
        (8, {"ambient": {"channel": "room_degC"}}, "the column room_degC is missing"),
        (8, {"effects": [FAN]}, 'the effect "airflow" of casing needs the column fan'),
        (8, {}, ""),
    ],
)
def test_what_judging_a_run_needs_is_checked_without_its_values(
    tmp_path: Path, rows: int, change: dict[str, object], message: str
) -> None:
    baseline = parse(json.dumps(json.loads(COEFFICIENTS.read_text(encoding="utf-8")) | change).encode())
    path = tmp_path / "run.csv"
    path.write_text("time_s,pwm,casing_degC\n" + "".join(f"{i},10,30\n" for i in range(rows)))
    if not message:
        check_measured(baseline, path)
        return
    for check in (check_measured, partial(free_run, baseline)):  # as judging it would say
        with pytest.raises(InputError, match=message):
            check(baseline, path)


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


def _warnings(tmp_path: Path, rule: dict[str, object], warm_K: dict[str, float]) -> list[str]:
    """What admission says of three runs of which the first is off by these; the file's band ends 3 K over the model."""
    fit, _, _ = make(tmp_path, (), 3)
    tree = json.loads(COEFFICIENTS.read_text(encoding="utf-8"))
    base = {"name": "hot", "kind": "above_model", "component": "casing"}
    tree["alarms"] = [base | rule]
    tree["provenance"]["error"] = [{"component": "casing", "pwm": [0, 255], "model_minus_measured_K": [-3.0, 3.0]}]
    run = read_run(fit[0], NAMES)
    rises = 1.0 - np.exp(-run.time_s / 600.0)
    write_run(fit[0], replace(run, temps={n: t + warm_K.get(n, 0.0) * rises for n, t in run.temps.items()}))
    baseline = parse(json.dumps(tree).encode())
    return admitted(baseline, [condense(baseline, path) for path in fit[:3]])[1]


def test_rules_from_gen_thresholds_point_at_a_fault_too(tmp_path: Path) -> None:
    """They count from the error band's end, so their own thresholds are small."""
    rule = {"threshold_K": 0.8, "beyond": "error_band"}
    (warning,) = _warnings(tmp_path, rule, {"casing": 6.0})
    assert "in these runs only" in warning
    assert "beyond the healthy range" in warning


def test_what_lies_within_the_error_band_points_at_nothing(tmp_path: Path) -> None:
    assert not _warnings(tmp_path, {"threshold_K": 0.8, "beyond": "error_band"}, {"casing": 2.0})


@pytest.mark.parametrize(("warm_K", "said"), [({"casing": 9.0, "bearing": 9.0}, 0), ({"casing": 9.0}, 1)])
def test_a_relative_rule_looks_at_the_difference(tmp_path: Path, warm_K: dict[str, float], said: int) -> None:
    assert len(_warnings(tmp_path, {"threshold_K": 4.0, "relative_to": "bearing"}, warm_K)) == said


def test_command_writes_all_that_users_rely_on(tmp_path: Path) -> None:
    fit, test, _ = make(tmp_path, ("sensor_gain",), 5)
    names = ["--fit", *(path.name for path in fit), "--test", *(path.name for path in test)]
    out = ["--out", "refined.json", "--json", "summary.json", "--report", "report.html"]
    done = gen("refine", COEFFICIENTS, *names, *out, cwd=tmp_path)
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
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    first = ["Measured and modelled", "What was measured", "The residual"]
    story = [*first, "What was considered", "What was added", "Error before and after"]
    places = [text.index(f"<h2>{title}</h2>") for title in (*story, "What remains", "What to measure next")]
    assert places == sorted(places)
    assert "sensor_gain" in text
    assert text.count("<svg") >= 12
    assert "http://" not in text.replace("http://www.w3.org", "")
    assert "https://" not in text


def _check_by_simulation(folder: Path, run: str, summary: dict[str, Any]) -> None:
    """`gen simulate` with the refined file gives the error that the summary states, but for the noise of the start."""
    assert gen("simulate", "refined.json", run, "--out", "model.csv", cwd=folder).returncode == 0
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
    done = gen("refine", COEFFICIENTS, *arguments, cwd=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "x.json").exists()


def test_the_tracer_never_sees_the_truth() -> None:
    folder = Path(__file__).parents[2] / "gen" / "refinement"
    for path in folder.rglob("*.py"):
        assert "gen.rig" not in path.read_text(encoding="utf-8"), path
