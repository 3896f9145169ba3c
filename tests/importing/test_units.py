"""Units by name and by range, what drives the motor, and values that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.importing.units import unit_of
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write

TEMPERATURES = ["winding_degC", "casing_degC", "ambient_degC"]


def fahrenheit(frame: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    return frame.assign(**{name: np.round(frame[name] * 1.8 + 32, 6) for name in names})


def test_fahrenheit_by_the_name(tmp_path: Path) -> None:
    frame = fahrenheit(TRUE, TEMPERATURES).rename(columns=lambda name: name.replace("degC", "degF"))
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), TRUE)


def test_fahrenheit_under_a_name_of_celsius_is_said_and_can_be_corrected(tmp_path: Path) -> None:
    path = write(tmp_path, csv(fahrenheit(TRUE, TEMPERATURES)))
    found = take(path, tmp_path / "runs")
    for name in TEMPERATURES:
        assert any(f"--unit {name}=degF" in warning for warning in found.warnings)
    again = take(path, tmp_path / "again", units=dict.fromkeys(TEMPERATURES, "degF"))
    same(read_run(again.runs[0]), TRUE)
    assert again.warnings == []


def test_one_sensor_in_fahrenheit_among_others_is_said(tmp_path: Path) -> None:
    found = take(write(tmp_path, csv(fahrenheit(TRUE, ["winding_degC"]))), tmp_path / "runs")
    assert [warning for warning in found.warnings if "winding_degC" in warning and "degF" in warning] == found.warnings
    assert len(found.warnings) == 1


def test_a_warm_start_in_celsius_is_not_called_fahrenheit(tmp_path: Path) -> None:
    frame = TRUE.assign(winding_degC=TRUE.winding_degC + 55, casing_degC=TRUE.casing_degC + 25)
    assert take(write(tmp_path, csv(frame)), tmp_path / "runs").warnings == []


def test_a_sensor_read_at_half_is_said_and_can_be_corrected(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(casing_degC=TRUE.casing_degC / 2)))
    found = take(path, tmp_path / "runs")
    assert len(found.warnings) == 1
    assert "half" in found.warnings[0]
    assert "--unit casing_degC=2degC" in found.warnings[0]
    same(taken(path, tmp_path / "again", units={"casing_degC": "2degC"}), TRUE)


def test_kelvin_by_name_and_by_range(tmp_path: Path) -> None:
    kelvin = TRUE.assign(**{name: np.round(TRUE[name] + 273.15, 6) for name in TEMPERATURES})
    named = kelvin.rename(columns=lambda name: name.replace("degC", "K"))
    same(taken(write(tmp_path, csv(named)), tmp_path / "a"), TRUE)
    bare = kelvin.rename(columns=lambda name: name.replace("_degC", " temp"))
    same(taken(write(tmp_path, csv(bare)), tmp_path / "b"), TRUE)


def test_a_temperature_of_no_unit_that_may_be_fahrenheit_is_refused(tmp_path: Path) -> None:
    frame = fahrenheit(TRUE, TEMPERATURES).rename(columns=lambda name: name.replace("_degC", " temp"))
    path = write(tmp_path, csv(frame))
    with pytest.raises(InputError, match="settle it by --unit 'winding temp=degC' or =degF or =K"):
        take(path, tmp_path / "runs")
    assert not (tmp_path / "runs").exists()
    units = {name.replace("_degC", " temp"): "degF" for name in TEMPERATURES}
    same(taken(path, tmp_path / "runs", units=units), TRUE)


@pytest.mark.parametrize(
    ("name", "full"), [("pwm_percent", 100), ("PWM (%)", 100), ("Duty [%]", 100), ("duty", 1), ("Tastgrad / %", 100)]
)
def test_pwm_in_percent_or_as_a_share(name: str, full: float, tmp_path: Path) -> None:
    frame = TRUE.assign(pwm=TRUE.pwm / 255 * full).rename(columns={"pwm": name})
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), TRUE)


def test_whole_numbers_up_to_a_hundred_may_be_percent_and_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(pwm=np.where(TRUE.pwm, 80, 0)).rename(columns={"time_s": "t [s]"})))
    with pytest.raises(InputError, match=r"pwm: .* counts of 255 or percent; settle it by --unit pwm=percent"):
        take(path, tmp_path / "runs")
    same(taken(path, tmp_path / "a", units={"pwm": "percent"}), TRUE)
    same(taken(path, tmp_path / "b", units={"pwm": "counts"}), TRUE.assign(pwm=np.where(TRUE.pwm, 80, 0)))


@pytest.mark.parametrize("name", ["pwm_percent", "PWM (%)", "Duty cycle %"])
def test_percent_that_may_be_a_share_of_1_is_refused(name: str, tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(pwm=np.where(TRUE.pwm, 0.6, 0.0)).rename(columns={"pwm": name})))
    with pytest.raises(
        InputError, match=r"in percent by its name, but 0\.\.0\.6, as a share of 1; settle it by --unit"
    ):
        take(path, tmp_path / "runs")
    same(taken(path, tmp_path / "a", units={name: "duty"}), TRUE.assign(pwm=np.where(TRUE.pwm, 153, 0)))
    same(taken(path, tmp_path / "b", units={name: "percent"}), TRUE.assign(pwm=np.where(TRUE.pwm, 2, 0)))


def test_percent_that_is_0_in_all_rows_asks_nothing(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(pwm=0).rename(columns={"pwm": "PWM [%]"})))
    assert set(taken(path, tmp_path / "runs").pwm.tolist()) == {0}


@pytest.mark.parametrize("low", [0, -100])
def test_a_run_file_s_own_pwm_up_to_exactly_a_hundred_is_asked_for(low: int, tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(pwm=np.where(TRUE.pwm, 100, low))))
    with pytest.raises(InputError, match=r"up to exactly 100: as likely percent .* by --unit pwm=percent, =counts"):
        take(path, tmp_path / "a")
    assert take(path, tmp_path / "b", units={"pwm": "counts"}).warnings == []
    assert set(taken(path, tmp_path / "c", units={"pwm": "percent"}).pwm.tolist()) == {255 * low // 100, 255}


@pytest.mark.parametrize("most", [99, 101])
def test_a_run_file_s_own_pwm_up_to_another_number_is_in_counts(most: int, tmp_path: Path) -> None:
    true = TRUE.assign(pwm=np.where(TRUE.pwm, most, 0))
    same(taken(write(tmp_path, csv(true)), tmp_path / "out"), true)


def test_a_run_file_that_says_what_its_counts_are_is_not_asked_again(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(pwm=np.where(TRUE.pwm, 100, 0))))
    first = take(path, tmp_path / "a", units={"pwm": "counts"}).runs[0]
    again = taken(first, tmp_path / "b")
    assert set(again.pwm.tolist()) == {0, 100}


def test_ten_bits_need_a_full_scale(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(pwm=np.where(TRUE.pwm, 1000, 0))))
    with pytest.raises(InputError, match="reaches 1000, more than 255 counts; settle it by --full-scale 1023"):
        take(path, tmp_path / "runs")
    run = taken(path, tmp_path / "runs", full_scale=1023.0)
    assert set(run.pwm.tolist()) == {0, round(1000 / 1023 * 255)}


def test_a_sign_in_a_column_of_its_own(tmp_path: Path) -> None:
    true = TRUE.assign(pwm=np.where(np.arange(120) % 40 < 20, -TRUE.pwm, TRUE.pwm))
    frame = true.assign(pwm=true.pwm.abs(), direction=np.where(true.pwm < 0, -1, 1))
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), true)


@pytest.mark.parametrize("value", [1023.75, -127.0, 2047.75, 32767.0, 65535.0, 999.9])
def test_overflows_are_left_empty_and_counted(value: float, tmp_path: Path) -> None:
    frame = TRUE.copy()
    frame.loc[[5, 6, 40], "casing_degC"] = value
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    frame.loc[[5, 6, 40], "casing_degC"] = np.nan
    same(read_run(found.runs[0]), frame)
    row = found.counted().iloc[0]
    assert (row["count"], row["first"]) == (3, "line 7, column casing_degC")


def test_a_power_on_value_alone_is_one_and_a_temperature_that_passes_it_is_none(tmp_path: Path) -> None:
    frame = TRUE.assign(winding_degC=np.round(np.linspace(20, 139, 120), 1))
    assert (frame.winding_degC == 85.0).any()
    frame.loc[0, "casing_degC"] = 85.0
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    frame.loc[0, "casing_degC"] = np.nan
    same(read_run(found.runs[0]), frame)
    assert found.counted()["count"].tolist() == [1]


def bare_log(tmp_path: Path, head: str, values: np.ndarray) -> Path:
    frame = TRUE[["time_s", "pwm", "winding_degC"]].assign(**{head: values})
    return write(tmp_path, csv(frame))


@pytest.mark.parametrize(
    ("head", "begin", "end", "value"),
    [
        ("casing_K", 295.0, 340.0, 327.67),  # 54.52 degC
        ("casing_degC", 20.0, 400.0, 327.67),
        ("casing_degC", 20.0, 1200.0, 999.0),
        ("casing_degF", 70.0, 190.0, 85.0),
        ("Speed [rpm]", 0.0, 40_000.0, 32_767.0),
        ("Torque [Nm]", 0.0, 700.0, 655.35),
    ],
)
def test_a_value_in_the_course_of_those_around_it_is_measured(
    head: str, begin: float, end: float, value: float, tmp_path: Path
) -> None:
    values = np.round(np.linspace(begin, end, len(TRUE)), 2)
    values[np.argmin(np.abs(values - value))] = value
    found = take(bare_log(tmp_path, head, values), tmp_path / "runs")
    assert found.counted().empty
    columns = read_run(found.runs[0]).columns()
    name = next(name for name in columns if name not in ("time_s", "pwm", "winding_degC"))
    assert np.isfinite(columns[name]).all()


@pytest.mark.parametrize(("head", "value"), [("casing_K", 655.35), ("casing_degF", -196.6), ("Torque [Nm]", 655.35)])
def test_an_overflow_of_another_unit_leaps_from_those_around_it(head: str, value: float, tmp_path: Path) -> None:
    values = np.round(np.linspace(295.0, 300.0, len(TRUE)) - (0 if head.endswith("_K") else 220), 2)
    values[[7, 8, 60]] = value
    found = take(bare_log(tmp_path, head, values), tmp_path / "runs")
    assert found.counted()["count"].tolist() == [3]


def test_another_unit_s_overflow_is_none(tmp_path: Path) -> None:
    """A DS18B20's number for "not connected" in degC is no number of a sensor in degF."""
    values = np.full(len(TRUE), -20.0)
    values[50] = -127.0
    found = take(bare_log(tmp_path, "casing_degF", values), tmp_path / "runs")
    assert found.counted().empty


