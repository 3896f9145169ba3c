"""Times whose parts stand in columns of their own: fractions of seconds, minutes and seconds, the parts of dates."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, same, take, taken, truth, write


@pytest.mark.parametrize(
    ("head", "scale", "form"),
    [
        ("Date&Time,ms", 1000, "%Y/%m/%d %H:%M:%S"),  # of a Graphtec
        ("Date&Time,ms,PWM,Winding\nTime,ms,,degC", 1000, "%Y/%m/%d %H:%M:%S"),
        ("Date,Time,Millitm", 1000, "%m/%d/%Y,%H:%M:%S"),  # of FactoryTalk
        ("Date,Time,sec", 1, "%Y/%m/%d,%I:%M:%S %p"),
    ],
)
def test_fractions_of_a_second_in_a_column_of_their_own(head: str, scale: int, form: str, tmp_path: Path) -> None:
    """Ten rows a second, whose times of whole seconds repeat."""
    rows = []
    for i, entry in enumerate(truth().itertuples()):
        at = pd.Timestamp("2024-03-25 23:59:55.3") + pd.Timedelta(seconds=0.1 * i)
        part = round(at.microsecond / 1e6 * scale, 3)
        rows.append(f"{at.strftime(form)},{part:g},{entry.pwm},{entry.winding_degC}")
    head = head if "PWM" in head else f"{head},PWM,Winding [C]"
    run = taken(write(tmp_path, "\n".join([head, *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 0.1 * np.arange(len(truth())), atol=1e-9)
    assert run.comments["started"] == "2024-03-25T23:59:55.300"
    assert list(run.extras) == []


def test_fractions_that_rows_of_one_time_share(tmp_path: Path) -> None:
    """A row for each tag, as FactoryTalk's historian writes them; the program stands in brackets before each."""
    rows = ["Date,Time,Millitm,Tagname,Value,Status,Marker"]
    for i, entry in enumerate(truth().itertuples()):
        at = pd.Timestamp("2024-05-02 23:10:03.031") + pd.Timedelta(seconds=5.031 * i)
        stamp = f"{at:%m/%d/%Y,%H:%M:%S},{at.microsecond // 1000}"
        rows += [f"{stamp},[PLC]Motor.WindingTemp,{entry.winding_degC},,", f"{stamp},[PLC]Drive.DutyPct,{entry.pwm},,"]
    log = write(tmp_path, "\n".join(rows).replace(",204,", ",80,"))
    run = taken(log, tmp_path / "out", series="Tagname")
    np.testing.assert_allclose(run.time_s, 5.031 * np.arange(len(truth())), atol=1.1e-3)
    assert run.pwm.max() == 204
    assert list(run.extras) == []


@pytest.mark.parametrize(
    ("head", "scale"),
    [
        ("header.stamp.secs,header.stamp.nsecs", 10**9),  # of ROS
        ("stamp_sec,stamp_nanosec", 10**9),
        ("tv_sec,tv_usec", 10**6),
        ("Timestamp,Timestamp_ms", 10**3),
        ("Epoch (s),Fraction (ms)", 10**3),
        ("millis,unix", 10**3),
        ("seconds,hundredths", 10**2),
    ],
)
@pytest.mark.parametrize("since", [1_795_687_200, 0])
def test_fractions_of_seconds_that_are_counted(head: str, scale: int, since: int, tmp_path: Path) -> None:
    """A second and a quarter from row to row; of whole seconds alone four rows in five would be off."""
    rows = []
    for i, entry in enumerate(truth().itertuples()):
        second, part = divmod(5 * i, 4)
        pair = (since + second, part * scale // 4)
        shown = pair if not head.startswith("millis") else pair[::-1]
        rows.append(f"{shown[0]},{shown[1]},{entry.pwm},{entry.winding_degC}")
    run = taken(write(tmp_path, "\n".join([f"{head},PWM,Winding [C]", *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 1.25 * np.arange(len(truth())), atol=1e-6)
    assert list(run.extras) == []


def test_fractions_far_from_their_times_are_taken_where_they_make_these_even(tmp_path: Path) -> None:
    def logged(parts: Sequence[int]) -> Path:
        rows = [
            f"{1_795_687_200 + 5 * i // 4},{entry.pwm},{entry.winding_degC},{part}"
            for i, (entry, part) in enumerate(zip(truth().itertuples(), parts, strict=True))
        ]
        return write(tmp_path, "\n".join(["time,PWM,Winding [C],ms", *rows]))

    count = len(truth())
    run = taken(logged([250 * (i % 4) for i in range(count)]), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 1.25 * np.arange(count), atol=1e-6)
    run = taken(logged([40 + i % 3 for i in range(count)]), tmp_path / "took")  # what a loop took
    np.testing.assert_allclose(run.time_s, 5 * np.arange(count) // 4)
    assert list(run.extras) == ["ms"]


@pytest.mark.parametrize(
    ("head", "seconds"), [("Year,Month,Day,Hour,Minute,Second", True), ("Jahr,Monat,Tag,Stunde,Minute", False)]
)
def test_the_parts_of_a_date_in_columns_of_their_own(head: str, seconds: bool, tmp_path: Path) -> None:
    step = 10.5 if seconds else 60.0
    rows = []
    for i, entry in enumerate(truth().itertuples()):
        at = pd.Timestamp("2024-12-31 23:50:00") + pd.Timedelta(seconds=step * i)
        second = f"{at.second + at.microsecond / 1e6:g}," if seconds else ""
        rows.append(f"{at.year},{at.month},{at.day},{at.hour},{at.minute},{second}{entry.pwm},{entry.winding_degC}")
    run = taken(write(tmp_path, "\n".join([f"{head},PWM,Winding [C]", *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, step * np.arange(len(truth())))
    assert run.comments["started"] == "2024-12-31T23:50:00.000"
    assert list(run.extras) == []


@pytest.mark.parametrize("decimal", [".", ","])
def test_minutes_and_seconds_in_columns_of_their_own(decimal: str, tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=TRUE.time_s * 3.0)
    frame.insert(0, "sec", frame.time_s % 60.0)
    frame.insert(0, "min", (frame.time_s // 60.0).astype(int))
    shown = csv(frame.drop(columns="time_s"), sep=";", decimal=decimal)
    same(taken(write(tmp_path, shown), tmp_path / "out"), TRUE.assign(time_s=TRUE.time_s * 3.0))


@pytest.mark.parametrize("head", ["latency (ms)", "ms"])
def test_milliseconds_that_are_none_of_the_time(head: str, tmp_path: Path) -> None:
    """What a loop took, beside times of a coarse clock."""
    rows = [f"08:00:{i // 4:02d},{40 + i % 3},{e.pwm},{e.winding_degC}" for i, e in enumerate(truth().itertuples())]
    log = write(tmp_path, "\n".join([f"Time,{head},PWM,Winding [C]", *rows]))
    with pytest.raises(InputError, match="repeat the time of the row before; expected --duplicates"):
        take(log, tmp_path / "out")
