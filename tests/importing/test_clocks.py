"""Clocks that go back or ahead: counters that run over, summer time, tests that follow on each other in one file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import Run, read_run
from tests.importing.logs import TRUE, csv, take, taken, write

BERLIN = "Europe/Berlin"


def log(tmp_path: Path, times: list[object], head: str = "time") -> Path:
    rows = "".join(f"{time},80.5,{20 + 0.01 * i:.2f}\n" for i, time in enumerate(times))
    return write(tmp_path, f"{head},duty [%],winding [degC]\n{rows}")


def local(begin: str, step_s: int, rows: int, form: str = "%Y-%m-%d %H:%M:%S") -> list[object]:
    """Times of a place whose clock knows summer time."""
    first = pd.Timestamp(begin, tz="UTC").tz_convert(BERLIN)
    return [(first + pd.Timedelta(seconds=step_s * i)).strftime(form) for i in range(rows)]


@pytest.mark.parametrize("last_s", [3300, 3900, 4280, 4290])
@pytest.mark.parametrize(("head", "factor"), [("time [s]", 1), ("time [ms]", 1000), ("time [us]", 10**6), ("t", 1)])
def test_two_tests_in_one_file_are_no_counter_that_ran_over(
    head: str, factor: int, last_s: int, tmp_path: Path
) -> None:
    times = [factor * s for s in range(0, last_s + 10, 10)]
    with pytest.raises(InputError, match="the clock begins anew"):
        take(log(tmp_path, [*times, *times], head), tmp_path / "runs")


@pytest.mark.parametrize("step_s", [0.5, 10.0])
@pytest.mark.parametrize(
    ("head", "factor", "name"), [("millis", 10**3, "milliseconds"), ("micros", 10**6, "microseconds")]
)
def test_a_counter_whose_intervals_go_on_across_its_end_ran_over(
    head: str, factor: int, name: str, step_s: float, tmp_path: Path
) -> None:
    jitter = np.random.default_rng(1).integers(0, factor // 1000 + 1, 60)
    steps = np.arange(60) * int(step_s * factor)
    ticks = (2**32 - int(20.3 * step_s * factor) + steps + jitter) % 2**32
    found = take(log(tmp_path, ticks.tolist(), head), tmp_path / "runs")
    np.testing.assert_allclose(np.diff(read_run(found.runs[0]).time_s), step_s, atol=2e-3)
    assert found.counted().loc[f"32-bit {name} ran over, counted on", "count"] == 1


def test_the_end_of_summer_time_is_named_and_its_zone_lets_time_go_on(tmp_path: Path) -> None:
    path = log(tmp_path, local("2024-10-26 23:00", 10, 1440))
    with pytest.raises(
        InputError, match=r"line 722: the clock goes back by an hour, as where summer time ends; .*--zone"
    ):
        take(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    run = taken(path, tmp_path / "out", zone=BERLIN, mapping=tmp_path / "map.toml")
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(1440))
    assert run.comments["started"] == "2024-10-26T23:00:00.000"
    again = taken(path, tmp_path / "again", mapping=tmp_path / "map.toml")
    np.testing.assert_array_equal(again.time_s, run.time_s)
    assert len(take(path, tmp_path / "two", split=True).runs) == 2


def test_rows_of_a_slow_log_are_not_dropped_where_summer_time_ends(tmp_path: Path) -> None:
    """Six rows an hour: the clock passes its old time within a few rows, as after rows that are only late."""
    path = log(tmp_path, local("2024-10-26 20:00", 600, 60))
    with pytest.raises(InputError, match="the clock goes back by an hour"):
        take(path, tmp_path / "out")
    np.testing.assert_allclose(taken(path, tmp_path / "out", zone=BERLIN).time_s, 600.0 * np.arange(60))


def test_a_log_that_ends_within_the_hour_that_is_there_twice(tmp_path: Path) -> None:
    run = taken(log(tmp_path, local("2024-10-26 23:00", 10, 400)), tmp_path / "out", zone=BERLIN)
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(400))


def test_exports_newest_first_across_the_end_of_summer_time(tmp_path: Path) -> None:
    path = log(tmp_path, local("2024-10-26 23:00", 10, 1440)[::-1])
    run = taken(path, tmp_path / "out", zone=BERLIN, sort=True)
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(1440))
    assert run.temps["winding"][-1] == 20.0


def test_date_and_time_in_two_columns_have_a_zone_too(tmp_path: Path) -> None:
    times = local("2024-10-26 23:00", 10, 1440, "%d.%m.%Y,%H:%M:%S")
    run = taken(log(tmp_path, times, "Date,Time"), tmp_path / "out", zone=BERLIN)
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(1440))


def spring(tmp_path: Path, **options: object) -> tuple[Run, list[str]]:
    found = take(log(tmp_path, local("2024-03-30 23:30", 20, 600)), tmp_path / "out", overwrite=True, **options)
    return read_run(found.runs[0]), found.warnings


def test_the_beginning_of_summer_time_is_said_and_its_zone_closes_the_gap(tmp_path: Path) -> None:
    run, warnings = spring(tmp_path)
    assert run.time_s[-1] == 20 * 599 + 3600
    assert [
        "line 272, column time: the clock goes ahead by an hour" in text and "--zone" in text for text in warnings
    ] == [True]
    run, warnings = spring(tmp_path, zone=BERLIN)
    np.testing.assert_allclose(run.time_s, 20.0 * np.arange(600))
    assert warnings == []


def test_a_pause_of_another_length_is_no_summer_time(tmp_path: Path) -> None:
    times = [f"2024-06-01 {10 + s // 3600:02d}:{s // 60 % 60:02d}:{s % 60:02d}" for s in range(0, 3000, 20)]
    times += [f"2024-06-01 {12 + s // 3600:02d}:{s // 60 % 60:02d}:{s % 60:02d}" for s in range(0, 3000, 20)]
    assert take(log(tmp_path, list(times)), tmp_path / "out").warnings == []
    back = times[150:] + times[100:150]
    with pytest.raises(InputError, match="the clock begins anew"):
        take(log(tmp_path, list(back)), tmp_path / "more")


@pytest.mark.parametrize(
    ("head", "times", "zone", "said"),
    [
        ("time", local("2024-10-26 23:00", 10, 60), "Mars/Base", '--zone: found "Mars/Base", expected a time zone'),
        ("time [s]", list(range(60)), BERLIN, "--zone: the time is a s; expected dates with times"),
        ("time", [f"10:00:{i:02d}" for i in range(60)], BERLIN, "--zone: the time is a time of day; expected dates"),
        (
            "time",
            [f"2024-10-26T10:00:{i:02d}Z" for i in range(60)],
            BERLIN,
            "line 2, column time: .*expected no --zone",
        ),
    ],
)
def test_a_zone_that_fits_nothing_is_refused(
    head: str, times: list[object], zone: str, said: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=said):
        take(log(tmp_path, times, head), tmp_path / "out", zone=zone)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("begin", "form", "said"),
    [
        ("2026-03-02 11:50:00", "%Y-%m-%d %I:%M:%S", "back by 12 hours"),
        ("2026-03-02 22:50:00", "2026-03-02 %H:%M:%S", "back by a day"),
    ],
)
def test_dates_that_go_back_by_half_a_day_or_a_day_are_told_as_that(
    begin: str, form: str, said: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=f"line 22: .*{said}.*--split"):
        take(log(tmp_path, local(begin, 30, 200, form)), tmp_path / "runs")


def test_a_ring_that_was_read_from_its_middle_is_put_in_order(tmp_path: Path) -> None:
    """A controller's data log, of which the oldest rows were written over."""
    at = np.datetime64("2026-05-03T00:00:00") + (10_000 * np.arange(len(TRUE))).astype("timedelta64[ms]")
    frame = TRUE.assign(time_s=at).rename(columns={"time_s": "time"})
    log = write(tmp_path, csv(pd.concat([frame[70:], frame[:70]])))
    with pytest.raises(InputError, match=r"as in a ring that was read from its middle; expected --sort, "):
        taken(log, tmp_path / "out")
    np.testing.assert_array_equal(taken(log, tmp_path / "out", sort=True).temps["winding"], TRUE["winding_degC"])
