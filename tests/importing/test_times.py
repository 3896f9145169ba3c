"""Times as loggers write them, rows out of order, gaps and clocks that begin anew."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, truth, write


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


def test_milliseconds_are_thousandths_to_the_last_bit(tmp_path: Path) -> None:
    """7 x 0.001 is another number than 7 / 1000, which is what the run's file says."""
    ticks = 7 * np.arange(len(TRUE))
    frame = TRUE.assign(time_s=ticks).rename(columns={"time_s": "time_ms"})
    run = taken(write(tmp_path, csv(frame)), tmp_path / "runs")
    assert run.time_s.tolist() == [tick / 1000 for tick in ticks.tolist()]


def test_date_and_time_in_two_columns(tmp_path: Path) -> None:
    stamps = pd.Timestamp("2024-12-31 23:59:40") + pd.to_timedelta(TRUE.time_s, unit="s")
    frame = TRUE.drop(columns="time_s")
    frame.insert(0, "Date", stamps.dt.strftime("%d.%m.%Y"))
    frame.insert(1, "Time", stamps.dt.strftime("%H:%M:%S.%f"))
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), TRUE)


def test_of_two_columns_of_dates_the_example_is_of_the_one_that_is_taken(tmp_path: Path) -> None:
    """A logger that writes when its file was begun, beside when each row was."""
    stamps = pd.Timestamp("2024-12-31 09:00:00") + pd.to_timedelta(TRUE.time_s, unit="s")
    frame = TRUE.drop(columns="time_s")
    frame.insert(0, "Date", stamps.dt.strftime("%d.%m.%Y"))
    frame.insert(1, "Time", stamps.dt.strftime("%H:%M:%S.%f"))
    frame["Calibrated"] = "17.03.2021"
    why = str(take(write(tmp_path, csv(frame)), tmp_path / "runs").guesses().loc["Date, Time", "why"])
    assert "31.12.2024" in why
    assert "17.03.2021" not in why


@pytest.mark.parametrize(("columns", "expected"), [("n,Time", "a date and time"), ("Date,n", "times of day")])
def test_of_a_date_and_a_time_the_column_that_holds_numbers_is_named(
    columns: str, expected: str, tmp_path: Path
) -> None:
    frame = TRUE.assign(Date="31.12.2024", Time="23:59:40", n=range(len(TRUE)))
    frame.to_parquet(tmp_path / "log.parquet")
    with pytest.raises(InputError, match=f"column n: holds numbers, expected {expected}$"):
        take(tmp_path / "log.parquet", tmp_path / "runs", time=columns)


def test_a_time_of_day_that_passes_midnight(tmp_path: Path) -> None:
    stamps = pd.Timestamp("2024-12-31 23:59:40") + pd.to_timedelta(TRUE.time_s, unit="s")
    frame = TRUE.assign(time_s=stamps.dt.strftime("%H:%M:%S.%f")).rename(columns={"time_s": "Time"})
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    run = read_run(found.runs[0])
    np.testing.assert_allclose(np.diff(run.time_s), 0.5, atol=1e-6)
    assert found.counted().loc["midnight passed", "count"] == 1
    assert "midnight passed" in run.comments["counted_1"]


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


@pytest.mark.parametrize("name", ["t_min", "time_min", "Elapsed min"])
def test_minutes_behind_an_underscore_are_minutes_where_they_rise(name: str, tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=TRUE.time_s / 60).rename(columns={"time_s": name})
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), TRUE)
    savemat(tmp_path / "log.mat", {str(head).replace(" ", "_"): frame[head].to_numpy() for head in frame})
    same(taken(tmp_path / "log.mat", tmp_path / "mat"), TRUE)


def test_the_least_of_temperatures_is_no_time(tmp_path: Path) -> None:
    """It rises and falls, as this does by less than a tenth of its rows."""
    least = np.round(20.0 + 0.2 * np.arange(len(TRUE)) - 3.0 * (np.arange(len(TRUE)) % 20 == 19), 1)
    run = taken(write(tmp_path, csv(TRUE.assign(t_min=least))), tmp_path / "runs")
    same(run, TRUE)
    np.testing.assert_array_equal(run.temps["min_part"], least)


