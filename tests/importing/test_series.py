"""Logs with a row for each reading: of home automation, of databases of time series."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import take, write

ROWS = 60
TEMPERATURE = 21.0 + 0.25 * np.arange(ROWS)
POWER = np.where(np.arange(ROWS) % 20 < 10, 2000.0, 0.0)


def times(offset_ms: int = 0) -> list[str]:
    begin = np.datetime64("2024-01-05T08:00:00.000")
    return [f"{begin + np.timedelta64(30_000 * i + offset_ms, 'ms')}Z" for i in range(ROWS)]


def history(late_ms: int = 0) -> str:
    """First all of one sensor, then all of the other, which is read `late_ms` later."""
    lines = ["entity_id,state,last_changed"]
    lines += [f"sensor.boiler_temperature,{t:.2f},{at}" for t, at in zip(TEMPERATURE, times(late_ms), strict=True)]
    lines += [f"sensor.heater_power,{p:.0f},{at}" for p, at in zip(POWER, times(), strict=True)]
    lines[20] = lines[20].replace(f"{TEMPERATURE[19]:.2f}", "unavailable")
    return "\n".join(lines)


def test_each_name_becomes_a_column(tmp_path: Path) -> None:
    log = write(tmp_path, history())
    with pytest.raises(InputError, match=r"has a row for each of .*; expected --series entity_id, which gives each"):
        take(log, tmp_path / "out")
    with pytest.raises(
        InputError, match=r"expected what drives it, such as --input sensor\.heater_power --full-scale 20"
    ):
        take(log, tmp_path / "out", series="entity_id")
    mapping = tmp_path / "map.toml"
    found = take(
        log, tmp_path / "out", series="entity_id", input="sensor.heater_power", full_scale=2000.0, mapping=mapping
    )
    run = read_run(found.runs[0])
    np.testing.assert_allclose(run.time_s, 30.0 * np.arange(ROWS))
    np.testing.assert_allclose(run.pwm, POWER / 2000.0 * 255.0)
    expected = TEMPERATURE.copy()
    expected[19] = np.nan
    np.testing.assert_allclose(run.temps["boiler"], expected)
    again = take(log, tmp_path / "again", mapping=mapping)
    assert again.runs[0].read_bytes() == found.runs[0].read_bytes()


def test_sensors_that_are_read_at_other_times_share_the_rows(tmp_path: Path) -> None:
    log = write(tmp_path, history(late_ms=7000))
    found = take(log, tmp_path / "out", series="entity_id", input="sensor.heater_power", full_scale=2000.0)
    run = read_run(found.runs[0])
    assert run.time_s.size == 2 * ROWS
    np.testing.assert_allclose(run.pwm[1::2], run.pwm[::2])  # held from the row before
    known = run.temps["boiler"]
    assert np.isnan(known[::2]).all()
    assert np.isfinite(known[1::2]).sum() == ROWS - 1


def test_the_column_of_values_may_be_said(tmp_path: Path) -> None:
    frame = pd.read_csv(write(tmp_path, history())).rename(columns={"state": "measured", "entity_id": "name"})
    log = tmp_path / "long.csv"
    frame.assign(quality=np.arange(len(frame)) % 7).to_csv(log, index=False)
    said = {"input": "sensor.heater_power", "full_scale": 2000.0}
    with pytest.raises(
        InputError, match="--series: which column holds the values nobody knows; expected --series name,C"
    ):
        take(log, tmp_path / "out", series="name", **said)
    assert read_run(take(log, tmp_path / "out", series="name,measured", **said).runs[0]).time_s.size == ROWS
    with pytest.raises(
        InputError, match='--series: found "nam", expected one of the columns name, measured, last_changed, quality'
    ):
        take(log, tmp_path / "more", series="nam", **said)


def test_a_second_reading_of_one_name_and_time_is_counted(tmp_path: Path) -> None:
    text = history() + f"\nsensor.boiler_temperature,99.00,{times()[5]}"
    log = write(tmp_path, text)
    found = take(log, tmp_path / "out", series="entity_id", input="sensor.heater_power", full_scale=2000.0)
    assert found.counted()["count"]["second reading of one name and time, left out"] == 1
    assert read_run(found.runs[0]).temps["boiler"][5] == TEMPERATURE[5]


DUTY = np.where(np.arange(ROWS) < 40, 60, 0)


def readings() -> list[tuple[int, str, str, str]]:
    """Second, name, unit and value of three sensors that are read one after the other."""
    rows = []
    for i in range(ROWS):
        rows.append((10 * i, "duty", "%", f"{DUTY[i]}"))
        rows.append((10 * i + 3, "winding", "°C", f"{TEMPERATURE[i]:.2f}"))
        rows.append((10 * i + 5, "ambient", "°F", "68.0"))
    return rows


def long_csv(head: str, row: str) -> str:
    """A row for each reading; in `row` stand s, at (a timestamp), name, unit and value."""
    begin = pd.Timestamp("2026-11-26 10:00:00")
    return f"{head}\n" + "".join(
        row.format(s=s, at=(begin + pd.Timedelta(seconds=s)).isoformat(), name=name, unit=unit, value=value) + "\n"
        for s, name, unit, value in readings()
    )


LONG = {
    "tidy": ("time,sensor,value", "{s},{name},{value}", "sensor"),
    "panel": ("Series;Time;Value", "{name};{at};{value}", "Series"),
    "archive": ("VarName;TimeString;VarValue;Validity", "{name};{at};{value};1", "VarName"),
    "names that nobody knows": ("t [s],what,how much", "{s},{name},{value}", "what,how much"),
    "operator and device beside it": (
        "time,operator,device,what,reading",
        "{at},Jo,m1,{name},{value}",
        "what",
    ),
    "broker": ("", '{{"ts":{s},"topic":"{name}","payload":{value},"qos":0}}', "topic"),
    "subscriber": ("", "{s} {name} {value}", "column_2,column_3"),
}


@pytest.mark.parametrize("case", LONG)
def test_the_message_says_which_option_takes_it(case: str, tmp_path: Path) -> None:
    """And the option that it says is all that is needed."""
    head, row, series = LONG[case]
    log = write(tmp_path, long_csv(head, row).lstrip("\n"), name="long.txt")
    with pytest.raises(InputError, match=f"a row for each of ambient, duty, winding; expected --series '?{series}'?,"):
        take(log, tmp_path / "out")
    units = {"duty": "percent", "ambient": "degF"}
    run = read_run(take(log, tmp_path / "out", series=series, units=units).runs[0])
    known = run.temps["winding"]
    np.testing.assert_allclose(known[np.isfinite(known)], TEMPERATURE)
    np.testing.assert_allclose(run.time_s[np.isfinite(known)] - run.time_s[0], 10 * np.arange(ROWS) + 3)
    assert run.ambient is not None
    np.testing.assert_allclose(run.ambient[np.isfinite(run.ambient)], 20.0)
    assert sorted(set(run.pwm.tolist())) == [0, 153]


def test_each_readings_unit_is_taken(tmp_path: Path) -> None:
    """Of a row only the time and the value are numbers."""
    log = write(tmp_path, long_csv("timestamp,device,sensor,unit,value", "{at},m1,{name},{unit},{value}"))
    run = read_run(take(log, tmp_path / "out", series="sensor").runs[0])
    assert run.ambient is not None
    np.testing.assert_allclose(run.ambient[np.isfinite(run.ambient)], 20.0)
    assert sorted(set(run.pwm.tolist())) == [0, 153]


def test_names_of_two_columns_tell_readings_apart(tmp_path: Path) -> None:
    """Of one sensor several quantities: none is lost, nor is the first row, which has more words than numbers."""
    rows = []
    for i in range(ROWS):
        at = (pd.Timestamp("2026-11-26 10:00:00") + pd.Timedelta(seconds=10 * i)).isoformat()
        rows.append(f"{at},winding,temperature,{TEMPERATURE[i] * 1.8 + 32:.3f},degF")
        rows.append(f"{at},motor,temperature,{30 + i / 10:.1f},degC")
        rows.append(f"{at},motor,current,{DUTY[i] / 10:.1f},A")
        rows.append(f"{at},motor,duty,{DUTY[i]},%")
    log = write(tmp_path, "\n".join(["time,sensor,quantity,value,unit", *rows]))
    with pytest.raises(InputError, match="expected --series sensor,"):
        take(log, tmp_path / "out")
    run = read_run(take(log, tmp_path / "out", series="sensor").runs[0])
    np.testing.assert_allclose(run.temps["winding"], TEMPERATURE, atol=1e-3)
    np.testing.assert_allclose(run.temps["motor"], 30 + np.arange(ROWS) / 10)
    np.testing.assert_allclose(run.extras["current_A"], DUTY / 10)


def test_sensors_that_are_numbered_and_an_input_beside_all_of_them(tmp_path: Path) -> None:
    """Their mean, which rows of one time may have, would be that of different sensors."""
    rows = [f"{10 * i},{k},{TEMPERATURE[i] + k:.2f},{DUTY[i]}" for i in range(ROWS) for k in (1, 2, 3)]
    log = write(tmp_path, "\n".join(["t [s],sensor_id,temperature,duty [%]", *rows]))
    with pytest.raises(InputError, match="a row for each of 1, 2, 3; expected --series sensor_id,temperature,"):
        take(log, tmp_path / "out")
    run = read_run(take(log, tmp_path / "out", series="sensor_id,temperature").runs[0])
    assert list(run.temps) == ["temperature_1", "temperature_2", "temperature_3"]
    np.testing.assert_allclose(run.temps["temperature_3"], np.round(TEMPERATURE + 3, 2))
    assert sorted(set(run.pwm.tolist())) == [0, 153]


def test_a_coarse_clock_tells_no_names_apart(tmp_path: Path) -> None:
    """Two readings a second of each sensor, and a remark that changes now and then."""
    lines = [f"{i // 4},{('winding', 'duty')[i % 2]},{20 + i % 7},{'ab'[i % 8 > 4]}" for i in range(400)]
    log = write(tmp_path, "\n".join(["t [s],sensor,value,note", *lines]))
    found = take(log, tmp_path / "out", series="sensor", input="duty", full_scale=100.0)
    assert found.counted()["count"]["second reading of one name and time, left out"] == 200


def test_annotated_tables_with_other_columns(tmp_path: Path) -> None:
    """A tag that only some have makes another header: none of the tables is lost."""
    begin, end = "2026-11-26T09:00:00Z", "2026-11-26T12:00:00Z"

    def table(k: int, field: str, values: np.ndarray, tag: str) -> str:
        more = ",true" if tag else ""
        head = f"#group,false,false,true,true,false,false,true{more}\n#datatype,string,long,a,b,c,double,string{more}\n"
        head += f",result,table,_start,_stop,_time,_value,_field{',sensor' if tag else ''}\n"
        rows = (
            f",,{k},{begin},{end},2026-11-26T10:{i:02d}:00Z,{values[i]},{field}{f',{tag}' if tag else ''}\n"
            for i in range(ROWS)
        )
        return head + "".join(rows)

    tables = [
        table(0, "temperature", TEMPERATURE, "winding"),
        table(1, "temperature", 0.5 * TEMPERATURE + 10, "casing"),
        table(2, "duty", DUTY, ""),
    ]
    log = write(tmp_path, "\n".join(tables))
    run = read_run(take(log, tmp_path / "out", series="_field", units={"duty": "percent"}).runs[0])
    np.testing.assert_allclose(run.time_s, 60.0 * np.arange(ROWS))
    np.testing.assert_allclose(run.temps["winding"], TEMPERATURE)
    np.testing.assert_allclose(run.temps["casing"], 0.5 * TEMPERATURE + 10)


def test_a_phase_of_the_test_is_no_name_of_a_reading(tmp_path: Path) -> None:
    frame = pd.DataFrame({"t [s]": 10 * np.arange(ROWS), "phase": np.where(DUTY > 0, "run", "rest"), "PWM [%]": 60})
    log = tmp_path / "log.csv"
    frame.assign(winding_degC=TEMPERATURE).to_csv(log, index=False)
    assert list(read_run(take(log, tmp_path / "out").runs[0]).temps) == ["winding"]


def test_of_several_timestamps_the_one_that_goes_on_is_the_time(tmp_path: Path) -> None:
    """As a time series database writes, with annotations and a table for each field."""
    head = "#group,false,false,true,true,false,false,true\n#default,_result,,,,,,\n"
    head += ",result,table,_start,_stop,_time,_value,_field\n"
    begin, end = "2026-11-26T09:00:00Z", "2026-11-26T12:00:00Z"
    tables = [
        "".join(f",,{k},{begin},{end},2026-11-26T10:{i:02d}:00Z,{values[i]},{name}\n" for i in range(ROWS))
        for k, (name, values) in enumerate({"winding": TEMPERATURE, "duty": DUTY}.items())
    ]
    log = write(tmp_path, "\n".join(head + table for table in tables))
    run = read_run(take(log, tmp_path / "out", series="_field").runs[0])
    np.testing.assert_allclose(run.time_s, 60.0 * np.arange(ROWS))
    np.testing.assert_allclose(run.temps["winding"], TEMPERATURE)


def test_a_time_in_ms_that_is_none_by_the_timestamps_beside_it_is_not_taken(tmp_path: Path) -> None:
    """WinCC's `Time_ms` counts millionths of days since 1900."""
    days = (pd.Timestamp("2026-11-26 10:00:00") - pd.Timestamp("1899-12-30")) / pd.Timedelta(days=1)
    seconds = 10 * np.arange(ROWS)
    stamps = pd.Timestamp("2026-11-26 10:00:00") + pd.to_timedelta(seconds, unit="s")
    frame = pd.DataFrame({"TimeString": stamps.strftime("%d.%m.%Y %H:%M:%S"), "PWM [%]": DUTY, "T1 [°C]": TEMPERATURE})
    log, true = tmp_path / "log.csv", tmp_path / "true.csv"
    frame.assign(Time_ms=(days + seconds / 86_400) * 1e6).to_csv(log, index=False)
    np.testing.assert_allclose(read_run(take(log, tmp_path / "out").runs[0]).time_s, seconds)
    frame.assign(Time_ms=1000 * seconds + 250).to_csv(true, index=False)
    np.testing.assert_allclose(read_run(take(true, tmp_path / "true").runs[0]).time_s, seconds + 0.25)


