"""Tables in which each channel has times of its own."""

from __future__ import annotations

from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write

BEGIN = pd.Timestamp("2026-11-26 23:55:00")
SLOW = list(range(0, 600, 10))
WARM = [round(20 + 0.05 * t, 2) for t in SLOW]
FAST = list(range(3, 600, 4))
DUTY = [60 if t < 400 else 0 for t in FAST]


def side_by_side(head: str, shown: Callable[[int], str]) -> str:
    """The winding every 10 s, the duty every 4 s: the rows end with the longer one."""
    rows = zip_longest(SLOW, WARM, FAST, DUTY, fillvalue=None)
    lines = []
    for t_slow, warm, t_fast, duty in rows:
        cells = [(shown(t), str(value)) if t is not None else ("", "") for t, value in ((t_slow, warm), (t_fast, duty))]
        lines.append(";".join(cell for pair in cells for cell in pair))
    return "\n".join([head, *lines])


@pytest.mark.parametrize(
    ("head", "shown"),
    [
        ("t1 [s];Winding [°C];t2 [s];Duty [%]", str),
        ("Time [ms];Winding [°C];Time [ms];Duty [%]", lambda t: str(1000 * t)),
        (
            "Time;Winding [°C];Time;Duty [%]",
            lambda t: str(pd.Timestamp("2026-11-26 23:55:00") + pd.Timedelta(seconds=t)),
        ),
    ],
)
def test_each_reading_stays_at_its_time(head: str, shown: Callable[[int], str], tmp_path: Path) -> None:
    found = take(write(tmp_path, side_by_side(head, shown)), tmp_path / "out")
    run = read_run(found.runs[0])
    known = np.isfinite(run.temps["winding"])
    assert run.temps["winding"][known].tolist() == WARM[1:]  # before the first known duty
    assert (run.time_s[known] - run.time_s[known][0]).tolist() == [t - 10 for t in SLOW[1:]]
    begin = run.time_s[known][0] - 10
    assert run.time_s[run.pwm == 0][0] - begin == min(t for t in FAST if t >= 400)
    assert any("with times of its own" in text for text in found.counted().index)


def test_the_same_times_beside_each_channel_change_nothing(tmp_path: Path) -> None:
    pairs = TRUE[["time_s", "pwm"]].copy()
    for name in ("winding_degC", "casing_degC", "ambient_degC"):
        pairs[f"time_{name[0]} [s]"] = TRUE.time_s
        pairs[name] = TRUE[name]
    same(taken(write(tmp_path, csv(pairs)), tmp_path / "out"), TRUE)


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("uptime [s]", TRUE.time_s + 17.25),
        ("time_2 [s]", TRUE.time_s + 17.25),
        ("cpu_time [s]", 0.02 * TRUE.time_s),
    ],
)
def test_another_clock_of_the_same_rows_is_no_channels_own(name: str, other: pd.Series, tmp_path: Path) -> None:
    frame = TRUE[["time_s", "pwm"]].assign(**{name: other, "winding_degC": TRUE.winding_degC})
    found = take(write(tmp_path, csv(frame)), tmp_path / "out", time="time_s")
    same(read_run(found.runs[0]), TRUE[["time_s", "pwm", "winding_degC"]])
    assert not any("times of its own" in text for text in found.counted().index)


def tables(head: str, *columns: list[list[str]]) -> str:
    """Tables beside each other, a blank column between; each ends with its own last row."""
    width = [len(table[0]) for table in columns]
    lines = [
        ",,".join(",".join(row or [""] * n) for row, n in zip(rows, width, strict=True))
        for rows in zip_longest(*columns)
    ]
    return "\n".join([head, *lines]) + "\n"


def of_day(seconds: int) -> str:
    return f"{BEGIN + pd.Timedelta(seconds=seconds):%H:%M:%S}"