@pytest.mark.parametrize(("origin", "begin"), [(719_529, "matlab"), (25_569, "excel")])
@pytest.mark.parametrize("name", ["time", "t [d]"])
def test_days_since_long_ago_count_from_the_first(origin: int, begin: str, name: str, tmp_path: Path) -> None:
    days = (pd.Timestamp("2024-03-05 09:58:12") - pd.Timestamp("1970-01-01")) / pd.Timedelta(days=1) + origin
    long = truth(400, 10.0)
    frame = long.assign(time_s=days + long.time_s / 86_400).rename(columns={"time_s": name})
    run = taken(write(tmp_path, csv(frame)), tmp_path / "runs")
    np.testing.assert_allclose(run.time_s, long.time_s, atol=1e-4)
    assert run.comments["started"] == "2024-03-05T09:58:12.000"


def test_milliseconds_without_a_unit_are_told_by_their_steps(tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=(TRUE.time_s * 1000).astype(int)).rename(columns={"time_s": "time"})
    same(taken(write(tmp_path, csv(frame)), tmp_path / "runs"), TRUE)


@pytest.mark.parametrize("digits", [2, 4, 15])
@pytest.mark.parametrize(("step_s", "rows"), [(10, 400), (1, 3000), (5, 400), (20, 400)])
def test_steps_that_are_plain_in_minutes_only_are_asked_for(
    step_s: int, rows: int, digits: int, tmp_path: Path
) -> None:
    long = truth(rows, step_s)
    frame = long.assign(time_s=np.round(long.time_s / 60, digits)).rename(columns={"time_s": "time"})
    path = write(tmp_path, csv(frame))
    with pytest.raises(InputError, match=rf"{step_s} s in min; settle it by --unit time=s, =ms, =min, =h or =d"):
        take(path, tmp_path / "runs")
    run = taken(path, tmp_path / "runs", units={"time": "min"})
    np.testing.assert_allclose(run.time_s, long.time_s, atol=0.6 * 10.0**-digits * 60 + 1e-6)


def test_steps_that_are_plain_in_hours_only_are_asked_for(tmp_path: Path) -> None:
    long = truth(9000, 10.0)
    frame = long.assign(time_s=np.round(long.time_s / 3600, 5)).rename(columns={"time_s": "time"})
    with pytest.raises(InputError, match=r"10 s in h; settle it by --unit time=s"):
        take(write(tmp_path, csv(frame)), tmp_path / "runs")


@pytest.mark.parametrize("step_s", [0.5, 0.25, 0.1, 0.05, 0.125, 0.033, 1.0, 2.0, 2.5])
def test_steps_that_are_plain_in_seconds_are_seconds(step_s: float, tmp_path: Path) -> None:
    frame = truth(2000, step_s).assign(time_s=np.round(np.arange(2000) * step_s, 6))
    found = take(write(tmp_path, csv(frame.rename(columns={"time_s": "time"}))), tmp_path / "runs")
    same(read_run(found.runs[0]), frame)
    short_s = 7200 if step_s == 1.0 else 900  # rows 1 apart may be of minutes
    assert ["taken for s" in text for text in found.warnings] == ([True] if step_s * 1999 < short_s else [])


def test_a_log_that_would_be_short_in_seconds_is_said(tmp_path: Path) -> None:
    path = write(tmp_path, csv(truth(400, 0.5).rename(columns={"time_s": "time"})))
    warning = (
        "time: has no unit; taken for s it lasts 3.325 min, a row every 0.5 s, which is short for a motor's "
        "temperature; if it is not s: --unit time=min (3.325 h, a row every 30 s), time=h (199.5 h, a row every 30 "
        "min); if it is: --unit time=s"
    )
    assert [text.partition(": ")[2] for text in take(path, tmp_path / "a").warnings] == [warning]
    assert take(path, tmp_path / "b", units={"time": "s"}).warnings == []
    assert taken(path, tmp_path / "c", units={"time": "min"}).time_s[-1] == 199.5 * 60


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