@pytest.mark.parametrize("states", [("ON", "OFF"), ("A", "B")])
def test_states_that_change_from_row_to_row_are_no_names_of_readings(states: tuple[str, str], tmp_path: Path) -> None:
    """Those that nobody knows are asked for, and may be left out."""
    frame = pd.DataFrame({"t [s]": 10 * np.arange(ROWS), "relay": [states[i % 2] for i in range(ROWS)], "PWM [%]": 60})
    log = tmp_path / "log.csv"
    frame.assign(winding_degC=TEMPERATURE + np.cos(np.arange(ROWS))).to_csv(log, index=False)
    if states == ("A", "B"):
        with pytest.raises(InputError, match=r"expected --series relay,winding_degC, .*, or --column relay= where it"):
            take(log, tmp_path / "out")
    columns = {} if states == ("ON", "OFF") else {"relay": ""}
    assert list(read_run(take(log, tmp_path / "out", columns=columns).runs[0]).temps) == ["winding"]


def test_a_switch_is_1_or_0(tmp_path: Path) -> None:
    """Of home automation; where it says nothing, what it said before is held."""
    lines = [f"sensor.motor_temperature,{t:.2f},{at}" for t, at in zip(TEMPERATURE, times(7000), strict=True)]
    states = ["on" if i < 40 else "off" for i in range(ROWS)]
    states[7] = "unavailable"
    lines += [f"switch.motor,{state},{at}" for state, at in zip(states, times(), strict=True)]
    log = write(tmp_path, "\n".join(["entity_id,state,last_changed", *lines]))
    with pytest.raises(InputError, match=r"among sensor\.motor_temperature \(.*\), switch\.motor \(0\.\.1\); expected"):
        take(log, tmp_path / "out", series="entity_id")
    found = take(log, tmp_path / "out", series="entity_id", input="switch.motor", full_scale=1.0)
    assert found.counted()["count"]["on or off of switch.motor, taken for 1 or 0"] == ROWS - 1
    assert read_run(found.runs[0]).pwm.tolist() == [255] * 80 + [0] * 40


def test_a_sensor_whose_unit_changes_is_read_in_each(tmp_path: Path) -> None:
    """Somebody set it to another scale on the way: each row says its own, in the words of its logger."""
    lines = ["time,sensor,value,unit"]
    for i, at in enumerate(times()):
        told = (f"{TEMPERATURE[i]:.2f},C", f"{TEMPERATURE[i] * 1.8 + 32:.2f},F", "unavailable,F")
        lines.append(f"{at},winding,{told[0 if i < 40 else 2 if i == 50 else 1]}")
        lines.append(f"{at},duty,{DUTY[i]},%")
    found = take(write(tmp_path, "\n".join(lines)), tmp_path / "out", series="sensor")
    run = read_run(found.runs[0])
    np.testing.assert_allclose(run.temps["winding"], np.where(np.arange(ROWS) == 50, np.nan, TEMPERATURE), atol=1e-9)
    np.testing.assert_array_equal(run.pwm, np.round(DUTY * 2.55))
    assert found.counted()["count"]["number in another unit, made degC"] == 19