@pytest.mark.parametrize("slow_first", [False, True])
@pytest.mark.parametrize(
    ("name", "shown"), [("t [s]", str), ("Time", lambda t: str(BEGIN + pd.Timedelta(seconds=t))), ("Time", of_day)]
)
def test_a_table_beside_another_keeps_its_own_times(
    name: str, shown: Callable[[int], str], slow_first: bool, tmp_path: Path
) -> None:
    fast = [[shown(t), str(pwm), f"{20 + 0.1 * t:.2f}"] for t, pwm in zip(FAST, DUTY, strict=True)]
    slow = [[shown(t), str(warm), "22.5"] for t, warm in zip(SLOW, WARM, strict=True)]
    heads = [f"{name},Duty [%],Winding [°C]", f"{name},Casing [°C],Ambient [°C]"]
    both = (slow, fast) if slow_first else (fast, slow)
    head = ",,".join(reversed(heads) if slow_first else heads)
    found = take(write(tmp_path, tables(head, *both)), tmp_path / "out")
    run = read_run(found.runs[0])
    time = np.round(run.time_s - run.time_s[np.isfinite(run.temps["winding"])][0] + FAST[0])
    known = np.isfinite(run.temps["casing"])
    assert run.temps["casing"][known].tolist() == WARM[1:]  # before the first known duty
    assert time[known].tolist() == SLOW[1:]
    assert time[np.isfinite(run.temps["winding"])].tolist() == FAST
    assert run.pwm[(time >= FAST[0]) & (time < 400)].tolist() == [153] * int((time < 400).sum())
    assert any("with times of its own" in text for text in found.counted().index)


def test_tables_beside_each_other_with_dates_and_times_of_day_in_two_columns(tmp_path: Path) -> None:
    def shown(seconds: int) -> str:
        return f"{BEGIN + pd.Timedelta(seconds=seconds):%d.%m.%Y,%H:%M:%S}"

    fast = [[shown(t), str(pwm), "30.5"] for t, pwm in zip(FAST, DUTY, strict=True)]
    slow = [[shown(t), str(warm)] if t is not None else [",", ""] for t, warm in zip(SLOW, WARM, strict=True)]
    head = "Date,Time,Duty [%],Winding [°C],,Date,Time,Casing [°C]"
    slow += [[",", ""]] * (len(fast) - len(slow))
    run = taken(write(tmp_path, tables(head, fast, slow)), tmp_path / "out")
    known = np.isfinite(run.temps["casing"])
    assert run.temps["casing"][known].tolist() == WARM[1:]
    assert (run.time_s[known] - run.time_s[known][0]).tolist() == [t - 10 for t in SLOW[1:]]


def test_a_row_below_a_table_that_has_no_time_is_counted(tmp_path: Path) -> None:
    fast = [*([str(t), str(pwm), "30.5"] for t, pwm in zip(FAST, DUTY, strict=True)), ["Mean", "40", "30.5"]]
    slow = [[str(t), str(warm)] for t, warm in zip(SLOW, WARM, strict=True)]
    path = write(tmp_path, tables("t [s],Duty [%],Winding [°C],,t [s],Casing [°C]", fast, slow))
    found = take(path, tmp_path / "out")
    assert any("row without a time" in text for text in found.counted().index)


def test_readings_of_one_time_in_a_table_beside_another_are_told(tmp_path: Path) -> None:
    fast = [[str(t), str(pwm), "30.5"] for t, pwm in zip(FAST, DUTY, strict=True)]
    slow = [[str(t), str(warm)] for t, warm in zip(SLOW, WARM, strict=True)]
    path = write(tmp_path, tables("t [s],Duty [%],Winding [°C],,t [s],Casing [°C]", [*fast[:3], *fast[2:]], slow))
    found = take(path, tmp_path / "out")
    assert any("repeated time" in text for text in found.counted().index)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("Time", "Time UTC"),
        ("Time", "Time"),
        ("t [s]", "Time"),
    ],
)
def test_a_second_clock_of_the_same_rows_makes_no_second_table(first: str, second: str, tmp_path: Path) -> None:
    stamps = [str(BEGIN + pd.Timedelta(seconds=t)) for t in SLOW]
    utc = [str(BEGIN + pd.Timedelta(hours=-1, seconds=t)) for t in SLOW]
    utc[7] = ""  # where a receiver had no fix
    begin = stamps if first == "Time" else list(map(str, SLOW))
    rows = [",".join((a, "60", str(warm), b, "21.5")) for a, b, warm in zip(begin, utc, WARM, strict=True)]
    text = "\n".join([f"{first},Duty [%],Winding [°C],{second},Casing [°C]", *rows])
    found = take(write(tmp_path, text), tmp_path / "out")
    run = read_run(found.runs[0])
    assert run.temps["winding"].tolist() == WARM
    assert run.time_s.tolist() == SLOW
    assert not any("times of its own" in text for text in found.counted().index)


