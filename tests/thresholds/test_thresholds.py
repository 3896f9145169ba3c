"""Error bands and thresholds against runs whose deviation from the model is known."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from gen.cli import cli
from gen.coefficients import load
from gen.errors import InputError
from gen.lowering.alarms import lower_alarms, start_wait
from gen.model.exact import ExactSolution
from gen.runs import Run
from gen.thresholds.healthy import compare
from tests.examples import example

TAU_S, RISE_K = 1000.0, 0.2  # rise per count

BASE: dict[str, Any] = {
    "format": "gen-coefficients",
    "version": 1,
    "name": "plain",
    "sample_time_s": 0.25,
    "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 2650},
    "ambient": {"channel": "ambient_degC"},
    "validity": {"pwm": [50, 250], "outside": "extrapolate"},
    "domain": {"pwm": [0, 255], "ambient_degC": [-10.0, 40.0], "temperature_degC": [-10.0, 150.0]},
    "components": [
        {"name": name, "order": 1, "gain": {"poly": [RISE_K / TAU_S]}, "poles": [{"real": {"poly": [-1.0 / TAU_S]}}]}
        for name in ("a", "b")
    ],
    "provenance": {
        "source": "made up",
        "error": [
            {"component": name, "pwm": span, "model_minus_measured_K": [-0.1, 0.1]}
            for name in ("a", "b")
            for span in ([50, 120], [121, 160], [161, 250])
        ],
    },
}


def write_run(path: Path, pwm: int, off_K: dict[str, float], duration_s: float = 4000.0) -> Path:
    """A step from cold; from 1000 s on each part is off by a known constant, before that by ten times as much."""
    time_s = np.arange(0.0, duration_s, 2.0)
    rise = RISE_K * pwm * -np.expm1(-time_s / TAU_S)
    lines = ["time_s,pwm,a_degC,b_degC,ambient_degC"]
    for t, value in zip(time_s, rise, strict=True):
        shown = [20.0 + value + (0.0 if t == 0.0 else off * (1.0 if t >= 600.0 else 10.0)) for off in off_K.values()]
        lines.append(f"{t:g},{pwm},{shown[0]:.6f},{shown[1]:.6f},20.0")
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def healthy(tmp_path: Path) -> list[str]:
    runs = [(80, 1.0, 0.2), (80, -1.0, 0.2), (200, 2.0, 0.5), (200, 2.0, -0.5)]
    return [str(write_run(tmp_path / f"run{i}.csv", pwm, {"a": a, "b": b})) for i, (pwm, a, b) in enumerate(runs)]


def derive(tmp_path: Path, healthy: list[str], *rules: dict[str, Any]) -> Any:  # noqa: ANN401
    (tmp_path / "base.json").write_text(json.dumps(BASE))
    (tmp_path / "rules.json").write_text(json.dumps({"alarms": rules}))
    out = tmp_path / "made.json"
    files = [str(tmp_path / "base.json"), *healthy, "--rules", str(tmp_path / "rules.json"), "--out", str(out)]
    done = CliRunner().invoke(cli, ["thresholds", *files])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return load(out)


ABOVE = {"name": "hot", "kind": "above_model", "component": "a", "speed_percent": [20, 98], "settle_s": 600}


def test_bands_are_the_extremes_of_the_settled_runs(tmp_path: Path, healthy: list[str]) -> None:
    bands = derive(tmp_path, healthy, ABOVE).document.provenance.error
    found = {(band.component, band.pwm): band.model_minus_measured_K for band in bands}
    assert found["a", (50, 120)] == pytest.approx((-1.0, 1.0), abs=0.002)
    assert found["a", (161, 250)] == pytest.approx((-2.0, -2.0), abs=0.002)
    assert found["a", (121, 160)] == pytest.approx((-2.0, 1.0), abs=0.002)  # no run there: both neighbours
    assert found["b", (161, 250)] == pytest.approx((-0.5, 0.5), abs=0.002)


@pytest.mark.parametrize("every", [2, 5])
def test_a_sensor_that_is_read_less_often_than_rows_are_written_tells_as_much(
    tmp_path: Path, healthy: list[str], every: int
) -> None:
    """And a reading that is missing now and then voids no minute."""
    for k, name in enumerate(healthy):
        lines = Path(name).read_text().splitlines()
        for i, line in enumerate(lines[2:], start=2):
            time, pwm, _, b, ambient = line.split(",")
            if (i % every if k % 2 else i % 29 == 0) and i > 2:
                lines[i] = f"{time},{pwm},,{b},{ambient}"
        Path(name).write_text("\n".join(lines) + "\n")
    bands = derive(tmp_path, healthy, ABOVE).document.provenance.error
    found = {(band.component, band.pwm): band.model_minus_measured_K for band in bands}
    assert found["a", (50, 120)] == pytest.approx((-1.0, 1.0), abs=0.01)
    assert found["a", (161, 250)] == pytest.approx((-2.0, -2.0), abs=0.01)


def test_a_threshold_lies_the_runs_scatter_beyond_the_band(tmp_path: Path, healthy: list[str]) -> None:
    made = derive(tmp_path, healthy, ABOVE, ABOVE | {"name": "other", "component": "b"})
    # Of a: +-1 about 0 at PWM 80 (unbiased: sqrt 2 each), nothing at 200; pooled over the four: 1.
    scatter = 1.0
    a, b = lower_alarms(made)
    (at_200,) = [segment.trip_mK for segment in a.segments if segment.low <= 200 <= segment.high]
    assert at_200 == pytest.approx(2000 + 1000 * scatter, abs=12)
    assert a.segments[0].trip_mK == pytest.approx(1000 + 1000 * scatter, abs=12)
    # Of b: 0 at 80, +-0.5 at 200: 0.5, which is no less than the least margin.
    assert b.segments[0].trip_mK == pytest.approx(200 + 500, abs=12)
    assert "standard deviation" in made.document.alarms[0].note


def test_a_run_that_taught_the_model_is_pointed_at(tmp_path: Path, healthy: list[str]) -> None:
    tree = BASE | {"provenance": BASE["provenance"] | {"data": ["somewhere/run1.csv"]}}
    (tmp_path / "base.json").write_text(json.dumps(tree))
    (tmp_path / "rules.json").write_text(json.dumps({"alarms": [ABOVE]}))
    files = [str(tmp_path / "base.json"), *healthy, "--rules", str(tmp_path / "rules.json")]
    done = CliRunner().invoke(cli, ["thresholds", *files, "--out", str(tmp_path / "made.json")])
    assert done.exit_code == 0
    assert [healthy.index(run) for run in healthy if f"warning: {run}" in done.output] == [1]


def test_what_the_author_wrote_stays(tmp_path: Path, healthy: list[str]) -> None:
    rule = ABOVE | {"threshold_K": 7.0, "note": "mine"}
    limit = {"name": "limit", "kind": "over_temperature", "component": "b", "limit_degC": 99.0}
    made = derive(tmp_path, healthy, rule, limit)
    assert made.document.alarms[0].threshold_K == 7.0
    assert made.document.alarms[0].note == "mine"
    assert made.document.alarms[1].limit_degC == 99.0


def test_an_over_temperature_leaves_room_at_the_warmest_ambient(tmp_path: Path, healthy: list[str]) -> None:
    (rule,) = derive(tmp_path, healthy, {"name": "limit", "kind": "over_temperature", "component": "b"}).document.alarms
    hottest = 200 * RISE_K * -np.expm1(-4.0) + 0.5 + 40.0  # declared ambient up to 40 degC
    assert hottest + 10.0 <= rule.limit_degC < hottest + 15.0
    assert rule.hysteresis_K == 5.0  # as docs/alarms.md has it


def test_a_relative_rule_takes_the_difference_of_both_parts(tmp_path: Path, healthy: list[str]) -> None:
    rule = ABOVE | {"relative_to": "b", "kind": "below_model"}
    (made,) = derive(tmp_path, healthy, rule).document.alarms
    # a - b: 0.8, -1.2 | 1.5, 2.5: lowest -1.2; scatter: (1, 1, 0.5, 0.5) by sqrt 2, pooled sqrt 1.25.
    assert made.threshold_K == pytest.approx(1.2 + np.sqrt(1.25), abs=0.012)


@pytest.mark.parametrize(
    ("rules", "place"),
    [
        ([], "$"),
        ({"alarms": [3]}, "$.alarms"),
        ({"alarms": [], "wirings": {}}, "$"),
        ({"alarms": [ABOVE | {"component": "c"}]}, "$.alarms[0].component"),
        ({"alarms": [ABOVE, {"name": "nameless", "kind": "cusum"}]}, "$.alarms[1].component"),
        ({"alarms": [ABOVE | {"relative_to": "c"}]}, "$.alarms[0].relative_to"),
        ({"alarms": [ABOVE | {"relative_to": "a"}]}, "$.alarms[0].relative_to"),
        ({"alarms": [ABOVE | {"relative_to": "b", "beyond": "error_band"}]}, "$.alarms[0].beyond"),
        ({"alarms": [ABOVE | {"unless": "later"}]}, "$.alarms[0].unless"),
        ({"alarms": [ABOVE | {"persistence_s": float("nan")}]}, "$.alarms[0].persistence_s"),
        ("", "line 1, column 1"),
        ("{", "line 1, column 2"),
    ],
)
def test_bad_rules_are_refused_and_nothing_is_written(
    tmp_path: Path,
    healthy: list[str],
    rules: Any,  # noqa: ANN401
    place: str,
) -> None:
    (tmp_path / "base.json").write_text(json.dumps(BASE))
    (tmp_path / "rules.json").write_text(rules if isinstance(rules, str) else json.dumps(rules))
    out = tmp_path / "made.json"
    files = [str(tmp_path / "base.json"), *healthy, "--rules", str(tmp_path / "rules.json"), "--out", str(out)]
    done = CliRunner().invoke(cli, ["thresholds", *files])
    assert isinstance(done.exception, InputError)
    assert done.exception.place == place
    assert done.exception.file == str(tmp_path / "rules.json")
    assert not out.exists()


def test_a_run_of_another_machine_is_named_and_not_the_rules(tmp_path: Path, healthy: list[str]) -> None:
    (tmp_path / "base.json").write_text(json.dumps(BASE))
    (tmp_path / "rules.json").write_text(json.dumps({"alarms": [ABOVE]}))
    other = tmp_path / "other.csv"
    other.write_text(Path(healthy[0]).read_text().replace("a_degC", "winding_degC").replace("b_degC", "casing_degC"))
    files = [str(tmp_path / "base.json"), str(other), "--rules", str(tmp_path / "rules.json")]
    done = CliRunner().invoke(cli, ["thresholds", *files, "--out", str(tmp_path / "made.json")])
    assert isinstance(done.exception, InputError)
    assert done.exception.message.startswith("no component's temperature was measured; expected a_degC")
    assert done.exception.file == str(other)


def test_a_sum_s_threshold_is_the_margin_for_half_an_hour(tmp_path: Path, healthy: list[str]) -> None:
    rule = {"name": "slow", "kind": "cusum", "component": "a", "speed_percent": [20, 98], "settle_s": 600}
    (made,) = derive(tmp_path, healthy, rule).document.alarms
    assert made.slack_K == 0.0
    assert made.beyond == "error_band"
    assert made.threshold_K_s == pytest.approx(1.0 * 1800.0, rel=0.02)  # the runs' scatter is 1 K


@pytest.mark.parametrize("warm_K", [0.0, 30.0])
def test_a_run_from_a_warm_start_says_nothing_until_its_unknown_slopes_are_over(warm_K: float) -> None:
    """Nobody knows which way a warm motor is moving: its model's error then is not the motor's."""
    coefficients = example("two_mass")
    model = coefficients.model
    time = np.arange(0.0, 30_000.0, 10.0)
    pwm = np.full(time.size, 120, dtype=np.int64)
    rises = ExactSolution(model).simulate_times(time, pwm, dict.fromkeys(model.component_names, warm_K))
    run = Run(time, pwm, {name: 25.0 + rise for name, rise in rises.items()}, np.full(time.size, 25.0))
    seen = compare(coefficients, run, "run.csv")
    low, high = model.validity
    for component in model.component_names:
        wait = start_wait(model, component, range(max(low, 1), high + 1)) * model.sample_time if warm_K else 600.0
        assert not warm_K or wait > 1200.0
        deviation = seen.deviation_K[component]
        begins = np.arange(deviation.size) * 60.0
        assert np.isnan(deviation[begins < wait]).all()
        assert np.abs(deviation[begins >= wait + 60.0]).max() < 0.01