def test_a_range_at_whose_end_values_stay_is_left_empty_though_they_come_near_it(tmp_path: Path) -> None:
    values = np.round(np.minimum(np.linspace(20.0, 340.0, len(TRUE)), 327.67), 2)
    stuck = int((values == 327.67).sum())
    assert stuck > 3
    found = take(bare_log(tmp_path, "casing_degC", values), tmp_path / "runs")
    assert found.counted()["count"].tolist() == [stuck]


def test_overflows_of_two_kinds_side_by_side_are_both_left_empty(tmp_path: Path) -> None:
    values = np.full(len(TRUE), 21.5)
    values[10:16] = [2047.75, 2048.0] * 3
    found = take(bare_log(tmp_path, "casing_degC", values), tmp_path / "runs")
    assert found.counted()["count"].tolist() == [3, 3]


def test_another_input_with_its_full_scale(tmp_path: Path) -> None:
    frame = TRUE.rename(columns={"pwm": "Power (W)"}).assign(**{"Power (W)": TRUE.pwm / 255 * 500.0})
    path = write(tmp_path, csv(frame))
    with pytest.raises(
        InputError, match=r"no column is a motor's PWM; expected .* --input 'Power \(W\)' --full-scale 500"
    ):
        take(path, tmp_path / "runs")
    with pytest.raises(InputError, match="expected --full-scale"):
        take(path, tmp_path / "runs", input="Power (W)")
    with pytest.raises(
        InputError, match=r"line 2, column Power .*more than the full scale of 300 W|more than its full"
    ):
        take(path, tmp_path / "runs", input="Power (W)", full_scale=300.0)
    run = taken(path, tmp_path / "runs", input="Power (W)", full_scale=500.0)
    same(run, TRUE)
    assert run.comments["input"] == "Power (W), 255 = 500 W"