def test_a_temperature_called_like_the_time_is_none(tmp_path: Path) -> None:
    rows = [f"{t},60,{warm},21.5" for t, warm in zip(SLOW, WARM, strict=True)]
    run = taken(write(tmp_path, "\n".join(["t,Duty [%],T,casing", *rows])), tmp_path / "out")
    assert run.temps["casing"].tolist() == [21.5] * len(SLOW)
    assert run.time_s.tolist() == SLOW


PLC = """Name\tScope01
File\t
StartRecord\t134401608000000000\tDonnerstag, 26. November 2026\t10:00:00
EndRecord\t134401613990000000\tDonnerstag, 26. November 2026\t10:09:59

Name\tfDuty\tName\tfTempWinding
NetId\t172.16.8.205.1.1\tNetId\t172.16.8.205.1.1
Port\t801\tPort\t801
SampleTime[ms]\t4000\tSampleTime[ms]\t10000
SymbolName\tMAIN.fDuty\tSymbolName\tMAIN.fTempWinding
Data-Type\tADST_REAL32\tData-Type\tADST_REAL32
VariableSize\t4\tVariableSize\t4

"""


@pytest.mark.parametrize("windows", [False, True])
def test_a_scope_of_a_plc_with_a_head_for_each_channel(windows: bool, tmp_path: Path) -> None:
    """As its manual shows it: ms since the record's begin, or 100 ns since 1601."""

    def shown(seconds: int) -> str:
        return str(134_401_608_000_000_000 + seconds * 10**7) if windows else str(1000 * seconds)

    rows = [
        "\t".join((shown(t), str(DUTY[i]), *((shown(SLOW[i]), str(WARM[i])) if i < len(SLOW) else ("", ""))))
        for i, t in enumerate(FAST)
    ]
    head = PLC.replace("SampleTime[ms]\t4000\tSampleTime[ms]\t10000\n", "") if windows else PLC
    path = write(tmp_path, head + "\n".join(rows).replace(".", ",") + "\n", name="scope.csv")
    run = taken(path, tmp_path / "out", units={"fDuty": "percent"})
    known = np.isfinite(run.temps["fTempWinding"])
    assert run.temps["fTempWinding"][known].tolist() == WARM[1:]
    np.testing.assert_allclose(np.diff(run.time_s[known]), 10.0, atol=1e-6)
    if windows:
        assert run.comments["started"].startswith("2026-11-26T10:00:00")


def of_labview(
    cells: Callable[[int], list[str]], said: dict[str, list[str]], names: tuple[str, ...] = ("PWM", "Winding", "Casing")
) -> str:
    """A measurement file whose channels have X columns of their own."""
    head = ["LabVIEW Measurement\t", "Separator\tTab", "X_Columns\tMulti", "***End_of_Header***\t", "\t"]
    head += ["\t".join([key, *texts, ""]) for key, texts in said.items()]
    head += ["X0\t0.0\t0.0\t0.0\t", "Delta_X\t10.0\t10.0\t10.0\t", "***End_of_Header***\t\t\t\t"]
    head += ["\t".join(f"X_Value\t{name}" for name in names) + "\tComment"]
    return "\n".join([*head, *("\t".join(cells(i)) for i in range(len(TRUE)))])


