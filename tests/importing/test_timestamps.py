"""Timestamps and durations of many programs, and what is said of times that are none."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, truth, write

GERMAN = ["Jan.", "Feb.", "März", "Apr.", "Mai", "Juni", "Juli", "Aug.", "Sept.", "Okt.", "Nov.", "Dez."]
FRENCH = ["janv.", "févr.", "mars", "avr.", "mai", "juin", "juil.", "août", "sept.", "oct.", "nov.", "déc."]


@pytest.mark.parametrize(
    "form",
    [
        lambda t: t.strftime("%Y%m%dT%H%M%S.%f"),
        lambda t: t.strftime("%Y%m%d-%H%M%S%f")[:-3],
        lambda t: t.strftime("%Y-%m-%d_%H:%M:%S.%f"),
        lambda t: f"{t.year}/{t.month}/{t.day} {t.hour}:{t:%M:%S.%f}",
        lambda t: f"{t.year}年{t.month}月{t.day}日 {t:%H:%M:%S.%f}",
        lambda t: f"{t:%d}. {GERMAN[t.month - 1]} {t:%Y %H:%M:%S,%f}",
        lambda t: f"{t.day} {FRENCH[t.month - 1]} {t:%Y à %H:%M:%S.%f}",
        lambda t: t.strftime("%d/%b/%Y:%H:%M:%S.%f"),
        lambda t: t.strftime("%b %d, %Y, %I:%M:%S.%f\u202f%p"),
        lambda t: t.strftime("%a, %d %b %Y %H:%M:%S.%f"),
        lambda t: t.strftime("%a %b %d %H:%M:%S.%f %Y"),
        lambda t: t.strftime("%H:%M:%S.%f %d.%m.%Y"),
        lambda t: t.strftime("%Y-%b-%d %H:%M:%S.%f"),
        lambda t: t.strftime("%d.%m.%Y %H:%M:%S.%f Uhr"),
        lambda t: t.strftime("%Y-%m-%d-%H-%M-%S.%f"),
        lambda t: t.strftime("DT#%Y-%m-%d-%H:%M:%S.%f"),
    ],
)
def test_timestamps_of_other_programs(form: Callable[[pd.Timestamp], str], tmp_path: Path) -> None:
    begin = pd.Timestamp("2024-10-27 23:59:30")
    stamps = [form(begin + pd.Timedelta(seconds=s)) for s in TRUE.time_s]
    text = csv(TRUE.assign(time_s=stamps).rename(columns={"time_s": "Timestamp"}), sep=";")
    run = taken(write(tmp_path, text), tmp_path / "r")
    same(run, TRUE)
    assert run.comments["started"] == "2024-10-27T23:59:30.000"


@pytest.mark.parametrize(
    ("zoned", "utc"),
    [
        ("2025-04-03 23:30:00+02", "2025-04-03T21:30:00.000"),
        ("2025-04-03 23:30:00 CEST", "2025-04-03T21:30:00.000"),
        ("20250403T233000Z", "2025-04-03T23:30:00.000"),
        ("Thu Apr 03 2025 23:30:00 GMT+0200 (CEST)", "2025-04-03T21:30:00.000"),
        ("2025-04-03T23:30:00+05:30[Asia/Kolkata]", "2025-04-03T18:00:00.000"),
        ("Thu, 03 Apr 2025 23:30:00 -0700", "2025-04-04T06:30:00.000"),
        ("Thu Apr  3 23:30:00 PDT 2025", "2025-04-04T06:30:00.000"),
    ],
)
def test_instants_with_a_zone_begin_in_utc(zoned: str, utc: str, tmp_path: Path) -> None:
    times = [zoned.replace("30:00", f"30:{k:02d}").replace("233000", f"2330{k:02d}") for k in range(60)]
    assert len(set(times)) == 60
    text = csv(TRUE[:60].assign(time_s=times).rename(columns={"time_s": "Timestamp"}), sep=";")
    run = taken(write(tmp_path, text), tmp_path / "r")
    assert run.comments["started"] == utc
    np.testing.assert_allclose(run.time_s, np.arange(60.0), atol=1e-9)


def test_the_end_of_summer_time_in_letters(tmp_path: Path) -> None:
    begin = pd.Timestamp("2025-10-26T00:59:30Z")
    local = [(begin + pd.Timedelta(seconds=s)).tz_convert("Europe/Berlin") for s in TRUE.time_s]
    stamps = [t.strftime("%Y-%m-%d %H:%M:%S.%f ") + str(t.tzname()) for t in local]
    assert {stamp[-4:].strip() for stamp in stamps} == {"CEST", "CET"}
    same(taken(write(tmp_path, csv(TRUE.assign(time_s=stamps).rename(columns={"time_s": "ts"}))), tmp_path / "r"), TRUE)


def _hms(seconds: float) -> tuple[int, int, float]:
    return int(seconds // 3600), int(seconds // 60 % 60), seconds % 60


@pytest.mark.parametrize(
    "form",
    [
        lambda t: str(pd.Timedelta(seconds=t)),
        lambda t: "{}h{:02d}m{:04.1f}s".format(*_hms(t)),
        lambda t: "{} h {} min {:.1f} s".format(*_hms(t)),
        lambda t: "PT{}H{}M{:.1f}S".format(*_hms(t)),
        lambda t: "1.{:02d}:{:02d}:{:010.7f}".format(*_hms(t)),
        lambda t: f"{int(t // 60)}m{t % 60:.1f}s" if t >= 60 else f"{t:.1f}s",
    ],
)
def test_times_since_a_beginning(form: Callable[[float], str], tmp_path: Path) -> None:
    long = truth(rows=400, step=0.5)
    stamps = [form(float(s) + 3570.0) for s in long.time_s]
    run = taken(write(tmp_path, csv(long.assign(time_s=stamps).rename(columns={"time_s": "elapsed"}))), tmp_path / "r")
    np.testing.assert_allclose(run.time_s - run.time_s[0], long.time_s, atol=1e-9)


@pytest.mark.parametrize("options", [{}, {"time": "Time"}])
def test_a_time_that_is_none_is_shown_with_its_line_and_what_is_read(options: dict[str, str], tmp_path: Path) -> None:
    text = csv(TRUE.assign(time_s=[f"tick {k} of many" for k in range(len(TRUE))]).rename(columns={"time_s": "Time"}))
    with pytest.raises(
        InputError, match=r'line 2, column Time: .*"tick 0 of many", expected times such as 2026-04-03T'
    ):
        take(write(tmp_path, text), tmp_path / "runs", **options)


@pytest.mark.parametrize("factor", [1e3, 1e290])
def test_times_that_no_log_reaches_are_refused(factor: float, tmp_path: Path) -> None:
    """Seconds since 1970 that become milliseconds on the way, and numbers that are no times at all."""
    second = TRUE.time_s + 1.7e9
    ticks = np.where(np.arange(len(TRUE)) < 40, second, second * factor)
    with pytest.raises(InputError, match=r"column time: found (a time|times) of .* expected"):
        take(write(tmp_path, csv(TRUE.assign(time_s=ticks).rename(columns={"time_s": "time"}))), tmp_path / "runs")


def test_a_clock_that_is_set_after_a_while_loses_its_first_rows(tmp_path: Path) -> None:
    """A board that counts from 1970 until it hears what time it is."""
    long = truth(rows=100)
    second = np.where(np.arange(100) < 8, long.time_s, long.time_s + 1.7e9)
    found = take(write(tmp_path, csv(long.assign(time_s=second).rename(columns={"time_s": "time"}))), tmp_path / "runs")
    run = read_run(found.runs[0])
    np.testing.assert_allclose(run.time_s - run.time_s[0], long.time_s[8:] - long.time_s[8], atol=1e-6)
    assert "time more than 30 years from the others, left out" in found.counted().index


@pytest.mark.parametrize(
    ("head", "row", "started", "why"),
    [
        ("Date;Time;PWM;Winding [C]", "{d};{t};{pwm};{comma}", "2026-04-03", "decimal commas and semicolons"),
        ("Datum,Zeit,PWM,Wicklung [C]", "{d},{t},{pwm},{point}", "2026-04-03", "names of no English"),
        ("Date,Time,PWM,Winding [F]", "{d},{t},{pwm},{degF}", "2026-03-04", "the month first, as in logs with degF"),
        ("Date,Time,PWM,Winding [C]", "{d},{t},{pwm},{point}", "2026-03-04", "the month first; if .* --unit Date=dmy"),
        ("Time,PWM,Winding [C]", "{d} {t},{pwm},{point}", "2026-03-04", "the month first; if .* --unit Time=dmy"),
    ],
)
def test_one_date_is_read_as_the_rest_of_the_log_is_written(
    head: str, row: str, started: str, why: str, tmp_path: Path
) -> None:
    lines = [head]
    for i, entry in enumerate(TRUE.itertuples()):
        t = f"10:{10 * i // 60:02d}:{10 * i % 60:02d}"
        values = {
            "comma": str(entry.winding_degC).replace(".", ","),
            "point": entry.winding_degC,
            "degF": 71.5 + i / 10,
        }
        lines.append(row.format(d="03/04/2026", t=t, pwm=entry.pwm, **values))
    found = take(write(tmp_path, "\n".join(lines)), tmp_path / "out")
    assert read_run(found.runs[0]).comments["started"] == f"{started}T10:00:00.000"
    assert re.search(why, " ".join(map(str, found.guesses()["why"])))


def test_durations_of_a_controller(tmp_path: Path) -> None:
    """As IEC 61131 writes them."""
    times = [f"T#{i // 6}m{10 * (i % 6)}s500ms" for i in range(len(TRUE))]
    rows = [f"{t},{row.pwm},{row.winding_degC}" for t, row in zip(times, TRUE.itertuples(), strict=True)]
    run = taken(write(tmp_path, "\n".join(["Time,PWM,Winding [C]", *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(len(TRUE)) + 0.5)


WITHOUT_MARKS: dict[str, Callable[[pd.Timestamp], str]] = {
    "Date,Time": lambda t: t.strftime("%Y%m%d,%H%M%S"),
    "UTC": lambda t: t.strftime("%H%M%S.") + f"{t.microsecond // 10_000:02d}",
    "Time": lambda t: t.strftime("%Y%m%d%H%M%S"),
    "Uhrzeit": lambda t: str(int(t.strftime("%H%M%S"))),  # a spreadsheet drops zeros
}


@pytest.mark.parametrize("head", WITHOUT_MARKS)
def test_times_without_marks_are_no_counts(head: str, tmp_path: Path) -> None:
    """As seconds each minute would last a hundred of them."""
    stamps = pd.Timestamp("2026-03-02 23:50:00") + pd.to_timedelta(10.0 * np.arange(len(TRUE)), unit="s")
    rows = [
        f"{WITHOUT_MARKS[head](t)},{r.pwm},{r.winding_degC}" for t, r in zip(stamps, TRUE.itertuples(), strict=True)
    ]
    run = taken(write(tmp_path, "\n".join([f"{head},PWM,Winding [C]", *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s - run.time_s[0], 10.0 * np.arange(len(TRUE)))
    np.testing.assert_allclose(run.temps["winding"], TRUE["winding_degC"])


def test_seconds_stay_seconds(tmp_path: Path) -> None:
    rows = [f"{100 * i + (i > 60)},{r.pwm},{r.winding_degC}" for i, r in enumerate(TRUE.itertuples())]
    run = taken(write(tmp_path, "\n".join(["Time,PWM,Winding [C]", *rows])), tmp_path / "out", units={"Time": "s"})
    assert run.time_s[-1] == 100 * (len(TRUE) - 1) + 1


@pytest.mark.parametrize("mark", ["-", "/", "."])
def test_a_year_of_two_digits_that_stands_first(mark: str, tmp_path: Path) -> None:
    """Over a midnight, at which the day last would be another year."""
    stamps = pd.Timestamp("2026-03-02 23:50:00") + pd.to_timedelta(10.0 * np.arange(len(TRUE)), unit="s")
    rows = [
        f"{t.strftime(f'%y{mark}%m{mark}%d %H:%M:%S')},{r.pwm},{r.winding_degC}"
        for t, r in zip(stamps, TRUE.itertuples(), strict=True)
    ]
    run = taken(write(tmp_path, "\n".join(["Time,PWM,Winding [C]", *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(len(TRUE)))
    assert run.comments["started"] == "2026-03-02T23:50:00.000"


def test_a_date_of_two_digits_thrice_is_asked_for(tmp_path: Path) -> None:
    rows = [f"24-03-25 10:{i // 6:02d}:{i % 6}0,{r.pwm},{r.winding_degC}" for i, r in enumerate(TRUE.itertuples())]
    log = write(tmp_path, "\n".join(["Time,PWM,Winding [C]", *rows]))
    with pytest.raises(
        InputError, match="the day first, or the year in two digits; settle it by --unit Time=dmy or Time=ymd"
    ):
        take(log, tmp_path / "out")
    assert taken(log, tmp_path / "a", units={"Time": "dmy"}).comments["started"].startswith("2025-03-24")
    assert taken(log, tmp_path / "b", units={"Time": "ymd"}).comments["started"].startswith("2024-03-25")


def test_days_that_go_on_before_a_year_of_two_digits(tmp_path: Path) -> None:
    stamps = pd.Timestamp("2025-03-23 23:50:00") + pd.to_timedelta(10.0 * np.arange(len(TRUE)), unit="s")
    rows = [f"{t:%d-%m-%y %H:%M:%S},{r.pwm},{r.winding_degC}" for t, r in zip(stamps, TRUE.itertuples(), strict=True)]
    run = taken(write(tmp_path, "\n".join(["Time,PWM,Winding [C]", *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(len(TRUE)))


def test_times_that_lost_their_digits_are_told(tmp_path: Path) -> None:
    """A spreadsheet saves milliseconds since 1970 so."""
    rows = [f"1.77244E+12,{r.pwm},{r.winding_degC}" for r in TRUE.itertuples()]
    with pytest.raises(
        InputError, match=r"column Time: does not go on .* were its last digits lost, as in a spreadsheet"
    ):
        take(write(tmp_path, "\n".join(["Time,PWM,Winding [C]", *rows])), tmp_path / "out")
