"""Clocks that go round: stopwatches, counters of a day, minutes of an hour; and LabVIEW's seconds since 1904."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, take, taken, write

ROWS = len(TRUE)


def log(tmp_path: Path, times: Sequence[object], head: str = "Time") -> Path:
    rows = [f"{t},{row.pwm},{row.winding_degC}" for t, row in zip(times, TRUE.itertuples(), strict=True)]
    return write(tmp_path, "\n".join([f"{head},PWM,winding [C]", *rows]))


def stopwatch(seconds: int) -> str:
    hours, rest = divmod(seconds, 3600)
    return f"{hours}:{rest // 60:02d}:{rest % 60:02d}" if hours else f"{rest // 60:02d}:{rest % 60:02d}"


@pytest.mark.parametrize(("first", "step"), [(3000, 10), (0, 60), (3590, 10), (0, 31)])
def test_a_stopwatch_goes_over_to_hours(first: int, step: int, tmp_path: Path) -> None:
    seconds = first + step * np.arange(ROWS)
    run = taken(log(tmp_path, [stopwatch(int(s)) for s in seconds]), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, seconds)


def test_a_file_of_less_than_an_hour_beside_one_of_more(tmp_path: Path) -> None:
    from gen.interface import import_runs
    from gen.runs import read_run

    short = log(tmp_path, [stopwatch(10 * i) for i in range(ROWS)])
    short.rename(tmp_path / "a.csv")
    log(tmp_path, [stopwatch(60 * i) for i in range(ROWS)])
    found = import_runs([tmp_path / "a.csv", tmp_path / "log.csv"], tmp_path / "out")
    for path, step in zip(found.runs, (10, 60), strict=True):
        np.testing.assert_allclose(read_run(path).time_s, step * np.arange(ROWS))


def test_times_of_day_that_leave_out_seconds_of_0(tmp_path: Path) -> None:
    """As Java writes them."""
    seconds = 10 * 3600 + 20 * np.arange(ROWS)
    texts = [f"{s // 3600}:{s // 60 % 60:02d}" + (f":{s % 60:02d}" if s % 60 else "") for s in seconds.tolist()]
    np.testing.assert_allclose(taken(log(tmp_path, texts), tmp_path / "out").time_s, seconds)


@pytest.mark.parametrize("ending", ["", ".5"])
def test_minutes_that_begin_anew_each_hour(ending: str, tmp_path: Path) -> None:
    """A row is missing where they do."""
    seconds = np.delete(3000 + 60 * np.arange(ROWS + 1), 10)
    texts = [f"{s // 60 % 60:02d}:{s % 60:02d}{ending}" for s in seconds.tolist()]
    found = take(log(tmp_path, texts), tmp_path / "out")
    assert found.counted()["count"]["the minutes of an hour ran over, counted on"].sum() == 2
    np.testing.assert_allclose(taken(log(tmp_path, texts), tmp_path / "new").time_s, seconds + float(ending or 0))


def test_a_second_test_within_the_hour_is_none(tmp_path: Path) -> None:
    texts = [f"{i % 40:02d}:00" for i in range(ROWS)]
    with pytest.raises(InputError, match="the clock begins anew"):
        take(log(tmp_path, texts), tmp_path / "out")


@pytest.mark.parametrize(("head", "count"), [("ms_today", 1000), ("seconds", 1), ("t [s]", 1)])
def test_a_count_of_the_day_goes_on_after_midnight(head: str, count: int, tmp_path: Path) -> None:
    """As a VESC writes it."""
    seconds = 86_000 + 10 * np.arange(ROWS)
    found = log(tmp_path, [int(s) % 86_400 * count for s in seconds], head)
    run = taken(found, tmp_path / "out", units={head: "ms" if count == 1000 else "s"})
    np.testing.assert_allclose(run.time_s, seconds)


def test_two_tests_of_a_day_each_are_two(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the clock begins anew"):
        take(log(tmp_path, [1440 * (i % 60) for i in range(ROWS)], "t [s]"), tmp_path / "out")


def test_hours_to_12_without_am_and_pm(tmp_path: Path) -> None:
    seconds = 12 * 3600 + 60 * 20 + 60 * np.arange(ROWS)
    texts = [f"{(s // 3600 - 1) % 12 + 1}:{s // 60 % 60:02d}:{s % 60:02d}" for s in seconds.tolist()]
    np.testing.assert_allclose(taken(log(tmp_path, texts), tmp_path / "out").time_s, seconds)


def test_labview_counts_from_1904(tmp_path: Path) -> None:
    """2026-03-02T08:15:00.125 is 3 855 284 100.125 there: 66 years with 17 leap days before 1970."""
    first = (66 * 365 + 17) * 86_400 + 1772439300.125
    run = taken(log(tmp_path, [f"{first + 10 * i:.6f}" for i in range(ROWS)]), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(ROWS))
    assert run.comments["started"] == "2026-03-02T08:15:00.125"
