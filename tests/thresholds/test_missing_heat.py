"""Rules on missing heat from healthy runs: other healthy runs stay silent, added heat is heard as soon as is said."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from gen.cli import cli
from gen.coefficients import Coefficients, load
from gen.coefficients.alarms import MissingHeat
from gen.errors import InputError
from gen.reference.run_alarms import raised_s
from gen.reference.simulate import simulate_run
from gen.replay import read_for
from tests.thresholds.test_thresholds import BASE, TAU_S

RULE: dict[str, Any] = {"name": "heat", "kind": "missing_heat", "component": "a", "speed_percent": [5, 98]}
HOURS = 3.0
_STEP = float(-np.expm1(-1.0 / TAU_S))
LAG_S, SHARE = 150.0, 0.04
"""A part of the motor that the model has not: it comes later, and is a share of the rise."""


def write_run(path: Path, seed: int, added_K_s: float = 0.0, begins_s: float = 5400.0) -> Path:
    """Two speeds after one another, with noise, counts of 0.25 K, a slow wander, and a hidden part of its own."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(0.0, HOURS * 3600.0, 1.0)
    levels = rng.integers(60, 250, 2)
    pwm = np.where(time_s < 0.4 * time_s[-1], levels[0], levels[1])
    rises, hidden = np.zeros((2, time_s.size)), np.zeros(time_s.size)
    rise, late = 0.0, 0.0
    for k in range(1, time_s.size):
        added = added_K_s if time_s[k - 1] >= begins_s else 0.0
        rise += _STEP * (0.2 * pwm[k - 1] + TAU_S * added - rise)
        late += (0.2 * SHARE * pwm[k - 1] - late) / LAG_S
        rises[:, k], hidden[k] = rise, late
    wander = 0.15 * np.sin(2.0 * np.pi * (time_s / 7200.0 + rng.uniform()))
    shown = 20.0 + rises + hidden - 0.2 * SHARE * pwm + wander + rng.normal(0.0, 0.1, (2, time_s.size))
    shown[:, 0] = 20.0
    counted = np.floor(shown / 0.25) * 0.25
    rows = [f"{t:g},{p},{x:g},{y:g},20.0" for t, p, x, y in zip(time_s, pwm, *counted, strict=True)]
    path.write_text("\n".join(["time_s,pwm,a_degC,b_degC,ambient_degC", *rows]) + "\n")
    return path


def derive(folder: Path, runs: list[Path], *more: str, rule: dict[str, Any] | None = None) -> Result:
    (folder / "base.json").write_text(json.dumps(BASE))
    (folder / "rules.json").write_text(json.dumps({"alarms": [rule or RULE]}))
    files = [str(folder / "base.json"), *map(str, runs), "--rules", str(folder / "rules.json")]
    return CliRunner().invoke(cli, ["thresholds", *files, "--out", str(folder / "made.json"), *more])


def heard_s(coefficients: Coefficients, path: Path) -> float | None:
    run = read_for(coefficients, path)
    shown = simulate_run(coefficients, run, "exact", "auto", path.name)
    model = {name: shown[f"{name}_degC"].astype(np.float64) for name in coefficients.model.component_names}
    return raised_s(coefficients, run, model).get("heat")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Coefficients:
    folder = tmp_path_factory.mktemp("healthy")
    done = derive(folder, [write_run(folder / f"healthy_{seed}.csv", seed) for seed in range(16)])
    assert done.exit_code == 0, done.output
    return load(folder / "made.json")


def test_other_healthy_runs_stay_silent_and_heat_is_heard_as_the_note_says(made: Coefficients, tmp_path: Path) -> None:
    rule = made.document.alarms[0]
    assert isinstance(rule, MissingHeat)
    for seed in range(100, 108):
        assert heard_s(made, write_run(tmp_path / "run.csv", seed)) is None
    said = re.search(r"Heat of ([0-9.]+) K/h is heard within 5 min", rule.note)
    assert said is not None
    least_K_s = float(said[1]) / 3600.0
    delays = []
    for seed in range(200, 205):
        at = heard_s(made, write_run(tmp_path / "run.csv", seed, added_K_s=1.3 * least_K_s, begins_s=9000.0))
        assert at is not None
        assert at > 9000.0
        delays.append(at - 9000.0)
    assert np.median(delays) <= 330.0


def test_a_rarer_false_alarm_has_a_higher_threshold(made: Coefficients, tmp_path: Path) -> None:
    runs = [write_run(tmp_path / f"healthy_{seed}.csv", seed) for seed in range(4)]
    written = made.document.alarms[0]
    assert isinstance(written, MissingHeat)
    kept = {"slack_K_per_h": written.slack_K_per_h, "unsettled": written.unsettled.model_dump(mode="json")}
    found = []
    for hours in ("10", "100000"):
        assert derive(tmp_path, runs, "--hours-per-false-alarm", hours, rule=RULE | kept).exit_code == 0
        rule = load(tmp_path / "made.json").document.alarms[0]
        assert isinstance(rule, MissingHeat)
        assert rule.unsettled == written.unsettled
        found.append(rule.threshold_K)
    assert found[0] < found[1]


@pytest.mark.parametrize(
    ("rule", "runs", "message"),
    [
        (RULE, 2, "last 6.0 h together"),
        (RULE | {"weights": {"a": "much"}}, 4, "weights.a"),
        (RULE | {"weights": {"nobody": 1.0}}, 4, "nobody"),
    ],
)
def test_what_is_wrong_is_one_line_and_nothing_is_written(
    rule: dict[str, Any], runs: int, message: str, tmp_path: Path
) -> None:
    done = derive(tmp_path, [write_run(tmp_path / f"run{seed}.csv", seed) for seed in range(runs)], rule=rule)
    assert isinstance(done.exception, InputError)
    assert message in done.exception.message
    assert str(done.exception.place).startswith("$.alarms[0]")
    assert not (tmp_path / "made.json").exists()
