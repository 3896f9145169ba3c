"""Readings that no motor has are taken as they stand, and said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.importing.stray import stray, too_warm
from tests.importing.logs import TRUE, csv, take, write


@pytest.mark.parametrize("value", [850.0, 1372.0, -99.0, 0.0, -40.0])
@pytest.mark.parametrize("rows", [[60], [60, 61, 62], [30, 31, 90]])
def test_a_few_rows_of_an_open_sensor_are_told(value: float, rows: list[int], tmp_path: Path) -> None:
    winding = TRUE.winding_degC + 20.0
    winding[rows] = value
    found = take(write(tmp_path, csv(TRUE.assign(winding_degC=winding))), tmp_path / "out")
    assert len(found.warnings) == 1
    assert f"winding_degC: {len(rows)} x far from the readings before and behind" in found.warnings[0]
    assert f"first {value:g} degC at line {rows[0] + 2}" in found.warnings[0]


def test_a_sensor_that_is_not_there_is_told(tmp_path: Path) -> None:
    found = take(write(tmp_path, csv(TRUE.assign(brush_degC=1372.0))), tmp_path / "out")
    assert len(found.warnings) == 1
    assert "brush_degC: begins at 1372 degC where others begin cold" in found.warnings[0]


def test_what_motors_do_is_not() -> None:
    time = np.arange(600.0)
    for values in (
        20.0 + 60.0 * (1.0 - np.exp(-time / 100.0)),
        np.where(time < 300.0, 20.0, 80.0),
        40.0 + 10.0 * np.sin(time / 5.0),
        np.full(600, 1372.0),
    ):
        assert stray(values) is None
    assert too_warm({"a": 250.0, "b": 260.0}) == []