def test_the_same_counts_in_all_rows_and_an_interval(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE[["winding_degC", "ambient_degC"]]))
    run = taken(path, tmp_path / "runs", input="153", time="0.5")
    same(run, TRUE[["time_s", "winding_degC", "ambient_degC"]])
    assert set(run.pwm.tolist()) == {153}


def test_further_channels_keep_their_names_and_known_units_are_converted(tmp_path: Path) -> None:
    frame = TRUE.copy()
    for name, value in (("Motor current (mA)", 1500.0), ("Drehzahl [1/min]", 2400.0), ("Torque (Nm)", 0.5)):
        frame[name] = value
    frame["note"] = "x"
    run = taken(write(tmp_path, csv(frame)), tmp_path / "runs")
    assert {name: values[0] for name, values in run.extras.items()} == {
        "current_A": 1.5,
        "speed_rpm": 2400.0,
        "Torque_Nm": 0.5,
    }


def test_what_one_of_each_unit_is() -> None:
    """By the definitions of the units, in the units that run files have."""
    turns = 60.0 / (2.0 * np.pi)
    one = {"s": 1, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60, "h": 3600, "d": 86400, "A": 1, "mA": 1e-3}
    one |= {"V": 1, "mV": 1e-3, "rpm": 1, "rps": 60, "rad/s": turns, "W": 1, "kW": 1e3, "percent": 1, "duty": 100}
    found = {name: unit_of(name) for name in one}
    assert {name: unit.scale for name, unit in found.items() if unit} == pytest.approx(one, rel=1e-12)
    assert all(unit is not None and unit.offset == 0.0 for unit in found.values())
    for name, freezing, boiling in (("degC", 0.0, 100.0), ("degF", 32.0, 212.0), ("K", 273.15, 373.15)):
        unit = unit_of(name)
        assert unit is not None
        assert freezing * unit.scale + unit.offset == pytest.approx(0.0, abs=1e-9)
        assert boiling * unit.scale + unit.offset == pytest.approx(100.0, abs=1e-9)


