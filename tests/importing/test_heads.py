"""What stands above a table: lines that say what they hold, units below names, and the unit of each reading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.importing.reading.encoding import decode
from gen.importing.reading.rows.heads import with_labels
from tests.importing.logs import TRUE, taken, write

STAMPS = [str(pd.Timestamp("2026-11-26 10:00:00") + pd.Timedelta(seconds=2 * s)) for s in TRUE.time_s]
ITS = list(zip(TRUE.time_s, TRUE.pwm / 2.55, TRUE.winding_degC, TRUE.casing_degC, TRUE.ambient_degC, strict=True))
ROWS = list(zip(STAMPS, TRUE.pwm / 2.55, TRUE.winding_degC, TRUE.ambient_degC, strict=True))

RECORDER = """YREC
Measure Data\tVersion 1.00.00
Model\tMV1000
Serial No.\tS5E701234
Sampling Interval\t1000\tms
Ch\tCH001\tCH001\tCH002\tCH002\tCH003\tMessage
Tag\tWinding\tWinding\tAmbient\tAmbient\tDuty\t
Unit\t°C\t°C\t°C\t°C\t%\t
Type\tMEAS\tMEAS\tMEAS\tMEAS\tMEAS\tMessage
Kind\tMIN\tMAX\tMIN\tMAX\tMAX\tCount
Sampling Data
"""


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252", "cp932"])
def test_lines_that_say_what_they_hold(encoding: str, tmp_path: Path) -> None:
    """A recorder's file, as its manual describes it: names and units above lines of other things."""
    rows = "".join(
        f"{at.replace('-', '/')}\t{w - 0.1:.1f}\t{w:.1f}\t{a:.1f}\t{a:.1f}\t{d:.1f}\t0\n" for at, d, w, a in ROWS
    )
    run = taken(write(tmp_path, RECORDER + rows, encoding, name="log.txt"), tmp_path / "out")
    assert set(run.temps) == {"winding_max"}
    np.testing.assert_array_equal(run.temps["winding_max"], TRUE.winding_degC)
    np.testing.assert_array_equal(run.ambient, TRUE.ambient_degC)
    np.testing.assert_array_equal(run.pwm, TRUE.pwm)


LOGGER = """Vendor,GRAPHTEC Corporation
Model,GL240
Sampling interval,1s
AMP settings
CH,Signal name,Input,Range,Filter,Span
CH1,Winding,TEMP,TC_K,Off,2000,-200,degC
CH2,Ambient,TEMP,TC_K,Off,2000,-200,degC
Data
Number,Date&Time,ms,CH1,CH2,PWM,Alarm1-10,AlarmOut
NO.,Time,ms,degC,degC,%,A1234567890,A1234
"""


def test_units_below_names_where_less_than_half_have_one(tmp_path: Path) -> None:
    rows = "".join(
        f"{i + 1},{at.replace('-', '/')},0,+   {w:.1f},+   {a:.1f},+   {d:.1f},LLLLLLLLLL,LLLL\n"
        for i, (at, d, w, a) in enumerate(ROWS)
    )
    run = taken(write(tmp_path, LOGGER + rows), tmp_path / "out")
    np.testing.assert_array_equal(run.temps["ch1_winding"], TRUE.winding_degC)  # by the list of channels
    np.testing.assert_array_equal(run.ambient, TRUE.ambient_degC)
    np.testing.assert_array_equal(run.pwm, TRUE.pwm)


def test_the_unit_of_each_reading_behind_it(tmp_path: Path) -> None:
    """As loggers with a memory card write; the same in all rows."""
    head = "Position\tDate\tTime\tCh1_Value\tCh1_Unit\tCh2_Value\tCh2_Unit\tPWM\tPWM_Unit\n"
    rows = "".join(
        f"{i + 1}\t{at[:10]}\t{at[11:]}\t{w:.1f}\tDegree C\t{a * 1.8 + 32:.2f}\tDegree F\t{d:.1f}\t%\n"
        for i, (at, d, w, a) in enumerate(ROWS)
    )
    run = taken(write(tmp_path, head + rows, name="log.xls"), tmp_path / "out")
    np.testing.assert_array_equal(run.temps["Ch1_Value"], TRUE.winding_degC)
    np.testing.assert_allclose(run.temps["Ch2_Value"], TRUE.ambient_degC, atol=1e-9)
    np.testing.assert_array_equal(run.pwm, TRUE.pwm)


