"""Logs of several devices, each in a row of its own, which a column of whole numbers tells apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, take, taken, write

ROWS = 60


def two_devices(column: str) -> str:
    """Two motors, read 2 ms apart every 5 s, the second 6 K colder and at another duty."""
    begin = pd.Timestamp("2026-05-02 23:10:03")
    lines = [f"time,{column},duty_pct,winding_degC,casing_degC"]
    for i in range(ROWS):
        for device in (0, 1):
            at = begin + pd.Timedelta(milliseconds=5000 * i + 2 * device)
            duty, winding = (60 - 20 * device) * (i > 5), 30.0 + 0.5 * i - 6.0 * device
            lines.append(f"{at.isoformat(sep=' ', timespec='milliseconds')},{device},{duty},{winding},{25.0 - device}")
    return "\n".join(lines)


@pytest.mark.parametrize("column", ["unit", "index", "device", "Instance", "motor", "slave", "addr", "device_id"])
def test_devices_are_told_apart_by_their_number(column: str, tmp_path: Path) -> None:
    log = write(tmp_path, two_devices(column))
    with pytest.raises(InputError, match=rf"column {column}: has a row for each of 0, 1; expected --series {column},"):
        take(log, tmp_path / "out")
    told = f"{column},duty_pct,winding_degC,casing_degC"
    found = take(log, tmp_path / "out", series=told, input=f"{column} 0.duty_pct")
    run = read_run(found.runs[0])
    first = run.temps[f"{column}_0_winding".lower()]
    np.testing.assert_allclose(first[np.isfinite(first)], 30.0 + 0.5 * np.arange(ROWS))


def test_a_number_of_another_name_between_which_a_temperature_goes_to_and_fro(tmp_path: Path) -> None:
    log = write(tmp_path, two_devices("foo"))
    with pytest.raises(InputError, match=r"column foo: has a row for each of 0, 1, between which winding_degC goes"):
        take(log, tmp_path / "out")


def test_a_temperature_of_each_device_that_seldom_moves_is_offered_as_well(tmp_path: Path) -> None:
    lines = two_devices("index").split("\n")
    lines = [f"{lines[0]},temperature.memory", *(f"{line},{21 + (i == 70)}" for i, line in enumerate(lines[1:]))]
    with pytest.raises(InputError, match=r"--series index,duty_pct,winding_degC,casing_degC,temperature\.memory, "):
        take(write(tmp_path, "\n".join(lines)), tmp_path / "out")


@pytest.mark.parametrize("column", ["motor", "drive", "unit"])
def test_a_switch_is_no_device(column: str, tmp_path: Path) -> None:
    """Whether a motor runs, by such a name: it stays for many rows."""
    frame = TRUE.assign(**{column: (TRUE["pwm"] > 0).astype(int)})
    run = taken(write(tmp_path, csv(frame)), tmp_path / "out")
    np.testing.assert_array_equal(run.temps["winding"], TRUE["winding_degC"])
