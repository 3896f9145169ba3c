"""`gen simulate` as a user meets it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.cli.commands import COEFFICIENTS, run_file
from tests.command import gen


def test_a_run_goes_through_a_pipe(tmp_path: Path) -> None:
    done = gen("simulate", COEFFICIENTS, run_file(tmp_path), "--out", "/dev/stdout")
    assert done.returncode == 0, done.stderr
    assert "\ntime_s,brush_degC," in done.stdout


def test_simulate_writes_the_run_s_own_times_and_fixed_agrees_with_exact(tmp_path: Path) -> None:
    import pandas as pd

    run = run_file(tmp_path)
    tables = {}
    for arithmetic in ("exact", "fixed"):
        out = tmp_path / f"{arithmetic}.csv"
        done = gen("simulate", COEFFICIENTS, run, "--arithmetic", arithmetic, "--out", out)
        assert done.returncode == 0, done.stderr
        tables[arithmetic] = pd.read_csv(out, comment="#")
    exact, fixed = tables["exact"], tables["fixed"]
    assert exact.columns.tolist() == ["time_s", "brush_degC", "bearing_degC", "magnet_degC", "casing_degC"]
    assert exact["time_s"].tolist() == [0, 0.25, 7.3, 900, 1200.1]
    assert exact["brush_degC"][0] == 40.0
    assert exact["casing_degC"][0] == 30.0
    # Off the grid the board gives its last grid value: a sample's change apart; the PWM acts from the next grid point.
    for name in ("brush_degC", "bearing_degC", "magnet_degC", "casing_degC"):
        assert (exact[name] - fixed[name]).abs().max() < 0.01
        assert abs(exact[name][1] - fixed[name][1]) < 1e-5
    assert any(column.startswith("brush.x3") for column in fixed.columns)


def test_simulate_names_file_line_and_column_of_a_bad_run(tmp_path: Path) -> None:
    run = run_file(tmp_path)
    run.write_text(run.read_text().replace("7.3,204", "7.3,fast"))
    done = gen("simulate", COEFFICIENTS, run, "--out", tmp_path / "out.csv")
    assert done.returncode == 2
    assert "run.csv: line 4, column pwm" in done.stderr
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize(("noted", "warns"), [("14", True), ("29.5", False)])
def test_simulate_says_where_a_run_s_room_is_not_the_one_that_the_model_counts_from(
    tmp_path: Path, noted: str, warns: bool
) -> None:
    run = run_file(tmp_path)
    run.write_text(f"# ambient_degC: {noted}\n{run.read_text()}")
    done = gen("simulate", COEFFICIENTS, run, "--out", tmp_path / "out.csv")
    assert done.returncode == 0, done.stderr
    said = f"warning: {run}: its ambient is {noted}.0 degC in the mean, and the model counts from the 30 degC"
    assert (said in done.stderr) is warns


def test_simulate_measured_start_needs_a_measurement(tmp_path: Path) -> None:
    done = gen("simulate", COEFFICIENTS, run_file(tmp_path), "--start", "measured", "--out", tmp_path / "out.csv")
    assert done.returncode == 2
    assert "column bearing_degC" in done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["emulate", str(COEFFICIENTS), "--duration", "nan", "--out", "x.csv"],
        ["emulate", str(COEFFICIENTS), "--sensor-tolerance", "inf", "--out", "x.csv"],
        ["identify", "run.csv", "--sample-time", "nan", "--out", "x.json"],
        ["identify", "run.csv", "--ambient", "1e9", "--out", "x.json"],
        ["verify", str(COEFFICIENTS), "--scale", "nan"],
    ],
)
def test_a_number_that_is_none_is_refused_as_an_option(arguments: list[str], tmp_path: Path) -> None:
    done = gen(*arguments, cwd=tmp_path)
    assert done.returncode == 2
    option = next(word for word in arguments if word.startswith("--"))
    command = rf"\(python -m gen {arguments[0]} --help\)"
    assert re.fullmatch(rf"error: {option}: .+ is not (a finite number|in the range .+) {command}\n", done.stderr)
    assert not list(tmp_path.iterdir())