def test_a_header_below_a_preamble_is_no_noise() -> None:
    """Its letters beyond ASCII stand in one line, as a serial line's broken byte does."""
    rows = "\n".join(f"{i};20,5" for i in range(200))
    head = "\n".join(f"Zeile {i}" for i in range(12))
    for encoding in ("cp1252", "cp437", "cp932"):
        text = f"{head}\nt;T Wicklung\ns;°C\n{rows}"
        assert decode(text.encode(encoding))[0] == text
    broken = f"{head}\nt;T Wicklung\n{rows}".encode().replace(b"57;20,5", b"57;2\xe4,5")
    assert decode(broken)[1] == "utf-8"


def test_a_list_of_channels_names_columns_only_where_it_says_different_things_of_several() -> None:
    names = ["Number", "CH1", "CH2"]
    lists = [["CH1", "Winding", "TEMP"], ["CH2", "Room", "TEMP"]]
    assert with_labels(names, lists) == ["Number", "CH1 Winding", "CH2 Room"]
    for other in ([["CH1", "TEMP"], ["CH2", "TEMP"]], lists[:1], [["CH1", "20.5"], ["CH2", "21.5"]], lists * 2):
        assert with_labels(names, other) == names


def test_lines_that_say_what_they_hold_are_no_rows(tmp_path: Path) -> None:
    """As LabVIEW's groups of channels are written into CSV."""
    head = "Group,Measurements,,\nChannel,Time,Winding,PWM\nUnit,s,°C,%\nWf_increment,10,10,10\n"
    values = zip(TRUE["winding_degC"], TRUE["pwm"] / 2.55, strict=True)
    rows = "".join(f",{10 * i},{winding},{duty:.1f}\n" for i, (winding, duty) in enumerate(values))
    run = taken(write(tmp_path, head + rows), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 10.0 * np.arange(len(TRUE)))
    np.testing.assert_allclose(run.temps["winding"], TRUE["winding_degC"])


def test_labels_of_queries_name_the_parts(tmp_path: Path) -> None:
    """As Grafana exports a table of two series of one metric."""
    head = 'sep=,\n"Time","motor_temp{job=""m"",part=""winding""}","motor_temp{job=""m"",part=""casing""}",motor_pwm\n'
    values = zip(TRUE["winding_degC"], TRUE["casing_degC"], TRUE["pwm"], strict=True)
    rows = "".join(f"2026-03-02 08:{i // 6:02d}:{i % 6}0,{w},{c},{p}\n" for i, (w, c, p) in enumerate(values))
    run = taken(write(tmp_path, head + rows), tmp_path / "out", units={"motor_pwm": "counts"})
    np.testing.assert_allclose(run.temps["winding"], TRUE["winding_degC"])
    np.testing.assert_allclose(run.temps["casing"], TRUE["casing_degC"])


def test_channels_that_are_called_by_numbers_are_a_header(tmp_path: Path) -> None:
    """Of a controller's registers."""
    values = zip(TRUE["winding_degC"], TRUE["pwm"], strict=True)
    rows = "".join(f"{10 * i},{w},{p}\n" for i, (w, p) in enumerate(values))
    log = write(tmp_path, "time,40001,40002\n" + rows)
    run = taken(
        log,
        tmp_path / "out",
        units={"time": "s", "40002": "counts"},
        input="40002",
        columns={"40001": "winding_degC"},
        full_scale=255.0,
    )
    np.testing.assert_allclose(run.temps["winding"], TRUE["winding_degC"])
    assert run.pwm.tolist() == TRUE["pwm"].tolist()


@pytest.mark.parametrize(
    ("groups", "names"),
    [
        ("Time [s],Motor,,,Room", ",Duty [%],Winding [°C],Casing [°C],Temperature [°C]"),  # cells that were merged
        ("Time,Drive,Winding,Casing,Ambient", "t [s],PWM [%],T [°C],T [°C],T [°C]"),
        ("Elapsed [s],PWM [%],Winding,Casing,Ambient", ",,Temp [°C],Temp [°C],Temp [°C]"),
    ],
)
def test_a_name_that_says_little_has_its_group_s(groups: str, names: str, tmp_path: Path) -> None:
    rows = "".join(",".join(f"{value:g}" for value in row) + "\n" for row in ITS)
    run = taken(write(tmp_path, f"{groups}\n{names}\n{rows}"), tmp_path / "out")
    assert [name.split("_")[0] for name in run.temps] == ["winding", "casing"]
    np.testing.assert_array_equal(run.temps[next(iter(run.temps))], TRUE.winding_degC)
    assert run.ambient is not None
    np.testing.assert_array_equal(run.ambient, TRUE.ambient_degC)
    np.testing.assert_array_equal(run.pwm, TRUE.pwm)
    np.testing.assert_array_equal(run.time_s, TRUE.time_s)
