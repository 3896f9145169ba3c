"""What commands print again and again with a time between: `sensors`, `sensors -j`, `vcgencmd`, `jq`; and Firebase."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, same, taken, write

BEGIN = datetime(2026, 3, 2, 8, 15)
STAMPS = [BEGIN + timedelta(seconds=60 * i) for i in range(len(TRUE))]
LONG = TRUE.assign(time_s=60.0 * np.arange(len(TRUE)))
FORMS: list[Callable[[datetime], str]] = [
    lambda at: f"{at:%Y-%m-%d %H:%M:%S}",
    lambda at: f"{at:%a %b} {at.day:2d} {at:%H:%M:%S} UTC {at:%Y}",
    lambda at: f"{at:%a} {at.day} {at:%b %H:%M:%S} GMT {at:%Y}",
    lambda at: f"=== {at:%Y-%m-%dT%H:%M:%S} ===",
    lambda at: str(int((at - datetime(1970, 1, 1)).total_seconds())),
]


def chips(row: pd.Series[float], degrees: str = "°C", scale: float = 1.0, offset: float = 0.0) -> str:
    winding, casing = (row[name] * scale + offset for name in ("winding_degC", "casing_degC"))
    limits = f"(high = +{80.0 * scale + offset:.1f}{degrees}, crit = +{100.0 * scale + offset:.1f}{degrees})"
    return (
        f"max31790-i2c-1-20\nAdapter: bcm2835 (i2c@7e804000)\nfan1:        1200 RPM  (min =    0 RPM)\n"
        f"pwm1:            {row['pwm'] / 2.55:.0f}%\n\n"
        f"lm75-i2c-1-48\nAdapter: bcm2835 (i2c@7e804000)\nWinding:      +{winding:.2f}{degrees}  {limits}\n"
        f"                       (crit = +100.0{degrees})\n"
        f"Casing:       +{casing:.2f}{degrees}  {limits}  ALARM\n\n"
    )


def rounds(form: Callable[[datetime], str], said: Callable[[pd.Series[float]], str]) -> str:
    return "".join(f"{form(at)}\n{said(row)}" for at, (_, row) in zip(STAMPS, TRUE.iterrows(), strict=True))


@pytest.mark.parametrize("form", FORMS)
def test_what_sensors_prints_with_times_between(form: Callable[[datetime], str], tmp_path: Path) -> None:
    run = taken(write(tmp_path, rounds(form, chips), name="sensors.txt"), tmp_path / "out")
    assert run.comments["started"] == "2026-03-02T08:15:00.000"
    parts = {"winding_degC": "lm75_i2c_1_48_Winding_degC", "casing_degC": "lm75_i2c_1_48_Casing_degC"}
    same(run, LONG[["time_s", "pwm", *parts]], parts)
    assert len(run.temps) == 2


@pytest.mark.parametrize("degrees", ["°F", "F", " F", "�F"])
def test_of_degrees_fahrenheit(degrees: str, tmp_path: Path) -> None:
    text = rounds(FORMS[0], lambda row: chips(row, degrees, 1.8, 32.0))
    run = taken(write(tmp_path, text, name="sensors.txt"), tmp_path / "out")
    np.testing.assert_allclose(run.temps["lm75_i2c_1_48_Winding"], TRUE.winding_degC, atol=0.01)


def test_without_times_the_message_says_how_to_record_them(tmp_path: Path) -> None:
    text = "".join(chips(row) for _, row in TRUE.iterrows())
    path = write(tmp_path, text, name="sensors.txt")
    with pytest.raises(InputError, match=r"date .* sensors; sleep"):
        taken(path, tmp_path / "out")
    run = taken(path, tmp_path / "out", time="60")
    same(run, LONG[["time_s", "pwm"]])


def in_json(row: pd.Series[float]) -> str:
    parts = {f"temp{i}": name for i, name in enumerate(("winding", "casing"), start=1)}
    temps = {
        name.capitalize(): {f"{key}_input": row[f"{name}_degC"], f"{key}_max": 80.0, f"{key}_crit": 100.0}
        for key, name in parts.items()
    }
    tree = {"lm75-i2c-1-48": {"Adapter": "bcm2835", **temps, "pwm1": {"pwm1": int(row["pwm"])}}}
    return json.dumps(tree, indent=3) + "\n"


@pytest.mark.parametrize("form", FORMS)
def test_documents_over_several_lines_with_times_between(form: Callable[[datetime], str], tmp_path: Path) -> None:
    run = taken(write(tmp_path, rounds(form, in_json), name="sensors.json"), tmp_path / "out")
    assert run.comments["started"] == "2026-03-02T08:15:00.000"
    parts = {name: f"lm75_i2c_1_48_{name}" for name in ("winding_degC", "casing_degC")}
    same(run, LONG[["time_s", "pwm", *parts]], parts)
    assert len(run.temps) == 2


def test_documents_one_behind_the_other(tmp_path: Path) -> None:
    records = [
        {"ts": f"{at:%FT%TZ}", **row} for at, row in zip(STAMPS, TRUE.iloc[:, 1:].to_dict("records"), strict=True)
    ]
    text = "\n".join(json.dumps(record, indent=2) for record in records)
    same(taken(write(tmp_path, text, name="log.json"), tmp_path / "out"), LONG)


def test_a_document_that_breaks_off_is_refused_with_its_line(tmp_path: Path) -> None:
    text = "\n".join(json.dumps(record, indent=2) for record in TRUE.to_dict("records"))
    with pytest.raises(InputError, match="line 8"):
        taken(write(tmp_path, text[:-20], name="log.json"), tmp_path / "out")


@pytest.mark.parametrize("form", FORMS)
def test_one_number_below_each_time(form: Callable[[datetime], str], tmp_path: Path) -> None:
    text = rounds(form, lambda row: f"temp={row['winding_degC']:.1f}'C\n")
    run = taken(write(tmp_path, text, name="pi.txt"), tmp_path / "out", input="153")
    assert run.comments["started"] == "2026-03-02T08:15:00.000"
    same(run, LONG[["time_s", "winding_degC"]], {"winding_degC": "temp_degC"})


@pytest.mark.parametrize(
    ("key", "named"),
    [
        (lambda i: f"{STAMPS[i]:%FT%TZ}", False),
        (lambda i: str(1_772_439_300_000 + 60_000 * i), False),
        (lambda i: f"-Mabc{i:04x}", True),
    ],
)
def test_objects_by_their_times_or_by_keys_that_mean_nothing(
    key: Callable[[int], str], named: bool, tmp_path: Path
) -> None:
    rows = TRUE.iloc[:, 1:].to_dict("records")
    tree = {key(i): {**row, **({"ts": 1_772_439_300 + 60 * i} if named else {})} for i, row in enumerate(rows)}
    run = taken(write(tmp_path, json.dumps({"log": tree}), name="log.json"), tmp_path / "out")
    same(run, LONG)
    assert run.comments["started"] == "2026-03-02T08:15:00.000"
