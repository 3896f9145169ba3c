"""What a log holds beside temperatures that is called like them: wanted values, limits, a controller's terms."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.importing.logs import TRUE, csv, taken, write


@pytest.mark.parametrize(
    "word", ["goal", "wanted", "desired", "demand", "request", "aim", "SP", "SV", "cmd", "setpoint", "target"]
)
@pytest.mark.parametrize("unit", ["", " [C]"])
def test_what_a_part_shall_reach_is_no_part(word: str, unit: str, tmp_path: Path) -> None:
    wanted = 21.0 + 0.3 * np.arange(len(TRUE)) / 2
    run = taken(write(tmp_path, csv(TRUE.assign(**{f"winding temp {word}{unit}": wanted}))), tmp_path / "out")
    assert set(run.temps) == {"winding", "casing"}


def test_what_a_motor_is_told_keeps_its_name(tmp_path: Path) -> None:
    frame = TRUE.rename(columns={"pwm": "pwm demand"})
    assert taken(write(tmp_path, csv(frame)), tmp_path / "out", units={"pwm demand": "counts"}).pwm.max() == 204


@pytest.mark.parametrize(
    ("name", "value"), [("GPU Slowdown Temp", 95), ("GPU Max Operating Temp", 50), ("GPU Shutdown Temp", 98)]
)
def test_limits_are_no_parts(name: str, value: float, tmp_path: Path) -> None:
    """One of 50 degrees that the winding passes, too."""
    run = taken(write(tmp_path, csv(TRUE.assign(**{name: value}))), tmp_path / "out")
    assert TRUE["winding_degC"].max() > 50.0
    assert set(run.temps) == {"winding", "casing"}


def test_a_controller_s_terms_are_neither_a_current_nor_a_power(tmp_path: Path) -> None:
    wave = np.sin(np.arange(len(TRUE)) / 9.0)
    run = taken(write(tmp_path, csv(TRUE.assign(p=100 * wave, i=5 + wave, d=wave))), tmp_path / "out")
    assert {"p", "i", "d"} <= set(run.extras)
    alone = taken(write(tmp_path, csv(TRUE.assign(i=5 + wave))), tmp_path / "more")
    assert "current_A" in alone.extras
