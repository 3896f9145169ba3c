"""Points of several measurements: what a point calls itself tells its fields from those of others."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.importing.logs import TRUE, same, taken, write

BEGIN = 1772439300
Form = Callable[[list[tuple[str, str, float, int]]], str]
NAMES = {"pwm": "drive", "winding_degC": "winding", "ambient_degC": "room"}


def points(parts: dict[str, str], apart_ns: int) -> list[tuple[str, str, float, int]]:
    """Measurement, field, value and time in ns of points that come one by one, each sensor at a time of its own."""
    return [
        (NAMES[column], parts[column], row[column], (BEGIN + 10 * i) * 10**9 + k * apart_ns)
        for i, row in enumerate(TRUE.to_dict("records"))
        for k, column in enumerate(NAMES)
    ]


def lines(found: list[tuple[str, str, float, int]]) -> str:
    return "\n".join(f"{name},host=pi {field}={value} {at}" for name, field, value, at in found)


def records(found: list[tuple[str, str, float, int]]) -> str:
    return "\n".join(
        json.dumps({"fields": {field: value}, "name": name, "tags": {"host": "pi"}, "timestamp": at})
        for name, field, value, at in found
    )


@pytest.mark.parametrize("apart_ns", [0, 1_000_000])
@pytest.mark.parametrize("form", [lines, records])
@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"winding_degC": "temp", "ambient_degC": "temp", "pwm": "pwm"}, {}),
        (dict.fromkeys(NAMES, "value"), {"input": "drive.value", "full_scale": 255.0}),  # as openHAB writes
    ],
)
def test_fields_of_one_name(
    fields: dict[str, str], said: dict[str, object], form: Form, apart_ns: int, tmp_path: Path
) -> None:
    """Of several measurements they never come into one column, whether their times are the same or not."""
    columns = taken(write(tmp_path, form(points(fields, apart_ns))), tmp_path / "out", **said).columns()
    for name in ("winding_degC", "ambient_degC"):
        values = columns[name][np.isfinite(columns[name])]
        np.testing.assert_allclose(values, TRUE[name], rtol=0, atol=1e-9)
    assert len(columns["time_s"]) == len(TRUE) * (3 if apart_ns else 1)
    assert sorted(set(columns["pwm"])) == [0, 204]


def test_tags_that_tell_all_apart_need_no_measurement(tmp_path: Path) -> None:
    """And neither does a field that no other measurement has."""
    text = "\n".join(
        f"motor,part=winding temp={row.winding_degC} {BEGIN + 10 * i}\nroom temp={row.ambient_degC} {BEGIN + 10 * i}\n"
        f"drive pwm={row.pwm} {BEGIN + 10 * i}"
        for i, row in enumerate(TRUE.itertuples())
    )
    run = taken(write(tmp_path, text), tmp_path / "out")
    same(run, TRUE.drop(columns="casing_degC").assign(time_s=10.0 * np.arange(len(TRUE))))