def test_a_clock_of_every_twenty_seconds_is_spread_just_as_evenly(tmp_path: Path) -> None:
    slow = TRUE.assign(time_s=20.0 * TRUE.time_s)  # two rows for each time
    path = write(tmp_path, csv(slow.assign(time_s=(20 * np.floor(TRUE.time_s)).astype(int))))
    same(taken(path, tmp_path / "runs", duplicates="spread"), slow)


def test_backward_times_are_left_out_and_counted(tmp_path: Path) -> None:
    lines = csv().splitlines()
    late = lines.pop(20)
    lines.insert(24, late)
    found = take(write(tmp_path, "\n".join(lines)), tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE.drop(index=19))
    assert found.counted().loc["time before that of an earlier row, left out", "first"] == "line 25, column time_s"


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


def test_a_board_that_begins_anew_within_its_first_second_is_seen(tmp_path: Path) -> None:
    quick = TRUE.assign(time_s=np.round(TRUE.time_s / 10.0, 2))
    found = take(write(tmp_path, csv(pd.concat([quick[:15], quick]))), tmp_path / "runs", split=True)
    assert [len(read_run(run).time_s) for run in found.runs] == [15, 120]


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


def test_runs_that_are_numbered_are_parted_by_their_number(tmp_path: Path) -> None:
    """As in the log of a motor that most people know: no time, a row each half second, and the number of a profile."""
    frame = pd.concat([TRUE.assign(profile_id=17), TRUE.assign(profile_id=4)]).drop(columns="time_s")
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs", time="0.5")
    assert [path.name for path in found.runs] == ["log_17.csv", "log_4.csv"]
    for path in found.runs:
        same(read_run(path), TRUE)
        assert "profile_id" not in read_run(path).extras


@pytest.mark.parametrize("numbers", [np.arange(120), np.full(120, 3), np.arange(120) % 2])
def test_a_number_that_counts_rows_or_comes_back_parts_no_runs(numbers: np.ndarray, tmp_path: Path) -> None:
    run = taken(write(tmp_path, csv(TRUE.assign(test=numbers))), tmp_path / "runs")
    same(run, TRUE)
    np.testing.assert_array_equal(run.extras["test"], numbers)


def shuffled(rows: int, order: list[int]) -> str:
    lines = [f"2024-05-01 10:{i // 60:02d}:{i % 60:02d},{i % 2 * 50}.5,{20 + 0.1 * i:.1f}" for i in range(rows)]
    return "time,duty [%],winding [°C]\n" + "\n".join(lines[i] for i in order)


def test_exports_in_another_order_are_sorted_when_that_is_said(tmp_path: Path) -> None:
    order = [i for begin in range(0, 120, 8) for i in (*range(begin + 4, begin + 8), *range(begin, begin + 4))]
    log = write(tmp_path, shuffled(120, order))
    with pytest.raises(InputError, match=r"rows are not in the order of their times; expected --sort"):
        take(log, tmp_path / "out")
    found = take(log, tmp_path / "out", sort=True, mapping=tmp_path / "map.toml")
    run = read_run(found.runs[0])
    np.testing.assert_allclose(run.time_s, np.arange(120.0))
    np.testing.assert_allclose(run.temps["winding"], 20 + 0.1 * np.arange(120))
    assert run.pwm[:4].tolist() == [1, 129, 1, 129]
    assert found.counted().index.tolist() == ["place at which rows were put in the order of their times"]
    again = take(log, tmp_path / "again", mapping=tmp_path / "map.toml")
    assert again.runs[0].read_bytes() == found.runs[0].read_bytes()


@pytest.mark.parametrize("split", [False, True])
def test_newest_first_is_turned_round_when_that_is_said(tmp_path: Path, split: bool) -> None:
    log = write(tmp_path, shuffled(120, list(reversed(range(120)))))
    with pytest.raises(InputError, match=r"line 3: rows stand in the order of falling times; expected --sort"):
        take(log, tmp_path / "out", split=split)
    np.testing.assert_allclose(taken(log, tmp_path / "out", sort=True, split=split).time_s, np.arange(120.0))


