"""Times of day and durations as sketches, recorders and cameras write them, and counts from other years than 1970."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, same, take, taken, write

REST = TRUE[["pwm", "winding_degC", "casing_degC", "ambient_degC"]]
BEGIN = datetime(2026, 3, 2, 8, 15)
UNIX = 1_772_439_300
MINUTES = 60 * np.arange(len(TRUE))


def log(times: list[object], name: str = "time") -> str:
    frame = REST.copy()
    frame.insert(0, name, times)
    return csv(frame)


def moments(form: Callable[[datetime], str], before_s: int = 0) -> str:
    return log([form(BEGIN + timedelta(seconds=int(s) - before_s)) for s in MINUTES])


def lasting(form: Callable[[int], str], shift_s: int = 0) -> str:
    return log([form(int(s) + shift_s) for s in MINUTES])


def parted(seconds: int) -> tuple[int, int, int]:
    return seconds // 3600, seconds // 60 % 60, seconds % 60


def in_days(s: int) -> str:
    hours, minutes, seconds = parted(s)
    return f"{hours // 24}:{hours % 24:02d}:{minutes:02d}:{seconds:02d}"


@pytest.mark.parametrize(
    "text",
    [
        moments(lambda at: f"{at.hour}:{at.minute}:{at.second}"),
        moments(lambda at: f"{at:%Y}-{at.month}-{at.day} {at.hour}:{at.minute}:{at.second}"),
        moments(lambda at: f"{at:%d.%m.%y}:{at:%H:%M:%S}"),
        moments(lambda at: f"{at:%y%m%d%H%M%S}"),
        moments(lambda at: f"{at:%j:%H:%M:%S}"),
        moments(lambda at: f"{at:%j:%H:%M:%S}.250"),
        lasting(in_days),
        lasting(in_days, 23 * 3600 + 1800),
        lasting(lambda s: "+{:02d}:{:02d}:{:02d}".format(*parted(s))),
        lasting(lambda s: "T+{:02d}:{:02d}:{:02d}".format(*parted(s))),
        lasting(lambda s: ("-" if s < 0 else "") + "{:02d}:{:02d}:{:02d}".format(*parted(abs(s))), -300),
        lasting(lambda s: "T{}{:02d}:{:02d}:{:02d}".format("-" if s < 0 else "+", *parted(abs(s))), -300),
    ],
)
def test_times_go_on_a_minute_a_row(text: str, tmp_path: Path) -> None:
    run = taken(write(tmp_path, text), tmp_path / "out")
    np.testing.assert_allclose(run.time_s - run.time_s[0], MINUTES, atol=1e-6)
    same(run, REST)


def test_days_before_a_time_of_day_are_told_and_survive_a_damaged_row(tmp_path: Path) -> None:
    text = lasting(in_days).replace("0:00:07:00", "0:00:#7:00")
    found = take(write(tmp_path, text), tmp_path / "out")
    assert found.counted().index.tolist() == [
        "time of time taken for days, hours, minutes and seconds",
        "row without a time",
    ]


def test_a_fraction_behind_a_colon_is_told(tmp_path: Path) -> None:
    text = lasting(lambda s: "{:02d}:{:02d}:{:02d}:{:02d}".format(*parted(s), s // 60 % 25))
    found = take(write(tmp_path, text), tmp_path / "out")
    assert found.counted().index.tolist() == [
        "time of time whose last two digits were taken for hundredths of a second"
    ]


def test_four_digits_may_be_hours_or_minutes(tmp_path: Path) -> None:
    path = write(tmp_path, moments(lambda at: f"{at:%H%M}"))
    with pytest.raises(InputError, match="hh:mm, or mm:ss"):
        take(path, tmp_path / "out")
    run = taken(path, tmp_path / "out", units={"time": "hh:mm"})
    np.testing.assert_allclose(run.time_s - run.time_s[0], MINUTES)


@pytest.mark.parametrize("form", ["%d.%m. %H:%M:%S", "%d %b %H:%M:%S", "%d/%m/ %H:%M:%S"])
def test_an_hour_is_not_taken_for_a_year(form: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected times such as"):
        take(write(tmp_path, moments(lambda at: f"{at:{form}}")), tmp_path / "out")


@pytest.mark.parametrize(
    ("name", "first", "part"),
    [
        ("GPS time (s)", UNIX - 315_964_800 + 18, 1),
        ("gps_ms", (UNIX - 315_964_800 + 18) * 1000, 1000),
        ("ntp_time", UNIX + 2_208_988_800, 1),
        ("time", UNIX + 2_082_844_800, 1),
        ("time", UNIX + 11_644_473_600, 1),
        ("time", (UNIX + 11_644_473_600) * 10**6, 10**6),
        ("time", (UNIX + 11_644_473_600) * 10**7, 10**7),
        ("time", (UNIX + 62_135_596_800) * 10**7, 10**7),
    ],
)
def test_counts_from_other_years_begin_when_they_say(name: str, first: int, part: int, tmp_path: Path) -> None:
    run = taken(write(tmp_path, log([first + int(s) * part for s in MINUTES], name)), tmp_path / "out")
    assert run.comments["started"] == "2026-03-02T08:15:00.000"
    np.testing.assert_allclose(run.time_s, MINUTES, atol=1e-4)


@pytest.mark.parametrize("name", ["time", "MJD"])
def test_modified_julian_days(name: str, tmp_path: Path) -> None:
    days = [f"{(UNIX + int(s)) / 86_400 + 40_587:.8f}" for s in MINUTES]
    run = taken(write(tmp_path, log(days, name)), tmp_path / "out")  # type: ignore[arg-type]
    assert run.comments["started"] == "2026-03-02T08:15:00.000"
    np.testing.assert_allclose(run.time_s, MINUTES, atol=1e-3)


def test_a_count_says_which_day_it_begins_on(tmp_path: Path) -> None:
    found = take(write(tmp_path, log([UNIX + int(s) for s in MINUTES])), tmp_path / "out")
    assert "since 1970: 2026-03-02" in found.guesses().why["time"]
    found = take(write(tmp_path, log([825_754_500 + int(s) for s in MINUTES])), tmp_path / "since_2000")
    assert "since what instant nothing tells" in found.guesses().why["time"]
    assert "started" not in found.runs[0].read_text()


@pytest.mark.parametrize("part", [10**6, 10**9])
def test_steps_of_hours_in_ms_are_of_a_finer_unit(part: int, tmp_path: Path) -> None:
    run = taken(write(tmp_path, log([(30 + int(s)) * part for s in MINUTES])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s - run.time_s[0], MINUTES, atol=1e-6)


def test_steps_of_minutes_in_ms_may_be_of_a_finer_unit(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"6\.667 min in ms, 0\.4 s in us"):
        take(write(tmp_path, log([int(s) // 60 * 400_000 for s in MINUTES])), tmp_path / "out")


@pytest.mark.parametrize("form", ["%I:%M %p", "%I:%M%p"])
def test_halves_of_a_day_without_seconds(form: str, tmp_path: Path) -> None:
    """Over midnight, too: `11:59 PM`, `12:00 AM`."""
    run = taken(write(tmp_path, moments(lambda at: at.strftime(form), before_s=9 * 3600)), tmp_path / "out")
    np.testing.assert_allclose(run.time_s - run.time_s[0], MINUTES)


def test_halves_of_a_day_behind_a_date_in_a_column_of_its_own(tmp_path: Path) -> None:
    moment = [BEGIN + timedelta(seconds=int(s) - 9 * 3600) for s in MINUTES]
    frame = REST.copy()
    frame.insert(0, "time", [at.strftime("%I:%M %p") for at in moment])
    frame.insert(0, "date", [at.strftime("%Y/%m/%d") for at in moment])
    run = taken(write(tmp_path, csv(frame)), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, MINUTES)


@pytest.mark.parametrize("head", ["h,min,s", "hour,minute,second"])
def test_hours_minutes_and_seconds_in_columns_of_their_own(head: str, tmp_path: Path) -> None:
    frame = REST.copy()
    for place, (name, part) in enumerate(zip(head.split(","), ("%H", "%M", "%S"), strict=True)):
        frame.insert(place, name, [int((BEGIN + timedelta(seconds=int(s))).strftime(part)) for s in MINUTES])
    run = taken(write(tmp_path, csv(frame)), tmp_path / "out")
    np.testing.assert_allclose(run.time_s - run.time_s[0], MINUTES)
    assert list(run.extras) == []
