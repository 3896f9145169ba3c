"""Tables in which each channel has times of its own."""

from __future__ import annotations

from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

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
