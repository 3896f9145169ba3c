"""Logs at odds with themselves: files in two units, commas that mean two things, units that only a comment says."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.interface import import_runs
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write

LONG = TRUE.assign(time_s=60.0 * np.arange(len(TRUE)))
PLAIN = LONG[["time_s", "pwm", "winding_degC"]].rename(columns={"time_s": "t", "winding_degC": "winding"})


def written(tmp_path: Path, frames: Sequence[pd.DataFrame]) -> list[Path]:
    return [write(tmp_path, csv(frame), name=f"{i}.csv") for i, frame in enumerate(frames)]


def test_files_whose_times_are_in_two_units_are_asked_for(tmp_path: Path) -> None:
    paths = written(tmp_path, [PLAIN, PLAIN.assign(t=(PLAIN.t * 1000).astype(int))])
    with pytest.raises(InputError, match="a row every 60 in one file and every 60000 in another"):
        import_runs(paths, tmp_path / "out")


def test_files_whose_temperatures_are_in_two_units_are_asked_for(tmp_path: Path) -> None:
    paths = written(tmp_path, [PLAIN, PLAIN, PLAIN.assign(winding=PLAIN.winding + 273.15)])
    with pytest.raises(InputError, match=r"begins at 23\.\d* in one file and at 29"):
        import_runs(paths, tmp_path / "out")


@pytest.mark.parametrize("line", ["# units: s,counts,degF", "# Unit = s; counts; °F", "# Einheiten: s|counts|F"])
def test_units_that_a_comment_lists(line: str, tmp_path: Path) -> None:
    text = csv(PLAIN.assign(winding=np.round((PLAIN.winding - 20.0) * 1.8 + 32.0, 2)))
    run = taken(write(tmp_path, f"{line}\n{text}"), tmp_path / "out")
    np.testing.assert_allclose(run.temps["winding"], PLAIN.winding - 20.0, atol=0.01)


def test_a_comment_that_lists_fewer_units_says_nothing(tmp_path: Path) -> None:
    run = taken(write(tmp_path, f"# units: s,degF\n{csv(PLAIN)}"), tmp_path / "out")
    same(run, PLAIN[["winding"]].rename(columns={"winding": "winding_degC"}))


def test_units_in_a_labview_file_s_preamble(tmp_path: Path) -> None:
    head = [
        "LabVIEW Measurement\t",
        "Separator\tTab",
        "Decimal_Separator\t.",
        "***End_of_Header***\t",
        "\t",
        "Channels\t2\t\t\t",
        f"Samples\t{len(TRUE)}\t{len(TRUE)}\t\t",
        "Y_Unit_Label\tPercent\tDeg F\t\t",
        "X0\t0.0000000000000000E+0\t0.0000000000000000E+0\t\t",
        "Delta_X\t60.000000\t60.000000\t\t",
        "***End_of_Header***\t\t\t\t",
        "X_Value\tPWM\tWinding\tComment",
    ]
    rows = [
        f"{60.0 * i:.6f}\t{pwm / 2.55:.6f}\t{w * 1.8 + 32.0:.6f}"
        for i, (pwm, w) in enumerate(zip(TRUE.pwm, TRUE.winding_degC, strict=True))
    ]
    run = taken(write(tmp_path, "\n".join([*head, *rows, ""]), name="log.lvm"), tmp_path / "out")
    np.testing.assert_allclose(run.temps["winding"], TRUE.winding_degC)
    same(run, LONG[["time_s", "pwm"]])


def test_decimal_commas_among_commas_are_told(tmp_path: Path) -> None:
    rows = [f"{t:g},{str(w).replace('.', ',')},{p}" for t, p, w in PLAIN.itertuples(index=False)]
    with pytest.raises(InputError, match=r"line 2: .*is 21,5 one number, with a decimal comma"):
        take(write(tmp_path, "\n".join(["t,winding,pwm", *rows])), tmp_path / "out")


@pytest.mark.parametrize("form", ['="{}"', "'{}"])
def test_numbers_that_a_spreadsheet_shall_take_as_text(form: str, tmp_path: Path) -> None:
    text = csv(PLAIN.assign(winding=[form.format(w) for w in PLAIN.winding]), quoting=3)
    same(taken(write(tmp_path, text), tmp_path / "out"), LONG[["time_s", "pwm", "winding_degC"]])


def test_exponents_of_fortran_and_thin_spaces(tmp_path: Path) -> None:
    frame = PLAIN.assign(
        t=[f"{t * 1000:,.0f}".replace(",", "\u2009") for t in PLAIN.t],
        winding=[f"{w:.5E}".replace("E", "D") for w in PLAIN.winding],
    ).rename(columns={"t": "t [ms]"})
    same(taken(write(tmp_path, csv(frame)), tmp_path / "out"), LONG[["time_s", "pwm", "winding_degC"]])


def test_am_and_pm_in_a_column_of_their_own(tmp_path: Path) -> None:
    at = [datetime(2026, 3, 2, 11, 15) + timedelta(seconds=60 * i) for i in range(len(TRUE))]
    frame = PLAIN.assign(t=[f"{moment:%I:%M:%S}" for moment in at], half=[f"{moment:%p}" for moment in at])
    frame.insert(0, "date", [f"{moment:%m/%d/%Y}" for moment in at])
    text = csv(frame[["date", "t", "half", "pwm", "winding"]].rename(columns={"t": "time"}))
    found = take(write(tmp_path, text), tmp_path / "out")
    assert found.counted().index.tolist() == ["AM or PM from half"]
    run = read_run(found.runs[0])
    same(run, LONG[["time_s", "pwm", "winding_degC"]])
    assert run.comments["started"] == "2026-03-02T11:15:00.000"


def test_degrees_celsius_called_fahrenheit_are_suspicious(tmp_path: Path) -> None:
    found = take(write(tmp_path, csv(PLAIN.rename(columns={"winding": "winding_degF"}))), tmp_path / "out")
    assert len(found.warnings) == 1
    assert "which would be a room's in degC; if so: --unit winding_degC=degC" in found.warnings[0]


@pytest.mark.parametrize(("counts", "warned"), [([128, 200, 128], True), ([127, 255, 127], True), ([153] * 3, False)])
def test_counts_that_rest_at_the_middle_are_suspicious(counts: list[int], warned: bool, tmp_path: Path) -> None:
    found = take(write(tmp_path, csv(PLAIN.assign(pwm=np.repeat(counts, len(TRUE) // 3)))), tmp_path / "out")
    assert [f"if so: --rest {counts[0]} --full-scale 255" in warning for warning in found.warnings] == [True] * warned
