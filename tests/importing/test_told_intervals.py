"""Intervals that lines above a table say: they are proposed where no column is a time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from gen.importing.reading.rows.intervals import told_interval
from tests.importing.logs import TRUE, csv, take, taken, write


@pytest.mark.parametrize(
    ("line", "seconds"),
    [
        ("Sample Rate: 4 Hz", "0.25"),
        ("Interval: 00:00:05", "5"),
        ("Sampling interval [s]: 5", "5"),
        ("Scan Interval,250,ms", "0.25"),
        ("Delta_X\t5.000000\t5.000000", "5"),
        ("logging interval=2 min", "120"),
        ("# Sample Rate: 4 Hz", "0.25"),
    ],
)
def test_an_interval_that_a_line_says(line: str, seconds: str) -> None:
    said = told_interval([line.split(",")], [])
    assert said.startswith(f"--time {seconds}, if ")
    assert told_interval([], [line.replace(",", " ")]) == said


@pytest.mark.parametrize(
    "line", ["Interval: 5", "Sample Rate: 0 Hz", "Heart rate: 4 Hz", "Rate: 3 rpm", "Interval: 3 d"]
)
def test_what_says_no_interval(line: str) -> None:
    assert told_interval([[line]], []) == ""


def test_it_is_proposed_and_works(tmp_path: Path) -> None:
    log = write(tmp_path, "Sample Rate: 2 Hz\n" + csv(TRUE.drop(columns="time_s")))
    with pytest.raises(InputError, match=r'better, --time 0\.5, if "Sample Rate: 2 Hz" is the interval of its rows'):
        take(log, tmp_path / "out")
    np.testing.assert_allclose(taken(log, tmp_path / "told", time="0.5").time_s, TRUE.time_s)
