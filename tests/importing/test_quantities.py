"""Which columns are temperatures, and which only stand near one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from gen.runs import Run
from tests.importing.logs import csv, take, taken, truth, write

ROWS = 60


def run_with(tmp_path: Path, head: str, values: list[float], **options: object) -> Run:
    """A log with a winding and one more column."""
    rows = "".join(f"{i},80.5,{20 + 0.3 * i:.1f},{values[i]:g}\n" for i in range(ROWS))
    log = write(tmp_path, f"time [s],duty [%],winding [°C],{head}\n{rows}")
    return taken(log, tmp_path / "out", **options)


def test_a_servo_s_pulse_is_not_0_at_rest(tmp_path: Path) -> None:
    log = write(
        tmp_path, "time [s],esc,winding [°C]\n" + "".join(f"{i},{1000 + 10 * i},2{i % 10}.5\n" for i in range(60))
    )
    with pytest.raises(InputError, match=r"found 1000\.\.1590; .* if these are a servo's pulses in us, --rest 1000"):
        take(log, tmp_path / "out", input="esc")


RISING = [15.0 + 0.2 * i for i in range(ROWS)]


@pytest.mark.parametrize(
    "head",
    [
        "motor_torque",
        "motor_position",
        "current_motor_setup",
        "motor speed setup",
        "Core 0 Clock [MHz]",
        "rotor flux",
        "bearing vibration",
        "T1 fault code",
        "Distance to TjMAX [°C]",
        "temperature error",
        "dT [°C]",
        "Core_load_x [x]",
    ],
)
def test_another_quantity_of_a_part_is_no_temperature(tmp_path: Path, head: str) -> None:
    run = run_with(tmp_path, head, RISING)
    assert list(run.temps) == ["winding"]
    np.testing.assert_allclose(next(iter(run.extras.values())), RISING)


@pytest.mark.parametrize(
    ("head", "part"),
    [
        ("stator end 2", "stator_end_2"),
        ("Current Temperature", "current"),
        ("present_temperature", "present"),
        ("bearing DE", "bearing_de"),
        ("Core Temperatures (avg) [°C]", "core_avg"),
        ("TC3", "TC3"),
    ],
)
def test_a_part_or_a_temperature_by_its_name_is_one(tmp_path: Path, head: str, part: str) -> None:
    assert part in run_with(tmp_path, head, RISING).temps


def test_a_part_with_a_word_that_nobody_knows_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"rotor quux: .*nothing says that it is a temperature; settle it by --unit"):
        run_with(tmp_path, "rotor quux", RISING)
    assert "rotor_quux" in run_with(tmp_path, "rotor quux", RISING, units={"rotor quux": "degC"}).temps


def test_a_flag_is_no_temperature(tmp_path: Path) -> None:
    run = run_with(tmp_path, "Thermocouple open", [0.0] * ROWS)
    assert list(run.temps) == ["winding"]
    assert list(run_with(tmp_path, "rotor quux", [float(i % 2) for i in range(ROWS)], overwrite=True).temps) == [
        "winding"
    ]


def test_a_sensor_that_reads_nothing_but_0_is_none(tmp_path: Path) -> None:
    run = run_with(tmp_path, "temp_mos_2", [0.0] * ROWS)
    assert list(run.temps) == ["winding"]
    assert "temp_mos_2" in run.extras


def test_without_names_the_message_says_which_column_may_be_what(tmp_path: Path) -> None:
    rows = "".join(f"  1.0   30.0   {20 + 0.3 * i:.1f}   {1412400132197 + 1000 * i}.0\n" for i in range(ROWS))
    log = write(tmp_path, rows, name="log.txt")
    with pytest.raises(
        InputError, match=r"among column_1 \(1\), column_2 \(30\), column_3 \(20\.\.37\.7\); expected --inp"
    ):
        take(log, tmp_path / "out")
    with pytest.raises(InputError, match=r"such as --column column_3=winding_degC \(20\.\.37\.7\)$"):
        take(log, tmp_path / "out", input="column_2", full_scale=100.0)
    run = taken(log, tmp_path / "out", input="column_2", full_scale=100.0, columns={"column_3": "plate_degC"})
    assert run.time_s[-1] == ROWS - 1


def test_a_number_of_the_row_is_proposed_for_no_part(tmp_path: Path) -> None:
    rows = "".join(f"2020-05-03 14:00:{i:02d} UTC,{i + 1},{20 + 0.3 * i:.1f}\n" for i in range(ROWS))
    log = write(tmp_path, f"created_at,entry_id,field1\n{rows}")
    with pytest.raises(InputError, match=r"NAME_degC, such as --column field1=winding_degC \(20\.\.37\.7\)$"):
        take(log, tmp_path / "out", input="0")


@pytest.mark.parametrize(("highest", "scale"), [(255, "255"), (1023, "1023"), (254, "500; .* next round number.*")])
def test_counts_of_a_timer_propose_their_own_full_scale(tmp_path: Path, highest: int, scale: str) -> None:
    rows = "".join(f"{i},{20 + 0.3 * i:.1f},93,{highest if i > 5 else 0}\n" for i in range(ROWS))
    log = write(tmp_path, f"time,temperature,setpoint,output\n{rows}")
    with pytest.raises(InputError, match=rf"such as --input output --full-scale {scale}$"):
        take(log, tmp_path / "out")


def hobo(label: str) -> str:
    return f"LGR S/N: 10234567, SEN S/N: 10234567{label}"


def test_a_unit_before_brackets_that_name_the_sensor_is_read_with_its_label(tmp_path: Path) -> None:
    """As HOBO loggers write."""
    heads = [f'"Temp, °F ({hobo(f", LBL: {name}")})"' for name in ("Winding", "Casing", "Room")]
    begin = '"Plot Title: bench"\n"#","Date Time, GMT-05:00"'
    duty = f'"Percent, % ({hobo(", LBL: PWM")})"'
    rows = "".join(
        f"{i + 1},03/25/24 09:{i // 60:02d}:{i % 60:02d} AM,{68 + 0.9 * i:.1f},{68 + 0.18 * i:.2f},68.0,60\n"
        for i in range(ROWS)
    )
    run = taken(write(tmp_path, f"{begin},{','.join(heads)},{duty}\n{rows}"), tmp_path / "out")
    np.testing.assert_allclose(run.temps["winding"], 20 + 0.5 * np.arange(ROWS), atol=1e-9)
    np.testing.assert_allclose(run.temps["casing"], 20 + 0.1 * np.arange(ROWS), atol=1e-9)
    assert set(run.temps) == {"winding", "casing"}
    assert run.ambient is not None
    np.testing.assert_allclose(run.ambient, 20.0)
    assert set(run.pwm.tolist()) == {153}


def test_sensors_without_a_label_keep_their_numbers_apart(tmp_path: Path) -> None:
    run = run_with(tmp_path, '"Temp, °C (SEN S/N: 12)"', RISING)
    assert set(run.temps) == {"winding", "temp_12"}


@pytest.mark.parametrize(
    "head", ["winding_max_C", "bearing limit [°C]", "T_alarm_degC", "motor trip temp", "casing Grenzwert [°C]"]
)
def test_a_limit_is_no_temperature_of_a_part(head: str, tmp_path: Path) -> None:
    """The same in all rows: what moves is one, whatever it is called."""
    assert list(run_with(tmp_path, head, [95.0] * ROWS).temps) == ["winding"]
    (tmp_path / "moves").mkdir()
    if head != "bearing limit [°C]":
        assert len(run_with(tmp_path / "moves", head, [20.0 + 0.2 * i for i in range(ROWS)]).temps) == 2


def test_what_stands_still_and_is_called_no_limit_is_a_part(tmp_path: Path) -> None:
    assert list(run_with(tmp_path, "casing [°C]", [21.0] * ROWS).temps) == ["winding", "casing"]
    (tmp_path / "told").mkdir()
    run = run_with(tmp_path / "told", "winding_max_C", [95.0] * ROWS, columns={"winding_max_C": "hot_degC"})
    assert list(run.temps) == ["winding", "hot"]


@pytest.mark.parametrize(
    "head", ["/motor/state/casing_temperature", "°C [1-2] casing", "casing(@C)", "drive.status.casingTemp"]
)
def test_a_part_behind_a_path_or_a_unit(head: str, tmp_path: Path) -> None:
    assert len(run_with(tmp_path, head, [20.0 + 0.2 * (i % 40) for i in range(ROWS)]).temps) == 2


def test_an_input_that_rests_at_its_lower_end_is_told(tmp_path: Path) -> None:
    """As a transmitter's stick is logged; one that reverses passes 0."""
    rows = [f"{10 * i},{-1024 if i > 30 else 512},{20 + 0.3 * i:.1f}" for i in range(ROWS)]
    log = write(tmp_path, "\n".join(["time [s],Thr,winding [°C]", *rows]))
    found = take(log, tmp_path / "out", input="Thr", full_scale=1024.0)
    assert any("Thr: stands at -1024 and never near 0, as a stick's way does" in text for text in found.warnings)
    rows = [f"{10 * i},{(-1024, 0, 1024)[i // 20]},{20 + 0.3 * i:.1f}" for i in range(ROWS)]
    log = write(tmp_path, "\n".join(["time [s],Thr,winding [°C]", *rows]))
    assert take(log, tmp_path / "new", input="Thr", full_scale=1024.0).warnings == []


