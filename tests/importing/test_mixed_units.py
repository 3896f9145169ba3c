"""Units behind numbers: meters that choose their range, columns of two scales, minuses of documents."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.interface import Import, import_runs
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write

HALF = np.arange(len(TRUE)) % 2 == 0


def written(values: pd.Series, form: Callable[[float], str], other: Callable[[float], str]) -> list[str]:
    """Every second number in another form."""
    return [form(value) if first else other(value) for value, first in zip(values, HALF, strict=True)]


def counted(found: Import) -> list[str]:
    frame = found.counted().reset_index()
    return [
        f"{count} x {what} ({first})"
        for count, what, first in zip(frame["count"], frame["what"], frame["first"], strict=True)
    ]


def as_celsius(value: float) -> str:
    return f"{value:.1f} °C"


def as_fahrenheit(value: float) -> str:
    return f"{value * 1.8 + 32:.2f} °F"


@pytest.mark.parametrize("name", ["winding", "winding temp [°C]", "winding temp (°F)", "winding_degC"])
def test_cells_of_both_scales_are_each_read_in_their_own(name: str, tmp_path: Path) -> None:
    frame = TRUE.assign(winding_degC=written(TRUE.winding_degC, as_celsius, as_fahrenheit))
    found = take(write(tmp_path, csv(frame.rename(columns={"winding_degC": name}))), tmp_path / "runs")
    np.testing.assert_allclose(read_run(found.runs[0]).temps["winding"], TRUE.winding_degC, atol=1e-9)
    assert any("60 x number in another unit" in said for said in counted(found))


def test_a_meter_that_chooses_its_range_is_read_in_each(tmp_path: Path) -> None:
    current = pd.Series(np.linspace(0.2, 2.6, len(TRUE)).round(3))
    cells = [f"{value * 1000:.0f} mA" if value < 1.0 else f"{value:.3f} A" for value in current]
    run = taken(write(tmp_path, csv(TRUE.assign(current=cells))), tmp_path / "runs")
    np.testing.assert_allclose(run.extras["current_A"], current, atol=1e-9)


def test_a_power_in_two_ranges_drives_the_motor(tmp_path: Path) -> None:
    power = np.where(TRUE.pwm > 0, 1620.0, 540.0)
    cells = [f"{value / 1000:.2f} kW" if value > 1000 else f"{value:.0f} W" for value in power]
    frame = TRUE.drop(columns="pwm").assign(power=cells)
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs", input="power", full_scale=2000.0)
    run = read_run(found.runs[0])
    np.testing.assert_array_equal(run.pwm, np.floor(power / 2000.0 * 255 + 0.5))


def test_files_of_one_header_may_have_other_units(tmp_path: Path) -> None:
    paths = []
    for k, (scale, unit) in enumerate([(1.0, "A"), (1000.0, "mA")]):
        cells = [f"{1.5 * scale:.1f} {unit}"] * len(TRUE)
        paths.append(write(tmp_path, csv(TRUE.assign(current=cells)), name=f"log{k}.csv"))
    for path in import_runs(paths, tmp_path / "runs").runs:
        np.testing.assert_allclose(read_run(path).extras["current_A"], 1.5, atol=1e-9)


def test_times_in_two_units_go_on(tmp_path: Path) -> None:
    cells = [f"{value:g} s" if value < 20 else f"{value / 60:.9f} min" for value in TRUE.time_s]
    run = taken(write(tmp_path, csv(TRUE.assign(time_s=cells).rename(columns={"time_s": "time"}))), tmp_path / "runs")
    np.testing.assert_allclose(run.time_s, TRUE.time_s, atol=1e-6)


def test_a_row_of_units_is_overruled_by_a_unit_behind_the_number(tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=[f"{value * 1000:.0f} ms" for value in TRUE.time_s]).astype(str)
    header, *rows = csv(frame).splitlines()
    text = "\n".join([header.replace("time_s", "time").replace("_degC", ""), "s,,degC,degC,degC", *rows]) + "\n"
    same(taken(write(tmp_path, text), tmp_path / "runs"), TRUE)


def test_a_unit_of_something_else_is_no_number(tmp_path: Path) -> None:
    cells = [f"{value:.1f} °C" for value in TRUE.winding_degC]
    cells[30] = "11.9 V"
    found = take(write(tmp_path, csv(TRUE.assign(winding_degC=cells))), tmp_path / "runs")
    assert np.isnan(read_run(found.runs[0]).temps["winding"][30])
    assert any("text in a number's field" in said and "line 32" in said for said in counted(found))


def test_a_number_without_a_unit_among_others_is_told(tmp_path: Path) -> None:
    cells = [f"{value:.1f} °C" for value in TRUE.winding_degC]
    cells[30] = cells[30].removesuffix(" °C")
    found = take(
        write(tmp_path, csv(TRUE.rename(columns={"winding_degC": "winding"}).assign(winding=cells))), tmp_path / "runs"
    )
    same(read_run(found.runs[0]), TRUE)
    assert any("1 x number without a unit, taken for degC (line 32" in said for said in counted(found))


@pytest.mark.parametrize("minus", ["\u2212", "\u2013", "\uff0d"])
def test_a_typeset_minus_is_one(minus: str, tmp_path: Path) -> None:
    cold = TRUE.assign(ambient_degC=TRUE.ambient_degC - 30, winding_degC=TRUE.winding_degC - 30)
    text = csv(cold).replace(",-", f",{minus}")
    same(taken(write(tmp_path, text), tmp_path / "runs"), cold)
    comma = csv(cold, sep=";", decimal=",").replace(";-", f";{minus}")
    same(taken(write(tmp_path, comma, name="comma.csv"), tmp_path / "comma"), cold)


def in_mA(value: float) -> str:
    return f"{value * 1000:.0f} mA"


def in_A(value: float) -> str:
    return f"{value:.3f} A"


def in_either(value: float) -> str:
    return in_A(value) if value > 1.0 else in_mA(value)


def test_a_mapping_means_the_same_of_a_file_whose_numbers_have_other_units(tmp_path: Path) -> None:
    """Written of a log in mA, kept for one in A and one of both."""
    current = np.linspace(0.2, 2.6, len(TRUE)).round(3)
    mapping = tmp_path / "map.toml"
    for k, form in enumerate((in_mA, in_A, in_either)):
        frame = TRUE.assign(current=[form(value) for value in current], battery=[form(value) for value in current])
        path = write(tmp_path, csv(frame), name=f"log{k}.csv")
        run = taken(path, tmp_path / f"runs{k}", mapping=mapping)
        np.testing.assert_allclose(run.extras["current_A"], current, atol=1e-9)
        np.testing.assert_allclose(run.extras["battery_mA"], 1000.0 * current, atol=1e-6)


def test_what_a_unit_is_said_of_is_numbers_without_one(tmp_path: Path) -> None:
    cells = [f"{value:.1f}" if k % 3 else f"{value * 1.8 + 32:.2f} °F" for k, value in enumerate(TRUE.winding_degC)]
    path = write(tmp_path, csv(TRUE.rename(columns={"winding_degC": "winding"}).assign(winding=cells)))
    same(taken(path, tmp_path / "runs", units={"winding": "degC"}), TRUE)


def test_a_first_row_of_typeset_minuses_is_no_header(tmp_path: Path) -> None:
    rows = "\n".join(f"\u2212{5 + k % 3},0;\u2212{4 + k % 2},5" for k in range(60))
    found = take(
        write(tmp_path, rows + "\n"),
        tmp_path / "runs",
        time="1",
        input="100",
        columns={"column_1": "winding_degC", "column_2": "ambient_degC"},
    )
    run = read_run(found.runs[0])
    assert run.temps["winding"][:3].tolist() == [-5.0, -6.0, -7.0]
    assert run.time_s.size == 60


def test_a_column_of_units_that_change_from_row_to_row(tmp_path: Path) -> None:
    """A meter that chooses its range says it in a column of its own."""
    power = np.where(HALF, 150.0, 0.35)
    frame = TRUE.drop(columns="pwm").assign(power=power, power_unit=np.where(HALF, "W", "kW"))
    found = take(write(tmp_path, csv(frame)), tmp_path / "out", input="power", full_scale=510.0)
    assert read_run(found.runs[0]).pwm.tolist() == np.where(HALF, 75, 175).tolist()
    assert f"{int((~HALF).sum())} x number in another unit, made W (line 3, column power)" in counted(found)


def test_a_column_of_units_behind_the_time_is_not_of_the_time(tmp_path: Path) -> None:
    frame = TRUE.rename(columns={"time_s": "time"}).drop(columns=["winding_degC", "casing_degC", "ambient_degC"])
    frame.insert(1, "unit", "F")
    for part in ("winding", "casing"):
        frame[part] = (TRUE[f"{part}_degC"] * 1.8 + 32.0).round(2)
    run = taken(write(tmp_path, csv(frame)), tmp_path / "out", units={"pwm": "counts", "time": "s"})
    same(run, TRUE[["time_s", "pwm", "winding_degC", "casing_degC"]])
