"""Times whose hours, minutes and seconds are parted by points, and dates that look like them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.importing.clock import kind_of
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write

BEGIN = pd.Timestamp("2026-11-26 10:02:33")
HALVES = 2 * TRUE.time_s  # whole seconds


def stamps(form: str, begin: pd.Timestamp = BEGIN, step_s: int = 1) -> pd.Series:
    return (begin + pd.to_timedelta(HALVES * step_s, unit="s")).dt.strftime(form)


def frame(*columns: tuple[str, pd.Series]) -> pd.DataFrame:
    made = TRUE.drop(columns="time_s")
    for place, (name, cells) in enumerate(columns):
        made.insert(place, name, cells)
    return made


def test_a_time_of_day(tmp_path: Path) -> None:
    found = take(write(tmp_path, csv(frame(("Zeit", stamps("%H.%M.%S"))), sep=";")), tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE.assign(time_s=HALVES + 36_153))
    assert "times such as 10.02.33, hours.minutes.seconds" in str(found.guesses().loc["Zeit", "why"])


def test_one_damaged_line_costs_its_row_alone(tmp_path: Path) -> None:
    """Neither the times nor the decimal commas of all others, though what is left of it looks like a decimal point."""
    cells = stamps("%H.%M.%S")
    cells[7] = "10.0#.3"
    found = take(write(tmp_path, csv(frame(("Zeit", cells)), sep=";", decimal=",")), tmp_path / "runs")
    same(read_run(found.runs[0]), TRUE.assign(time_s=HALVES + 36_153).drop(index=7))
    assert found.counted().loc["row without a time", "count"] == 1


def test_a_time_of_day_passes_midnight_and_has_fractions(tmp_path: Path) -> None:
    late = (pd.Timestamp("2026-11-26 23:59:30") + pd.to_timedelta(TRUE.time_s, unit="s")).dt.strftime("%H.%M.%S,%f")
    found = take(write(tmp_path, csv(frame(("Zeit", late)), sep=";", decimal=",")), tmp_path / "runs")
    np.testing.assert_allclose(np.diff(read_run(found.runs[0]).time_s), 0.5, atol=1e-6)
    assert found.counted().loc["midnight passed", "count"] == 1


@pytest.mark.parametrize("form", ["%d.%m.%Y %H.%M.%S", "%d-%m-%Y %H.%M.%S", "%Y-%m-%d %H.%M.%S", "%d/%m/%Y, %H.%M.%S"])
def test_with_a_date(form: str, tmp_path: Path) -> None:
    run = taken(write(tmp_path, csv(frame(("Zeit", stamps(form))), sep=";")), tmp_path / "runs")
    same(run, TRUE.assign(time_s=HALVES))
    assert run.comments["started"] == "2026-11-26T10:02:33.000"


@pytest.mark.parametrize("form", ["%d.%m.%Y", "%d.%m.%y"])
def test_with_a_date_beside(form: str, tmp_path: Path) -> None:
    """The date is told from the time, though both consist of numbers and points."""
    begin = pd.Timestamp("2026-11-05 23:59:30")
    log = frame(("Datum", stamps(form, begin)), ("Zeit", stamps("%H.%M.%S", begin)))
    run = taken(write(tmp_path, csv(log, sep=";")), tmp_path / "runs")
    same(run, TRUE.assign(time_s=HALVES))
    assert run.comments["started"] == "2026-11-05T23:59:30.000"


def test_a_log_of_every_half_minute(tmp_path: Path) -> None:
    slow = stamps("%H.%M.%S", pd.Timestamp("2026-11-26 10:02:00"), 30)
    run = taken(write(tmp_path, csv(frame(("Zeit", slow)), sep=";")), tmp_path / "runs")
    assert run.time_s[-1] - run.time_s[0] == 119 * 30


@pytest.mark.parametrize(
    ("cells", "kind"),
    [
        (["01.11.26", "02.11.26", "03.11.26"], "date"),  # as times an hour apart
        (["10.12.25", "11.01.26", "12.01.26"], "date"),
        (["10.02.26"] * 5, "date"),
        (["30.12.25", "31.12.25", "01.01.26"], "date"),
        (["10.02.33", "10.02.34", "10.02.33", "10.02.35"], "date"),  # does not go on
        (["10.02.33", "10.02.34", "10.61.00"], "date"),  # not throughout
        (["10.58.00", "10.59.00", "11.00.00", "11.01.00"], "clock"),  # no year has a month 58
        (["10.02.00", "10.02.30", "10.03.00"], "clock"),
        (["9.58.59", "9.59.00", "9.59.01"], "clock"),
    ],
)
def test_dates_of_a_few_days_are_no_times(cells: list[str], kind: str) -> None:
    assert kind_of(cells) == kind


def test_dates_alone_are_refused(tmp_path: Path) -> None:
    days = pd.Series([f"{1 + i // 12:02d}.11.26" for i in range(len(TRUE))])
    with pytest.raises(InputError, match=r"no column is a time|holds dates without times"):
        take(write(tmp_path, csv(frame(("Datum", days)), sep=";")), tmp_path / "runs")