@pytest.mark.parametrize("head", ["R_winding", "I winding", "U_winding", "M_motor", "B_magnet"])
def test_a_letter_before_a_part_is_asked_for(head: str, tmp_path: Path) -> None:
    """A resistance, a current, a torque, a flux density, or a phase's temperature."""
    values = [1.3 + 0.01 * (i % 40) for i in range(ROWS)]
    with pytest.raises(
        InputError, match=f"doubtful: {head}: .* named after a part, .* or --column '?{head}='? to leave"
    ):
        run_with(tmp_path, head, values)
    assert list(run_with(tmp_path, head, values, columns={head: ""}).temps) == ["winding"]


def test_what_a_motor_does_is_no_temperature(tmp_path: Path) -> None:
    assert list(run_with(tmp_path, "motor", [float(i // 20 % 2) for i in range(ROWS)]).temps) == ["winding"]
    (tmp_path / "states").mkdir()
    assert list(run_with(tmp_path / "states", "stator", [float(i // 10 % 4) for i in range(ROWS)]).temps) == ["winding"]
    (tmp_path / "cold").mkdir()
    assert len(run_with(tmp_path / "cold", "stator", [2.0 + i // 5 for i in range(ROWS)]).temps) == 2


def test_a_name_in_brackets_is_a_part(tmp_path: Path) -> None:
    assert (
        list(run_with(tmp_path, "CH0(Casing)", [20.0 + 0.2 * (i % 40) for i in range(ROWS)]).temps)[1] == "ch0_casing"
    )


def test_the_largest_of_several_readings_is_no_limit(tmp_path: Path) -> None:
    """Of a controller whose transistors stay as they are: it lies among the readings."""
    assert "mos_max" in run_with(tmp_path, "temp_mos_max", [30.2] * ROWS).temps


@pytest.mark.parametrize(("head", "option"), [("heater", "heater"), ("power_W", "power_W --full-scale 100")])
def test_a_fan_s_duty_beside_what_heats_is_asked_for(head: str, option: str, tmp_path: Path) -> None:
    frame = truth()
    heats = np.where(frame.pwm > 0, "ON", "OFF") if head == "heater" else np.where(frame.pwm > 0, 80.5, 0.0)
    frame = frame.rename(columns={"pwm": "fan_pwm"})
    path = write(tmp_path, csv(frame.assign(**{head: heats})))
    with pytest.raises(InputError, match=f"fan_pwm: .* expected --input {option} or --input fan_pwm$"):
        take(path, tmp_path / "out")
    run = taken(path, tmp_path / "fan", input="fan_pwm")
    np.testing.assert_allclose(run.pwm, truth().pwm)
    np.testing.assert_allclose(taken(write(tmp_path, csv(frame)), tmp_path / "alone").pwm, truth().pwm)