SAID = {"Channels": ["3"], "Y_Unit_Label": ["%", "Deg F", "Deg C"], "X_Dimension": ["Time"] * 3}


def channels(i: int, rates: tuple[int, int, int] = (1, 1, 1), apart_s: float = 0.0) -> list[str]:
    """One row of three channels, of which each tells its times."""
    cells = []
    shown = (TRUE.pwm / 2.55, TRUE.winding_degC * 1.8 + 32, TRUE.casing_degC)
    for k, (values, rate) in enumerate(zip(shown, rates, strict=True)):
        known = rate * i < len(TRUE)
        time = 10 * rate * i + k * apart_s
        cells += [f"{time:.6f}", f"{values[rate * i]:.6f}"] if known else ["", ""]
    return cells


def test_x_columns_of_one_rate_and_units_of_channels(tmp_path: Path) -> None:
    run = taken(write(tmp_path, of_labview(channels, SAID)), tmp_path / "out")
    assert run.pwm.tolist() == TRUE.pwm.tolist()
    np.testing.assert_allclose(run.temps["winding"], TRUE.winding_degC, atol=1e-6)
    np.testing.assert_allclose(run.temps["casing"], TRUE.casing_degC)
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(len(TRUE)))


@pytest.mark.parametrize("units", [["%", "Deg F", "Deg C"], []])
def test_x_columns_of_several_rates(units: list[str], tmp_path: Path) -> None:
    text = of_labview(
        lambda i: channels(i, (1, 2, 3)), SAID | {"Y_Unit_Label": units}, ("PWM [%]", "Winding [degF]", "Casing")
    )
    run = taken(write(tmp_path, text), tmp_path / "out")
    assert run.pwm.tolist() == TRUE.pwm.tolist()
    for name, rate in (("winding", 2), ("casing", 3)):
        known = np.isfinite(run.temps[name])
        assert np.flatnonzero(known).tolist() == list(range(0, len(TRUE), rate))
        np.testing.assert_allclose(run.temps[name][known], TRUE[f"{name}_degC"][::rate], atol=1e-6)


def test_x_columns_of_channels_that_are_read_one_after_the_other(tmp_path: Path) -> None:
    """A row for each time, unless they differ by next to nothing."""
    run = taken(write(tmp_path, of_labview(lambda i: channels(i, apart_s=1.5), SAID)), tmp_path / "out")
    assert run.time_s[:4].tolist() == [0.0, 1.5, 3.0, 10.0]
    assert run.temps["casing"][2::3].tolist() == TRUE.casing_degC.tolist()
    at_once = of_labview(lambda i: channels(i, apart_s=0.001), SAID)
    assert taken(write(tmp_path, at_once), tmp_path / "out", overwrite=True).time_s.size == len(TRUE)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ({"Time": ["09:15:00", "09:15:00", "09:16:00"]}, "Time is 09:15:00 of one and 09:16:00 of another"),
        ({"X_Dimension": ["Frequency"] * 3}, "found Frequency in X_Value, expected times"),
    ],
)
def test_x_columns_that_are_no_times_from_one_beginning(
    said: dict[str, list[str]], message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message):
        take(write(tmp_path, of_labview(channels, SAID | said)), tmp_path / "out")


def test_x_and_y_of_each_channel(tmp_path: Path) -> None:
    lines = ["PWM X,PWM Y,Winding X,Winding Y,Casing X,Casing Y", "s,%,s,°F,s,°C"]
    lines += [",".join(channels(i, (1, 2, 3))) for i in range(len(TRUE))]
    run = taken(write(tmp_path, "\n".join(lines)), tmp_path / "out")
    assert run.pwm.tolist() == TRUE.pwm.tolist()
    known = np.isfinite(run.temps["winding_y"])
    np.testing.assert_allclose(run.temps["winding_y"][known], TRUE.winding_degC[::2], atol=1e-6)
    np.testing.assert_allclose(run.time_s[known], 20.0 * np.arange(len(TRUE) // 2))
