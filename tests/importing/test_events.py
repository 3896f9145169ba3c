"""A recorder's own: a zone and numbers of sensors in the header, and rows that only say that something happened."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.importing.logs import TRUE, same, take, taken, write

BEGIN = datetime(2026, 3, 2, 8, 15)
LONG = TRUE.assign(time_s=60.0 * np.arange(len(TRUE)))


def of_hobo(zone: str, labels: tuple[str, str] = ("", "")) -> str:
    said = [f"LGR S/N: 1234, SEN S/N: {number}{label}" for number, label in zip((5, 6), labels, strict=True)]
    lines = [
        '"Plot Title: Motor bench"',
        f'"#","Date Time, {zone}","Temp, °F ({said[0]})","Temp, °F ({said[1]})","PWM, %","Logged","End of File"',
    ]
    for i, row in TRUE.iterrows():
        at = BEGIN + timedelta(seconds=60 * len(lines) - 120)
        temps = ",".join(f"{row[name] * 1.8 + 32.0:.2f}" for name in ("winding_degC", "casing_degC"))
        lines.append(f"{int(str(i)) + 1},{at:%m/%d/%y %I:%M:%S %p},{temps},{row['pwm'] / 2.55:.2f},,")
    lines.append(f"{len(lines) - 1},{BEGIN + timedelta(hours=3):%m/%d/%y %I:%M:%S %p},,,,Logged,")
    lines.append(f"{len(lines) - 1},{BEGIN + timedelta(hours=4):%m/%d/%y %I:%M:%S %p},,,,,Logged")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("zone", "started"),
    [
        ("GMT+01:00", "2026-03-02T07:15:00.000"),
        ("GMT-05:00", "2026-03-02T13:15:00.000"),
        ("UTC +0530", "2026-03-02T02:45:00.000"),
    ],
)
def test_a_zone_in_the_header_is_that_of_the_times(zone: str, started: str, tmp_path: Path) -> None:
    found = take(write(tmp_path, of_hobo(zone)), tmp_path / "out")
    assert f"# started: {started}" in found.runs[0].read_text()
    assert found.counted().index.tolist()[1] == "row with a time and nothing else, left out"
    assert found.counted()["count"].tolist() == [len(TRUE) + 2, 2]


def test_sensors_without_a_label_are_called_by_their_numbers(tmp_path: Path) -> None:
    run = taken(write(tmp_path, of_hobo("GMT+01:00")), tmp_path / "out")
    same(run, LONG[["time_s"]])
    np.testing.assert_allclose(run.temps["temp_5"], TRUE.winding_degC, atol=0.01)
    np.testing.assert_allclose(run.temps["temp_6"], TRUE.casing_degC, atol=0.01)


def test_labels_are_names(tmp_path: Path) -> None:
    run = taken(write(tmp_path, of_hobo("GMT+01:00", (", LBL: Winding", ", LBL: Casing"))), tmp_path / "out")
    assert list(run.temps) == ["winding", "casing"]
