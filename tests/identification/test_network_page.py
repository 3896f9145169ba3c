"""The page of an identified network: picture, runs, numbers; nothing from outside, and markup stays text."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import gen
from tests.command import gen as command

NAMES = ("rotor", "shell")


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Two heat capacities with one run of steps and a rest, identified."""
    folder = tmp_path_factory.mktemp("runs")
    random = np.random.default_rng(3)
    time = np.arange(0.0, 9000.0, 5.0)
    pwm = np.select([time < 3000.0, time < 5000.0, time < 7000.0], [200, 90, 255], 0)
    rotor, case = 25.0, 25.0
    rows = []
    for t, p in zip(time, pwm, strict=True):
        rows.append((t, p, rotor + random.normal(0.0, 0.1), case + random.normal(0.0, 0.1), 25.0))
        flow = 0.5 * (rotor - case)
        rotor += 5.0 * (p * 0.05 - flow) / 200.0
        case += 5.0 * (flow - 0.4 * (case - 25.0)) / 600.0
    table = pd.DataFrame(rows, columns=["time_s", "pwm", "rotor_degC", "shell_degC", "ambient_degC"])
    path = folder / "a run with <b>.csv"
    table.to_csv(path, index=False)
    return gen.identify([path], model="network", max_hidden=0).html()


def test_it_shows_every_part_path_and_run(page: str) -> None:
    for name in NAMES:
        assert f">{name}<" in page
    assert page.count('class="network"') == 2
    assert page.count("residual-0-title") >= 1
    assert "rotor – shell" in page
    assert "shell – ambient" in page


def test_names_of_files_stay_text_and_nothing_is_loaded_from_outside(page: str) -> None:
    assert "<b>" not in page
    assert "&lt;b&gt;" in page
    for outside in ("http://", "https://", "src=", "@import"):
        assert outside not in page.replace("http://www.w3.org", "")


def test_without_a_run_nothing_is_written(tmp_path: Path) -> None:
    given: list[str | Path] = [tmp_path / "none.csv", "--model", "network", "--out", "c.json", "--report", "r.html"]
    done = command("identify", *given, cwd=tmp_path)
    assert done.returncode == 2
    assert not list(tmp_path.iterdir())