def test_of_an_export_newest_first_what_it_begins_with_is_its_end(tmp_path: Path) -> None:
    """Temperatures without a unit: begun at 60, they might be degF."""
    frame = truth(400, 1.0).rename(columns={name: name.removesuffix("_degC") for name in truth().columns})
    stamps = pd.Timestamp("2026-03-12 14:05:00") + pd.to_timedelta(frame.pop("time_s"), unit="s")
    frame = frame.assign(pwm=204, time=stamps)[::-1]
    run = taken(write(tmp_path, csv(frame)), tmp_path / "out", sort=True)
    np.testing.assert_allclose(run.temps["winding"], truth(400, 1.0).winding_degC)


@pytest.mark.parametrize(
    ("step", "units"),
    [
        (0.002, []),  # in min, eight rows a second, and in h one in 7 s, which nobody writes so
        (0.01, ["h"]),
        (0.25, ["min", "h"]),
        (1.0, ["min"]),
    ],
)
def test_only_units_in_which_rows_may_come_that_often_are_offered(
    step: float, units: list[str], tmp_path: Path
) -> None:
    rows = max(60, round(30 / step))
    frame = truth(rows, step).assign(time_s=np.round(np.arange(rows) * step, 6))
    warnings = take(write(tmp_path, csv(frame.rename(columns={"time_s": "time"}))), tmp_path / "runs").warnings
    assert [unit for unit in ("min", "h") if any(f"time={unit} (" in text for text in warnings)] == units
    assert len(warnings) == bool(units)


def test_a_time_since_1970_is_in_no_other_unit(tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=1_795_687_200 + TRUE.time_s).rename(columns={"time_s": "timestamp"})
    assert take(write(tmp_path, csv(frame)), tmp_path / "runs").warnings == []


def test_a_capital_t_is_a_time_only_where_its_steps_are_even(tmp_path: Path) -> None:
    """What a printer says of its heater, without any time."""
    lines = "".join(
        f"ok T:{value:.1f} /210.0 @:{127 if i < 80 else 0} PWM:{128 if i < 80 else 0}\n"
        for i, value in enumerate(TRUE.winding_degC)
    )
    path = write(tmp_path, lines, name="printer.log")
    with pytest.raises(InputError, match="no column is a time among T, T target, @, PWM"):
        take(path, tmp_path / "runs")
    run = taken(path, tmp_path / "runs", time="2", columns={"T": "nozzle_degC"})
    np.testing.assert_array_equal(run.temps["nozzle"], TRUE.winding_degC)
    same(taken(write(tmp_path, csv(TRUE.rename(columns={"time_s": "T"}))), tmp_path / "even"), TRUE)


@pytest.mark.parametrize("late", ["received_at", "Uploaded", "server time"])
@pytest.mark.parametrize("own", ["timestamp", "ts"])
def test_when_a_reading_arrived_is_not_when_it_was_taken(late: str, own: str, tmp_path: Path) -> None:
    at = pd.Timestamp("2024-03-14 09:15:00") + pd.to_timedelta(TRUE.time_s, unit="s")
    taken_at = at if own == "timestamp" else (at - pd.Timestamp("1970-01-01")) / pd.Timedelta("1s")
    arrived = at + pd.to_timedelta(np.where(TRUE.index % 7, 0.3, 4.0), unit="s")
    frame = pd.DataFrame({late: arrived, own: taken_at}).join(TRUE.drop(columns="time_s"))
    np.testing.assert_allclose(taken(write(tmp_path, csv(frame)), tmp_path / "out").time_s, TRUE.time_s, atol=1e-6)


def test_hours_that_a_machine_has_worked_and_times_of_steps_are_not_the_log_s(tmp_path: Path) -> None:
    stamps = pd.Timestamp("2024-03-14 09:15:00") + pd.to_timedelta(TRUE.time_s, unit="s")
    frame = TRUE.assign(time_s=stamps).rename(columns={"time_s": "Timestamp"})
    frame.insert(0, "Operating hours [h]", np.round(1203.5 + TRUE.time_s / 3600, 3))
    same(taken(write(tmp_path, csv(frame)), tmp_path / "hours"), TRUE)
    frame = TRUE.rename(columns={"time_s": "Total time (s)"})
    frame.insert(0, "Step time (s)", TRUE.time_s % 30.0)
    same(taken(write(tmp_path, csv(frame)), tmp_path / "steps"), TRUE)
