"""`gen refine` on runs in which something acted that no column holds: told as what it is, and not learnt."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from gen.arrays import FloatArray
from gen.cli import cli
from gen.refinement.network.effects import Motor, NetworkEffect, Offered, candidates
from tests.refinement.network.motor import HOURS, ROW_S, Tree, read, run, tree, write

TIME_S: FloatArray = ROW_S * np.arange(int(HOURS * 3600.0 / ROW_S), dtype=np.float64)


def told(folder: Path, motor: Tree, column: str, courses: list[FloatArray], *options: str) -> tuple[dict, str, str]:  # type: ignore[type-arg]
    """Refine runs of a motor that a column drives; the files do not have it. The last run is the test run.

    Returns
    -------
    summary, page, text
        The JSON summary, the report, and the coefficient file that was written.
    """
    given = []
    for number, course in enumerate(courses):
        made = replace(run(read(motor), 40 + number, {column: course}), extras={})
        given.append(str(write(made, folder / f"run_{number}.csv")))
    (folder / "small.json").write_text(json.dumps(tree()), encoding="utf-8")
    out, summary, report = (folder / name for name in ("out.json", "summary.json", "report.html"))
    named = ["--fit", *given[:-1], "--test", given[-1], "--out", str(out), "--json", str(summary)]
    result = CliRunner().invoke(cli, ["refine", str(folder / "small.json"), *named, "--report", str(report), *options])
    assert result.exit_code == 0, result.output
    page = report.read_text(encoding="utf-8")
    return json.loads(summary.read_text(encoding="utf-8")), page, out.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def belt(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict, str, str]:  # type: ignore[type-arg]
    """A conveyor that is loaded for 20 minutes of 35: the winding then heats by two thirds more at every speed."""
    motor = tree()
    motor["network"]["channels"] = [{"column": "load", "range": [0, 1], "neutral": 0}]
    motor["network"]["heats"][0]["factors"] = [{"channel": "load", "poly": [0.7, 1.0]}]
    on = [np.where((TIME_S + 400.0 * k) % 2100.0 < 1200.0, 1.0, 0.0) for k in range(4)]
    return told(tmp_path_factory.mktemp("belt"), motor, "load", on)


def test_a_load_that_comes_and_goes_is_no_change_of_the_motor(belt: tuple[dict, str, str]) -> None:  # type: ignore[type-arg]
    summary, _, written = belt
    assert summary["missing_heat"]["pattern"] == "comes and goes"
    assert summary["missing_heat"]["component"] == "winding"
    said = " ".join(summary["warnings"])
    assert "comes and goes" in said
    assert "has changed since" not in said
    assert (summary["verdict"], summary["effects"]) == ("unexplained", [])
    assert json.loads(written)["network"] == tree()["network"]


def test_the_summary_has_its_course(belt: tuple[dict, str, str]) -> None:  # type: ignore[type-arg]
    summary, _, _ = belt
    for number, one in enumerate(summary["missing_heat"]["runs"].values()):
        time, heat = np.array(one["time_s"]), np.array(one["heat_W"])
        pwm = np.abs(run(read(tree()), 40 + number).pwm)
        turning = np.interp(time, TIME_S, pwm) > 60.0
        on = (time + 400.0 * number) % 2100.0 < 1200.0
        assert np.median(heat[on & turning]) > np.median(heat[~on & turning]) + 1.0


def test_the_report_draws_it_over_time_with_one_scale(belt: tuple[dict, str, str]) -> None:  # type: ignore[type-arg]
    _, page, _ = belt
    assert "Heat that would explain what is left" in page
    drawn = re.findall(r'<svg [^>]*aria-labelledby="heat-\d-title.*?</svg>', page, re.DOTALL)
    assert len(drawn) == 3
    assert all('class="band"' in one for one in drawn)
    heat = [one.partition(">W<")[0] for one in drawn]  # the upper panel
    ticks = [re.findall(r'class="tick end"[^>]*>([^<]*)<', one) for one in heat]
    assert len(ticks[0]) > 2
    assert ticks[0] == ticks[1] == ticks[2]


def fanned(gain: float) -> Tree:
    motor = tree()
    motor["network"]["channels"] = [{"column": "fan", "range": [0, 1], "neutral": 0}]
    motor["network"]["paths"][1]["factors"] = [{"channel": "fan", "poly": [gain, 1.0]}]
    return motor


def test_a_fan_that_comes_and_goes_is_told_as_cooling(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def few(motor: Motor, offered: Offered) -> list[NetworkEffect]:
        """The search among all effects takes far longer than what is asked for here."""
        return [one for one in candidates(motor, offered) if one.name == "sensor_lag"]

    monkeypatch.setattr("gen.refinement.network.tracing.trace.candidates", few)
    on = [np.where((TIME_S + 900.0 * k) % 4000.0 < 1800.0, 1.0, 0.0) for k in range(3)]
    summary, page, written = told(tmp_path, fanned(0.9), "fan", on)
    missing = summary["missing_heat"]
    assert (missing["quantity"], missing["component"]) == ("conductance", "casing")
    assert missing["pattern"] == "comes and goes"
    for blows, one in zip(on, missing["runs"].values(), strict=False):
        time, value = np.array(one["time_s"]), np.array(one["conductance_W_per_K"])
        blown = np.array([blows[np.abs(TIME_S - middle) < 150.0].mean() for middle in time])
        assert np.median(value[blown == 1.0]) > np.median(value[blown == 0.0]) + 0.1
        assert len(one["deviation_W_per_K"]) == time.size
    assert "Cooling that would explain what is left" in page
    drawn = re.findall(r'<svg [^>]*aria-labelledby="heat-\d-title.*?</svg>', page, re.DOTALL)
    assert len(drawn) == 2
    assert all(">W/K<" in one for one in drawn)
    assert any("cooling comes and goes" in said for said in summary["warnings"])
    assert json.loads(written)["network"] == tree()["network"]
    assert (summary["verdict"], summary["effects"]) == ("unexplained", [])


def switched(on: tuple[int, ...], runs: int) -> list[FloatArray]:
    """A fan that somebody switched on for some of the runs."""
    return [np.full(TIME_S.size, float(k in on)) for k in range(runs)]


def test_what_is_not_in_all_runs_is_told_by_run(tmp_path: Path) -> None:
    summary, _, written = told(tmp_path, fanned(0.6), "fan", switched((1, 3), 6))
    assert json.loads(written)["network"] == tree()["network"]
    assert summary["missing_heat"]["pattern"] == "by run"
    assert summary["verdict"] == "unexplained"


def test_what_grows_from_run_to_run_is_told_as_that_and_not_learnt(tmp_path: Path) -> None:
    """Dust: it cools by an eighth less in each further run."""
    motor = tree()
    motor["network"]["channels"] = [{"column": "dust", "range": [0, 1], "neutral": 0}]
    motor["network"]["paths"][1]["factors"] = [{"channel": "dust", "poly": [-0.6, 1.0]}]
    summary, _, written = told(tmp_path, motor, "dust", [np.full(TIME_S.size, 0.2 * k) for k in range(1, 6)])
    assert summary["missing_heat"]["pattern"] == "grows"
    assert json.loads(written)["network"] == tree()["network"]
    assert any("goes one way from run to run" in said for said in summary["warnings"])


def test_runs_that_the_file_explains_do_not_pay_for_others(tmp_path: Path) -> None:
    """What was found in cooled runs would have the others be cool as well."""
    summary, _, written = told(tmp_path, fanned(0.3), "fan", switched((1, 2), 4))
    assert summary["effects"] == []
    assert any(not one["against"] for step in summary["considered"] for one in step["candidates"])
    assert json.loads(written)["network"] == tree()["network"]
    said = [warning for warning in summary["warnings"] if "explained by the file as it is" in warning]
    assert len(said) == 1
    assert said[0].startswith("run_0.csv: ")
    assert summary["verdict"] == "unexplained"
    assert summary["after"] == summary["before"]
