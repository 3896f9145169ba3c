"""The report of a refinement: runs are shown first, none of their peaks is lost, and it says what was done."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gen.coefficients import Coefficients, load, parse
from gen.model.exact import ExactSolution
from gen.refinement.parts.page import page
from gen.refinement.parts.refine import refine
from gen.refinement.thinning import Samples, held, measured
from gen.runs import Run, write_run
from tests.refinement.plant import COEFFICIENTS
from tests.refinement.plant_effects import make


@pytest.mark.parametrize("most", [4, 100, 301])
def test_thinned_samples_keep_ends_and_every_peak(most: int) -> None:
    random = np.random.default_rng(3)
    time_s = np.cumsum(random.uniform(0.1, 0.5, 43_200))
    time_s[20_000:] += 5_000.0  # a gap
    values = np.sin(time_s / 900.0)
    values[[7, 31_000]] = 9.0, -9.0
    thin = Samples(time_s, values).thinned(most)
    assert thin.time_s.size <= most
    assert np.all(np.diff(thin.time_s) > 0.0)
    assert (thin.time_s[0], thin.time_s[-1]) == (time_s[0], time_s[-1])
    assert (thin.values.min(), thin.values.max()) == (-9.0, 9.0)
    np.testing.assert_array_equal(thin.values, values[np.searchsorted(time_s, thin.time_s)])


def test_few_samples_stay_as_they_are() -> None:
    samples = measured(np.arange(5.0), np.array([1.0, np.nan, 3.0, 4.0, np.nan]))
    assert samples.thinned(10) is samples
    np.testing.assert_array_equal(samples.time_s, [0.0, 2.0, 3.0])


def test_what_is_held_keeps_its_changes() -> None:
    samples = held(np.arange(6.0), np.array([5.0, 5.0, 0.0, 0.0, 7.0, 7.0]))
    np.testing.assert_array_equal(samples.time_s, [0.0, 2.0, 4.0, 5.0])
    np.testing.assert_array_equal(samples.values, [5.0, 0.0, 7.0, 7.0])


def test_a_page_of_one_fit_run_shows_runs_first_and_says_thirds(tmp_path: Path) -> None:
    fit, test, _ = make(tmp_path, ("sensor_gain",), 5)
    baseline = load(COEFFICIENTS)
    found = refine(baseline, COEFFICIENTS.read_text(encoding="utf-8"), fit[:1], test)
    text = page(found, baseline)
    assert re.findall("<h2>([^<]*)</h2>", text)[0] == "Measured and modelled"
    pictures = text[text.index("<h2>Measured and modelled") : text.index("<h2>What was measured")]
    heads = re.findall(r"<(?:h3|summary)>([^<:]*): (test|fit) run of 2.5 h, RMSE [0-9.]+ → [0-9.]+ K<", pictures)
    assert heads == [("test6.csv", "test"), ("test7.csv", "test"), ("fit0.csv", "fit")]
    changed = {effect["component"] for effect in found.effects}
    for figure in re.findall("<figure>.*?</figure>", pictures, flags=re.DOTALL):
        roles = re.findall('<path class="(measured|before|after|drive)"', figure)
        component = re.search('chart-title"[^>]*>([^<]*)<', figure)
        assert component is not None
        own = ["measured", "before", "after"] if component[1] in changed else ["measured", "after"]
        assert roles == [*own, "drive"]
    assert "judged on what was left out in turn: thirds of the one run" in text
    assert "whole runs" not in text
    assert "left-out run" not in text.replace("left-out runs", "left-out run")


SIX = ("brush", "bearing", "magnet", "casing", "flange", "shaft")


def six_parts() -> tuple[Coefficients, str]:
    """The example with two parts more, of the casing's kind."""
    tree = json.loads(COEFFICIENTS.read_text(encoding="utf-8"))
    casing = next(entry for entry in tree["components"] if entry["name"] == "casing")
    tree["components"] = [e for e in tree["components"] if e["name"] in SIX] + [{**casing, "name": n} for n in SIX[4:]]
    tree.pop("alarms", None)
    text = json.dumps(tree)
    return parse(text.encode()), text


def test_many_long_runs_of_six_parts_stay_a_small_page(tmp_path: Path) -> None:
    """3 h at 4 Hz; some seconds in which the shaft's sensor goes to 99 degC and back are seen in its picture."""
    baseline, raw = six_parts()
    random = np.random.default_rng(9)
    time_s = np.arange(0.0, 10_800.0, 0.25)
    paths = []
    for number in range(6):
        levels = random.choice([0, 77, 153, 255], 9)
        pwm = levels[np.minimum((time_s / 1200.0).astype(int), 8)].astype(np.int64)
        rises = ExactSolution(baseline.model).simulate_times(time_s, pwm)
        temps = {n: np.round((r + 30.0 + random.normal(0.0, 0.2, r.size)) * 4.0) / 4.0 for n, r in rises.items()}
        path = tmp_path / f"run{number}.csv"
        if number == 5:
            away = 2.0 * np.abs(np.arange(temps["shaft"].size) - 12_345)  # no faster than is believed
            temps["shaft"] = np.maximum(temps["shaft"], 99.0 - away)
        write_run(path, Run(time_s, pwm, temps))
        paths.append(path)
    found = refine(baseline, raw, paths[:4], paths[4:])
    text = page(found, baseline)
    assert len(text) < 1_000_000
    assert text.count("<figure>") >= 36
    assert text.index("run4.csv: test run of 3 h") < text.index("run5.csv: test run") < text.index("run0.csv: fit run")
    shaft = text[text.index('<title id="run-1-shaft-title">') :].split("</svg>")[0]
    dots = re.search(r'<path class="measured" d="([^"]*)"', shaft)
    assert dots is not None
    heights = sorted(float(y) for y in re.findall(r"M\S+ (\S+?)h0", dots[1]))
    assert heights[0] < 35.0  # at the top
    assert heights[10] > 50.0  # far from all others
    first = text[: text.index("<details>")]
    assert first.count("<figure>") == 6  # the first test run; the others are folded


def test_a_short_run_is_drawn_over_minutes(tmp_path: Path) -> None:
    baseline = load(COEFFICIENTS)
    raw = COEFFICIENTS.read_text(encoding="utf-8")
    time_s = np.arange(0.0, 1200.0, 2.0)
    pwm = np.where(time_s < 600.0, 153, -77)
    rises = ExactSolution(baseline.model).simulate_times(time_s, pwm)
    random = np.random.default_rng(4)
    run = Run(time_s, pwm, {n: r + 30.0 + random.normal(0.0, 0.2, r.size) for n, r in rises.items()})
    paths = [tmp_path / name for name in ("a.csv", "b.csv")]
    write_run(paths[0], run)
    write_run(paths[1], replace(run, temps={"casing": run.temps["casing"]}))
    text = page(refine(baseline, raw, paths[:1], paths[1:]), baseline)
    assert "b.csv: test run of 20 min" in text
    assert "time (min)" in text
    assert "PWM from -77 to 153" in text