@pytest.mark.parametrize(
    ("unit", "parts"),
    [("0.1 °C", 10), ("0,1 °C", 10), ("1/10 °C", 10), ("°C/10", 10), ("m°C", 1000), ("mdegC", 1000), ("1/100 °C", 100)],
)
def test_parts_of_a_degree_in_a_header(unit: str, parts: int, tmp_path: Path) -> None:
    frame = TRUE.assign(winding_degC=np.round(TRUE.winding_degC * parts).astype(int))
    text = csv(frame.rename(columns={"winding_degC": f"Winding [{unit}]"}), sep=";")
    run = taken(write(tmp_path, text), tmp_path / "runs")
    np.testing.assert_allclose(run.temps["winding"], TRUE.winding_degC, atol=1e-9)


def test_tenths_of_a_degree_without_a_unit_are_asked_for(tmp_path: Path) -> None:
    frame = TRUE.assign(winding_degC=np.round(TRUE.winding_degC * 10).astype(int))
    path = write(tmp_path, csv(frame.rename(columns={"winding_degC": "T_winding"})))
    with pytest.raises(InputError, match=r"settle it by --unit T_winding=degC or =degF or =K or =0\.1degC"):
        take(path, tmp_path / "runs")
    run = taken(path, tmp_path / "runs", units={"T_winding": "0.1degC"})
    np.testing.assert_allclose(run.temps["winding"], TRUE.winding_degC, atol=1e-9)


@pytest.mark.parametrize("value", [1023, 1024, 4095])
def test_a_converters_end_among_temperatures_is_none(value: float, tmp_path: Path) -> None:
    frame = TRUE.astype({"winding_degC": float})
    frame.loc[[20, 21, 22, 50], "winding_degC"] = value
    run = taken(write(tmp_path, csv(frame)), tmp_path / "runs")
    assert np.flatnonzero(~np.isfinite(run.temps["winding"])).tolist() == [20, 21, 22, 50]


def test_an_oven_that_passes_1023_degrees_and_stays_there_is_believed(tmp_path: Path) -> None:
    kiln = np.minimum(np.round(20.0 + 12.0 * np.arange(len(TRUE))), 1023.0)
    run = taken(write(tmp_path, csv(TRUE.assign(winding_degC=kiln))), tmp_path / "runs")
    np.testing.assert_array_equal(run.temps["winding"], kiln)


@pytest.mark.parametrize(
    ("parts", "offered", "unit"),
    [
        (1000, "=0.001degC, or", "0.001degC"),
        (100, "=0.01degC or =0.1K, or", "0.01degC"),
        (10, "=0.1degC, or", "0.1degC"),
    ],
)
def test_whole_numbers_are_asked_for_with_the_part_of_a_degree_that_fits(
    parts: int, offered: str, unit: str, tmp_path: Path
) -> None:
    """Of a kernel, of converters, of controllers; 2945 may be tenths of K as well."""
    frame = TRUE.assign(winding=np.round((TRUE["winding_degC"] + 8.0) * parts).astype(int)).drop(columns="winding_degC")
    path = write(tmp_path, csv(frame))
    with pytest.raises(InputError, match=f"or =K or {offered}"):
        take(path, tmp_path / "out")
    run = taken(path, tmp_path / "out", units={"winding": unit})
    np.testing.assert_allclose(run.temps["winding"], TRUE["winding_degC"] + 8.0, atol=1e-9)
