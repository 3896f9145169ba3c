"""Dates that no log has, clocks that were set, days and months that only the length of the log tells apart."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, same, take, taken, write

BEGIN = datetime(2026, 7, 4, 22, 30)
REST = TRUE[["pwm", "winding_degC", "casing_degC"]]


def stamped(stamps: list[str]) -> str:
    return REST.assign(timestamp=stamps).to_csv(index=False)


def every(step: timedelta, form: str = "%Y-%m-%d %H:%M:%S") -> list[str]:
    return [(BEGIN + i * step).strftime(form) for i in range(len(TRUE))]


@pytest.mark.parametrize("year", ["0001-01-01 00:00:00", "1601-01-01 00:00:00", "9999-12-31 23:59:59"])
@pytest.mark.parametrize("zone", ["", "Z"])
@pytest.mark.parametrize("row", [0, 60, len(TRUE) - 1])
def test_a_date_that_no_log_has_is_no_time(year: str, zone: str, row: int, tmp_path: Path) -> None:
    """Some loggers write the smallest or the largest date that they know where they know none."""
    stamps = [f"{stamp}{zone}" for stamp in every(timedelta(seconds=10))]
    stamps[row] = f"{year}{zone}"
    found = take(write(tmp_path, stamped(stamps)), tmp_path / "out")
    run = pd.read_csv(found.runs[0], comment="#")
    assert len(run) == len(TRUE) - 1
    assert run["time_s"].max() <= 10.0 * len(TRUE)
    assert found.counted().index.tolist() == ["row without a time"]


def test_such_a_date_in_a_typed_file(tmp_path: Path) -> None:
    stamps = np.array(every(timedelta(seconds=10)), dtype="datetime64[us]")
    stamps[0] = np.datetime64("0001-01-01", "us")
    REST.assign(timestamp=stamps).to_parquet(tmp_path / "log.parquet")
    run = taken(tmp_path / "log.parquet", tmp_path / "out")
    assert run.comments["started"] == "2026-07-04T22:30:10.000"
    np.testing.assert_allclose(np.diff(run.time_s), 10.0)


def test_rows_before_a_clock_was_set_are_left_out(tmp_path: Path) -> None:
    stamps = every(timedelta(seconds=10))
    stamps[:5] = [f"1970-01-01 00:00:{i:02d}" for i in range(5)]
    found = take(write(tmp_path, stamped(stamps)), tmp_path / "out")
    assert found.counted().index.tolist() == ["time more than 30 years from the others, left out"]
    run = pd.read_csv(found.runs[0], comment="#")
    np.testing.assert_allclose(run["time_s"], 10.0 * np.arange(len(TRUE) - 5))
    assert "# started: 2026-07-04T22:30:50" in found.runs[0].read_text()


def test_a_clock_that_was_set_half_way_is_refused(tmp_path: Path) -> None:
    stamps = every(timedelta(seconds=10))
    stamps[:60] = [f"1970-01-01 00:00:{i:02d}" for i in range(60)]
    with pytest.raises(InputError, match="a clock was set"):
        take(write(tmp_path, stamped(stamps)), tmp_path / "out")


@pytest.mark.parametrize(("form", "order"), [("%m/%d/%Y %H:%M:%S", "mdy"), ("%d/%m/%Y %H:%M:%S", "dmy")])
def test_days_and_months_are_told_apart_by_how_long_the_log_lasts(form: str, order: str, tmp_path: Path) -> None:
    """Over midnight from July the 4th to the 5th: read otherwise, a month would pass within a minute."""
    run = taken(write(tmp_path, stamped(every(timedelta(minutes=1), form))), tmp_path / "out")
    np.testing.assert_allclose(np.diff(run.time_s), 60.0)
    assert run.comments["started"].startswith("2026-07-04T22:30:00"), order


def test_lines_of_a_system_s_log_keep_their_days(tmp_path: Path) -> None:
    """Two runs of the end of February and of March: 49.5 h apart, and not an hour and a half."""
    lines = []
    for i, row in enumerate(TRUE.itertuples()):
        at = datetime(2026, 2, 28, 23, 50) + timedelta(seconds=10 * i, hours=49.5 if i >= 60 else 0.0)
        said = f"winding={row.winding_degC}C ambient={row.ambient_degC}C pwm={row.pwm}"
        lines.append(f"{at:%b %d %H:%M:%S} pi motor[1234]: {said}")
    lines.insert(30, "Feb 28 23:55:00 pi systemd[1]: Started a daily task.")
    run = taken(write(tmp_path, "\n".join(lines), name="syslog"), tmp_path / "out", units={"pwm": "counts"})
    same(run, TRUE[["pwm", "winding_degC", "ambient_degC"]])
    steps = np.diff(run.time_s)
    assert steps[59] == pytest.approx(10.0 + 49.5 * 3600.0)
    np.testing.assert_allclose(np.delete(steps, 59), 10.0)


def of_minutes(first: int, count: int, step: int = 1) -> list[str]:
    """`8:15`, `8:16` and so on, over midnight."""
    return [f"{(first + step * i) // 60 % 24:02d}:{(first + step * i) % 60:02d}" for i in range(count)]


def timed(times: list[str], name: str = "Time") -> str:
    return REST.assign(**{name: times}).to_csv(index=False)


HALF_PAST_EIGHT = of_minutes(510, len(TRUE))


@pytest.mark.parametrize(("unit", "step_s"), [("hh:mm", 60.0), ("mm:ss", 1.0)])
def test_hours_and_minutes_or_minutes_and_seconds_are_asked_for(unit: str, step_s: float, tmp_path: Path) -> None:
    log = write(tmp_path, timed(HALF_PAST_EIGHT))
    with pytest.raises(InputError, match=r"settle it by --unit Time=hh:mm or Time=mm:ss"):
        take(log, tmp_path / "none")
    run = taken(log, tmp_path / "out", units={"Time": unit})
    np.testing.assert_allclose(np.diff(run.time_s), step_s)


@pytest.mark.parametrize(
    ("name", "times", "step_s"),
    [
        ("Uhrzeit", HALF_PAST_EIGHT, 60.0),
        ("Time", of_minutes(23 * 60, len(TRUE)), 60.0),  # passes midnight
        ("Time", [f"{i // 60}:{i % 60:02d}" for i in range(len(TRUE))], 1.0),
        ("Time", [f"{(1500 + i) // 60}:{i % 60:02d}" for i in range(len(TRUE))], 1.0),  # from 25 minutes on
        ("Time", [f"08:{i // 10 % 60:02d}.{i % 10}" for i in range(len(TRUE))], 0.1),
    ],
)
def test_what_says_which_it_is(name: str, times: list[str], step_s: float, tmp_path: Path) -> None:
    run = taken(write(tmp_path, timed(times, name)), tmp_path / "out")
    np.testing.assert_allclose(np.diff(run.time_s), step_s)


def test_damaged_cells_among_hours_and_minutes_are_no_times(tmp_path: Path) -> None:
    times = [*HALF_PAST_EIGHT]
    times[7:9] = ["T1:xx", "garbage"]
    found = take(write(tmp_path, timed(times, "Uhrzeit")), tmp_path / "out")
    assert found.counted()["count"].to_dict() == {"row without a time": 2}


def test_a_day_from_midnight_to_midnight_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="settle it by --unit Time=hh:mm or Time=mm:ss"):
        take(write(tmp_path, timed(of_minutes(0, len(TRUE), 12))), tmp_path / "out")


@pytest.mark.parametrize("missing", [False, True])
def test_dates_and_times_of_day_in_columns_of_parquet(missing: bool, tmp_path: Path) -> None:
    stamps = np.array(every(timedelta(seconds=10)), dtype="datetime64[ns]")
    days = pd.Series(stamps.astype("datetime64[D]").astype("datetime64[ns]"))
    if missing:
        days[5] = pd.NaT
    frame = REST.assign(Date=days, Time=[str(stamp)[11:19] for stamp in stamps])
    frame.to_parquet(tmp_path / "log.parquet")
    run = taken(tmp_path / "log.parquet", tmp_path / "out")
    assert run.time_s.size == len(TRUE) - missing
    assert run.time_s[-1] == 10.0 * (len(TRUE) - 1)


def test_timestamps_of_a_zone_in_parquet_are_in_utc(tmp_path: Path) -> None:
    stamps = pd.DatetimeIndex(every(timedelta(seconds=10))).tz_localize("Europe/Berlin")
    REST.assign(timestamp=stamps).to_parquet(tmp_path / "log.parquet")
    assert taken(tmp_path / "log.parquet", tmp_path / "out").comments["started"].startswith("2026-07-04T20:30:00")


@pytest.mark.parametrize(("name", "scale"), [("TimeUS", 1e6), ("timeUs", 1e6), ("TimeMS", 1e3), ("timestampMS", 1e3)])
def test_a_unit_in_capitals_behind_a_time(name: str, scale: float, tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=(120e6 + scale * TRUE["time_s"]).astype(int)).rename(columns={"time_s": name})
    run = taken(write(tmp_path, csv(frame)), tmp_path / "out")
    np.testing.assert_allclose(np.diff(run.time_s), 0.5)


def test_whole_steps_that_would_last_days_in_ms_are_asked_for(tmp_path: Path) -> None:
    """120 s after a flight controller began, in us; in ms that would be more than a day."""
    counted = (120e6 + 2e4 * TRUE["time_s"]).astype(int)
    log = write(tmp_path, csv(TRUE.assign(timestamp=counted).drop(columns="time_s")))
    with pytest.raises(InputError, match=r"timestamp: time in ms\? .* in ms and .* in us"):
        taken(log, tmp_path / "out")
    run = taken(log, tmp_path / "out", units={"timestamp": "us"})
    np.testing.assert_allclose(np.diff(run.time_s), 0.01)
