"""One log, written as many loggers and people would: the same numbers come back."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest
from scipy.io import savemat

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import same, take, taken, truth

TRUE = truth()


def csv(frame: pd.DataFrame = TRUE, **options: object) -> str:
    return str(frame.to_csv(index=False, lineterminator="\n", **options))  # type: ignore[call-overload]


def write(tmp_path: Path, text: str, encoding: str = "utf-8", name: str = "log.csv") -> Path:
    path = tmp_path / name
    path.write_bytes(text.encode(encoding))
    return path


def test_a_run_file_comes_back_as_it_is(tmp_path: Path) -> None:
    path = write(tmp_path, "# motor: bench 3\n" + csv())
    run = taken(path, tmp_path / "runs")
    same(run, TRUE)
    assert run.comments["motor"] == "bench 3"
    assert run.comments["imported_from"] == "log.csv"


def test_a_byte_order_mark(tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv(), "utf-8-sig"), tmp_path / "runs"), TRUE)


@pytest.mark.parametrize("ends", ["\r\n", "\r", "\n\n"])
def test_line_ends(ends: str, tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv().replace("\n", ends)), tmp_path / "runs"), TRUE)


def test_other_names_of_columns(tmp_path: Path) -> None:
    heads = ["Elapsed (s)", "PWM [counts]", "Winding Temp (°C)", "T_casing [°C]", "Room (°C)"]
    same(taken(write(tmp_path, csv(TRUE.set_axis(heads, axis=1))), tmp_path / "runs"), TRUE)


def test_semicolons_and_decimal_commas(tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv(sep=";", decimal=",")), tmp_path / "runs"), TRUE)


def test_german_names_in_cp1252(tmp_path: Path) -> None:
    heads = ["Zeit [s]", "PWM", "Temperatur Wicklung [°C]", "Temperatur Gehäuse [°C]", "Umgebung [°C]"]
    path = write(tmp_path, csv(TRUE.set_axis(heads, axis=1), sep=";", decimal=","), "cp1252")
    names = {"winding_degC": "wicklung_degC", "casing_degC": "gehaeuse_degC"}
    same(taken(path, tmp_path / "runs"), TRUE, names)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_wide_encodings(encoding: str, tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv(sep="\t"), encoding), tmp_path / "runs"), TRUE)


@pytest.mark.parametrize(
    "form",
    [
        "%Y-%m-%dT%H:%M:%S.%f",
        "%Y-%m-%d %H:%M:%S.%fZ",
        "%Y-%m-%d %H:%M:%S,%f",
        "%d.%m.%Y %H:%M:%S.%f",
        "%m/%d/%Y %I:%M:%S.%f %p",
        "%d-%b-%Y %H:%M:%S.%f",
    ],
)
def test_timestamps(form: str, tmp_path: Path) -> None:
    begin = pd.Timestamp("2024-03-27 23:59:30")
    stamps = [(begin + pd.Timedelta(seconds=s)).strftime(form) for s in TRUE.time_s]
    run = taken(
        write(tmp_path, csv(TRUE.assign(time_s=stamps).rename(columns={"time_s": "Timestamp"}))), tmp_path / "r"
    )
    same(run, TRUE)
    assert run.comments["started"] == "2024-03-27T23:59:30.000"


def test_timestamps_with_a_zone_that_changes_with_summer_time(tmp_path: Path) -> None:
    begin = pd.Timestamp("2024-03-31 01:59:30", tz="Europe/Berlin")
    stamps = [(begin + pd.Timedelta(seconds=s)).isoformat() for s in TRUE.time_s]
    assert {stamp[-6:] for stamp in stamps} == {"+01:00", "+02:00"}
    same(taken(write(tmp_path, csv(TRUE.assign(time_s=stamps).rename(columns={"time_s": "ts"}))), tmp_path / "r"), TRUE)


@pytest.mark.parametrize(("factor", "name"), [(1, "epoch"), (1000, "timestamp"), (10**6, "time_us")])
def test_epochs(factor: int, name: str, tmp_path: Path) -> None:
    ticks = (TRUE.time_s * factor + 1_711_583_970 * factor).to_numpy()
    frame = TRUE.assign(time_s=ticks.astype(np.int64) if factor > 1 else ticks).rename(columns={"time_s": name})
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), TRUE)


def test_date_and_time_in_two_columns(tmp_path: Path) -> None:
    stamps = pd.Timestamp("2024-12-31 23:59:40") + pd.to_timedelta(TRUE.time_s, unit="s")
    frame = TRUE.drop(columns="time_s")
    frame.insert(0, "Date", stamps.dt.strftime("%d.%m.%Y"))
    frame.insert(1, "Time", stamps.dt.strftime("%H:%M:%S.%f"))
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), TRUE)


def test_a_time_of_day_that_passes_midnight(tmp_path: Path) -> None:
    stamps = pd.Timestamp("2024-12-31 23:59:40") + pd.to_timedelta(TRUE.time_s, unit="s")
    frame = TRUE.assign(time_s=stamps.dt.strftime("%H:%M:%S.%f")).rename(columns={"time_s": "Time"})
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    run = read_run(found.runs[0])
    np.testing.assert_allclose(np.diff(run.time_s), 0.5, atol=1e-6)
    assert found.counted().loc["midnight passed", "count"] == 1


@pytest.mark.parametrize(
    ("name", "unit", "factor"),
    [
        ("time_ms", "", 1000),
        ("millis", "", 1000),
        ("t [min]", "", 1 / 60),
        ("Time (h)", "", 1 / 3600),
        ("time", "ms", 1000),
    ],
)
def test_units_of_time(name: str, unit: str, factor: float, tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=TRUE.time_s * factor).rename(columns={"time_s": name})
    options = {"units": {name: unit}} if unit else {}
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs", **options), TRUE)


def test_milliseconds_without_a_unit_are_told_by_their_steps(tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=(TRUE.time_s * 1000).astype(int)).rename(columns={"time_s": "time"})
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), TRUE)


def test_duplicated_times_are_left_out_and_counted(tmp_path: Path) -> None:
    lines = csv().splitlines()
    lines[10:10] = [lines[9]]
    found = take(write(tmp_path, "\n".join(lines)), tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE)
    row = found.counted().loc["repeated time, the first row taken"]
    assert (row["count"], row["first"]) == (1, "line 11, column time_s")


def test_a_clock_of_whole_seconds_can_be_spread(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(time_s=np.floor(TRUE.time_s).astype(int))))
    with pytest.raises(InputError, match=r"60 of 120 rows repeat the time .* --duplicates spread"):
        take(path, tmp_path / "runs")
    assert not (tmp_path / "runs").exists()
    same(taken(path, tmp_path / "runs", duplicates="spread"), TRUE)


def test_backward_times_are_left_out_and_counted(tmp_path: Path) -> None:
    lines = csv().splitlines()
    late = lines.pop(20)
    lines.insert(24, late)
    found = take(write(tmp_path, "\n".join(lines)), tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE.drop(index=19))
    assert found.counted().loc["time before that of an earlier row, left out", "first"] == "line 25, column time_s"


def test_nan_words_and_text_are_missing_and_counted(tmp_path: Path) -> None:
    frame = TRUE.astype({"winding_degC": object})
    for row, word in ((3, "nan"), (4, "NaN"), (5, "--"), (6, "n/a"), (7, "ERR"), (8, "open circuit")):
        frame.loc[row, "winding_degC"] = word
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    true = TRUE.copy()
    true.loc[3:8, "winding_degC"] = np.nan
    same(read_run(found.runs[0]), true)
    counted = found.counted()
    assert counted.loc['word for "no number", left empty', "count"] == 4
    assert counted.loc["text in a number's field, left empty", "count"] == 2
    assert counted.loc["text in a number's field, left empty", "first"] == "line 9, column winding_degC"


def fahrenheit(frame: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    return frame.assign(**{name: np.round(frame[name] * 1.8 + 32, 6) for name in names})


TEMPERATURES = ["winding_degC", "casing_degC", "ambient_degC"]


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


def test_a_run_file_s_own_pwm_up_to_a_hundred_is_said(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE.assign(pwm=np.where(TRUE.pwm, 100, 0))))
    assert ["--unit pwm=percent" in warning for warning in take(path, tmp_path / "a").warnings] == [True]
    assert take(path, tmp_path / "b", units={"pwm": "counts"}).warnings == []
    assert set(taken(path, tmp_path / "c", units={"pwm": "percent"}).pwm.tolist()) == {0, 255}


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


def test_a_row_of_units_below_the_header(tmp_path: Path) -> None:
    heads = ["Time", "PWM", "Winding", "Casing", "Ambient"]
    lines = csv(TRUE.set_axis(heads, axis=1)).splitlines()
    lines.insert(1, "s,counts,°C,°C,°C")
    same(taken(write(tmp_path, "\n".join(lines)), tmp_path / "runs"), TRUE)


def test_a_preamble_and_comments(tmp_path: Path) -> None:
    text = "Logger XY-200\nSerial;1234\n\n% made on the bench\n" + csv(sep=";")
    same(taken(write(tmp_path, text), tmp_path / "runs"), TRUE)


def test_a_header_in_a_comment_as_numpy_writes_it(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    np.savetxt(path, TRUE.to_numpy(), header=" ".join(TRUE.columns), fmt="%.6g")
    same(taken(path, tmp_path / "runs"), TRUE)


@pytest.mark.parametrize("mark", [",", "|", "\t", ";", " "])
def test_delimiters(mark: str, tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv(sep=mark)), tmp_path / "runs"), TRUE)


def test_quotes_and_thousands(tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=[f"{s + 1000:,.1f}" for s in TRUE.time_s])
    run = taken(write(tmp_path, csv(frame, quoting=1)), tmp_path / "runs")
    same(run, TRUE.assign(time_s=TRUE.time_s + 1000))


def test_points_for_thousands_and_decimal_commas(tmp_path: Path) -> None:
    german = [f"{s + 1000:,.1f}".translate(str.maketrans(",.", ".,")) for s in TRUE.time_s]
    run = taken(write(tmp_path, csv(TRUE.assign(time_s=german), sep=";", decimal=",")), tmp_path / "runs")
    same(run, TRUE.assign(time_s=TRUE.time_s + 1000))


def test_three_digits_behind_a_comma_are_doubtful(tmp_path: Path) -> None:
    frame = TRUE[["time_s", "pwm", "winding_degC"]].astype({"time_s": int}).drop_duplicates("time_s")
    text = csv(frame.assign(winding_degC=[f"{v:.3f}".replace(".", ",") for v in frame.winding_degC]), sep=";")
    path = write(tmp_path, text)
    with pytest.raises(InputError, match=r"decimal mark: ,\? .* settle it by --decimal , or --decimal \."):
        take(path, tmp_path / "runs")
    same(taken(path, tmp_path / "runs", decimal=","), frame)


def test_a_serial_capture_with_garbage(tmp_path: Path) -> None:
    lines = csv().splitlines()
    lines[30] = lines[30][:9] + "\x02\x7f"
    lines.insert(50, "rst cause:2, boot mode")
    data = "\r\n".join(lines).encode().replace(lines[80].encode(), b"\xff\xfe\x80\x00garbage")
    path = tmp_path / "capture.log"
    path.write_bytes(data)
    found = take(path, tmp_path / "runs")
    run = read_run(found.runs[0])
    assert run.time_s.size == 118
    same(run, TRUE[TRUE.time_s.isin(run.time_s)])
    assert found.counted().loc["line that is no row of 5 columns", "count"] == 3
    assert found.counted().loc["line that is no row of 5 columns", "first"] == "line 31"


def test_lines_that_name_their_numbers(tmp_path: Path) -> None:
    lines = [f"t:{t:.1f} PWM:{p} T1:{w} T2:{c} amb:{a}" for t, p, w, c, a in TRUE.itertuples(index=False)]
    lines.insert(0, "Motor test v1.2")
    lines[40] = "T1:2"
    found = take(write(tmp_path, "\n".join(lines)), tmp_path / "runs", time="t", units={"t": "s"})
    names = {"winding_degC": "T1_degC", "casing_degC": "T2_degC"}
    same(read_run(found.runs[0]), TRUE.drop(index=39), names)


def test_a_serial_monitor_s_times(tmp_path: Path) -> None:
    stamps = pd.Timestamp("2024-12-31 13:45:00.123") + pd.to_timedelta(TRUE.time_s, unit="s")
    times = stamps.dt.strftime("%H:%M:%S.%f").str[:-3]
    lines = [f"{s} -> T1: {w} C, pwm: {p}" for s, w, p in zip(times, TRUE.winding_degC, TRUE.pwm, strict=True)]
    run = taken(write(tmp_path, "\n".join(lines)), tmp_path / "runs")
    np.testing.assert_allclose(run.time_s - run.time_s[0], TRUE.time_s, atol=1e-9)
    np.testing.assert_array_equal(run.temps["T1"], TRUE.winding_degC)


def test_rows_without_a_header_are_taken_when_they_are_named(tmp_path: Path) -> None:
    path = write(tmp_path, csv(TRUE, header=False))
    with pytest.raises(InputError, match="column_2"):
        take(path, tmp_path / "runs")
    columns = {"column_2": "pwm", "column_3": "winding_degC", "column_4": "casing", "column_5": "ambient_degC"}
    run = taken(path, tmp_path / "runs", columns=columns, units={"column_4": "degC"})
    same(run, TRUE)


def test_json_lines(tmp_path: Path) -> None:
    records = TRUE.to_dict("records")
    nested = [{"time_s": r.pop("time_s"), "pwm": r.pop("pwm"), "temps": r} for r in records]
    path = write(tmp_path, "\n".join(map(json.dumps, nested)) + '\n{"torn', name="log.jsonl")
    found = take(path, tmp_path / "runs")
    names = {"winding_degC": "temps_winding_degC", "casing_degC": "temps_casing_degC"}
    same(read_run(found.runs[0]), TRUE, names)
    assert found.counted().loc["line that is no JSON object", "first"] == "line 121"


def test_a_json_array(tmp_path: Path) -> None:
    same(taken(write(tmp_path, str(TRUE.to_json(orient="records")), name="log.json"), tmp_path / "runs"), TRUE)


def test_excel(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["Bench 3"])
    sheet.append([])
    sheet.append(["Time", "PWM", "Winding °C", "Casing °C", "Ambient °C"])
    begin = pd.Timestamp("2024-05-01 08:00:00")
    for time, *rest in TRUE.itertuples(index=False):
        sheet.append([(begin + pd.Timedelta(seconds=time)).to_pydatetime(), *map(float, rest)])
    book.create_sheet("Notes").append(["nothing here"])
    book.save(tmp_path / "log.xlsx")
    found = take(tmp_path / "log.xlsx", tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE)
    assert "sheet without a table: Notes" in found.counted().index


def test_parquet_with_an_index_of_times(tmp_path: Path) -> None:
    stamps = pd.DatetimeIndex(pd.Timestamp("2024-05-01", tz="UTC") + pd.to_timedelta(TRUE.time_s, unit="s"), name="ts")
    TRUE.drop(columns="time_s").set_index(stamps).to_parquet(tmp_path / "log.parquet")
    same(taken(tmp_path / "log.parquet", tmp_path / "runs"), TRUE)


def test_matlab(tmp_path: Path) -> None:
    columns: dict[str, object] = {str(name): TRUE[name].to_numpy().reshape(-1, 1) for name in TRUE}
    savemat(tmp_path / "a.mat", columns)
    same(taken(tmp_path / "a.mat", tmp_path / "a"), TRUE)
    savemat(tmp_path / "b.mat", {"log": columns, "room": 21.0})
    same(taken(tmp_path / "b.mat", tmp_path / "b"), TRUE)


def test_a_packed_file(tmp_path: Path) -> None:
    (tmp_path / "log.csv.gz").write_bytes(gzip.compress(csv().encode()))
    found = take(tmp_path / "log.csv.gz", tmp_path / "runs")
    assert [path.name for path in found.runs] == ["log.csv"]
    same(read_run(found.runs[0]), TRUE)


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


def test_gaps_are_told_and_split_on_request(tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=TRUE.time_s + np.where(np.arange(120) >= 70, 500.0, 0.0))
    path = write(tmp_path, csv(frame))
    found = take(path, tmp_path / "one")
    same(read_run(found.runs[0]), frame)
    assert found.counted().iloc[0]["first"] == "line 72"
    two = take(path, tmp_path / "two", split=True)
    assert [path.name for path in two.runs] == ["log_1.csv", "log_2.csv"]
    same(read_run(two.runs[0]), frame[:70])
    same(read_run(two.runs[1]), frame[70:])
    assert len(take(path, tmp_path / "wide", split=True, gap=600.0).runs) == 1


def test_a_clock_that_begins_anew_is_refused_or_split(tmp_path: Path) -> None:
    path = write(tmp_path, csv(pd.concat([TRUE, TRUE])))
    with pytest.raises(InputError, match=r"line 122: the clock begins anew: 0 s after 59\.5 s; expected --split"):
        take(path, tmp_path / "runs")
    found = take(path, tmp_path / "runs", split=True)
    for run in found.runs:
        same(read_run(run), TRUE)
    assert len(found.runs) == 2


def test_a_counter_of_32_bits_that_runs_over_goes_on(tmp_path: Path) -> None:
    ticks = (4_294_937_000 + 500 * np.arange(120)) % 2**32
    frame = TRUE.assign(time_s=ticks).rename(columns={"time_s": "millis"})
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    np.testing.assert_allclose(np.diff(read_run(found.runs[0]).time_s), 0.5, atol=1e-6)
    assert found.counted().loc["32-bit milliseconds ran over, counted on", "count"] == 1


def test_a_time_that_jumps_ahead_once_does_not_end_the_log(tmp_path: Path) -> None:
    frame = TRUE.copy()
    frame.loc[50, "time_s"] = 9e6
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE.drop(index=50))


def test_several_runs_in_one_file_are_parted_by_their_label(tmp_path: Path) -> None:
    frame = pd.concat([TRUE.assign(run="cold start"), TRUE.assign(run="warm")])
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    assert [path.name for path in found.runs] == ["log_cold_start.csv", "log_warm.csv"]
    for path in found.runs:
        same(read_run(path), TRUE)


def test_a_row_for_each_sensor_is_refused_with_what_to_do(tmp_path: Path) -> None:
    long = TRUE.melt(["time_s", "pwm"], var_name="sensor", value_name="T_C").sort_values("time_s", kind="stable")
    with pytest.raises(InputError, match=r"column sensor: has a row for each of .*; expected a column for each"):
        take(write(tmp_path, csv(long)), tmp_path / "runs")


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


def test_names_that_repeat_and_letters_that_are_no_units(tmp_path: Path) -> None:
    text = csv(TRUE.assign(phase_A=1, phase_B=2, phase_C=3)).replace("casing_degC", "winding_degC", 1)
    run = taken(write(tmp_path, text), tmp_path / "runs")
    assert list(run.temps) == ["winding", "winding_2"]
    assert list(run.extras) == ["phase_A", "phase_B", "phase_C"]
    np.testing.assert_array_equal(run.temps["winding_2"], TRUE.casing_degC)


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
