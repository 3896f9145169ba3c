"""Headers further down in a file, whose columns may be others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write

HALF = len(TRUE) // 2
COUNTS = {"pwm": "counts"}


def below_each_other(*frames: pd.DataFrame) -> str:
    return "".join(map(csv, frames))


@pytest.mark.parametrize("order", [[0, 1, 3, 2, 4], [4, 3, 2, 1, 0]])
def test_rows_below_a_header_in_another_order_are_taken_by_its_names(order: list[int], tmp_path: Path) -> None:
    second = TRUE.iloc[HALF:, order]
    found = take(write(tmp_path, below_each_other(TRUE[:HALF], second)), tmp_path / "out", units=COUNTS)
    same(read_run(found.runs[0]), TRUE)
    assert any("header with its columns in another order" in text for text in found.counted().index)


def test_a_clock_that_begins_anew_below_such_a_header_makes_two_runs(tmp_path: Path) -> None:
    turned = TRUE[["time_s", "pwm", "casing_degC", "winding_degC", "ambient_degC"]]
    found = take(write(tmp_path, below_each_other(TRUE, turned)), tmp_path / "out", units=COUNTS, split=True)
    for path in found.runs:
        same(read_run(path), TRUE)
    assert len(found.runs) == 2


@pytest.mark.parametrize("at", [20, 60, 100])
def test_a_column_that_comes_later_is_empty_above(at: int, tmp_path: Path) -> None:
    """Whether fewer, as many or more rows stand below the header that has it."""
    first, second = TRUE.drop(columns="casing_degC")[:at], TRUE[at:]
    found = take(write(tmp_path, below_each_other(first, second)), tmp_path / "out", units=COUNTS)
    run = read_run(found.runs[0])
    same(run, TRUE.drop(columns="casing_degC"))
    np.testing.assert_array_equal(np.isnan(run.temps["casing"]), np.arange(len(TRUE)) < at)
    np.testing.assert_array_equal(run.temps["casing"][at:], TRUE.casing_degC[at:])
    assert any("header with more or fewer columns" in text for text in found.counted().index)


def test_a_column_that_goes_is_empty_below_and_rows_of_another_width_are_counted(tmp_path: Path) -> None:
    text = below_each_other(TRUE[:HALF], TRUE[HALF:].drop(columns="casing_degC")) + "99,1,2,3,4\n"
    found = take(write(tmp_path, text), tmp_path / "out", units=COUNTS)
    run = read_run(found.runs[0])
    same(run, TRUE.drop(columns="casing_degC"))
    assert np.isnan(run.temps["casing"][HALF:]).all()
    assert any("no row of 4 columns" in text for text in found.counted().index)


@pytest.mark.parametrize(
    ("names", "shown"),
    [
        ({"winding_degC": "winding_degF"}, "winding_degF, where that of line 1 names winding_degC"),
        ({"winding_degC": "T1", "casing_degC": "T2"}, "T1, T2, where that of line 1 names winding_degC, casing_degC"),
    ],
)
def test_a_header_of_other_units_or_names_is_refused_with_its_line(
    names: dict[str, str], shown: str, tmp_path: Path
) -> None:
    parts = [csv(TRUE[:HALF]), csv(TRUE[HALF:].rename(columns=names))]
    path = write(tmp_path, "".join(parts))
    with pytest.raises(InputError, match=shown) as caught:
        take(path, tmp_path / "out", units=COUNTS)
    assert f"line {HALF + 2}" in str(caught.value)
    assert "a file of their own" in str(caught.value)
    same(taken(write(tmp_path, parts[0], name="first.csv"), tmp_path / "first", units=COUNTS), TRUE[:HALF])


def test_another_table_below_is_refused(tmp_path: Path) -> None:
    warm, driven = TRUE[["time_s", "winding_degC", "ambient_degC"]], TRUE[["time_s", "pwm"]].assign(current_A=0.5)
    text = f"Table 1: temperatures\n{csv(warm)}\nTable 2: the drive\n{csv(driven)}"
    with pytest.raises(InputError, match=r"names pwm, current_A, where that of line 2 names winding_degC, ambient"):
        take(write(tmp_path, text), tmp_path / "out", input="153", split=True)


def test_units_below_a_header_go_with_its_columns(tmp_path: Path) -> None:
    name = {"time_s": "t", "winding_degC": "winding", "casing_degC": "casing", "ambient_degC": "ambient"}
    plain = TRUE.rename(columns=name)
    rows = csv(plain[:HALF], header=False), csv(plain[HALF:][["t", "pwm", "casing", "winding", "ambient"]])
    text = f"t,pwm,winding,casing,ambient\ns,counts,degC,degC,degC\n{rows[0]}{rows[1]}"
    same(taken(write(tmp_path, text), tmp_path / "out"), TRUE)
    other = text.replace("t,pwm,casing,winding,ambient\n", "t,pwm,casing,winding,ambient\ns,counts,degF,degF,degC\n")
    with pytest.raises(InputError, match="names casing degF, winding degF, where"):
        take(write(tmp_path, other), tmp_path / "other")


@pytest.mark.parametrize("line", ["Motor,stopped,by,the,user", "time_s,pwm,winding_degC,casing_degC,ambient_degC", "#"])
def test_other_lines_between_rows_change_nothing(line: str, tmp_path: Path) -> None:
    rows = csv().splitlines()
    text = "\n".join([*rows[:HALF], line, *rows[HALF:]]) + "\n"
    same(taken(write(tmp_path, text), tmp_path / "out", units=COUNTS), TRUE)


def test_a_preamble_of_its_own_columns_is_no_earlier_header(tmp_path: Path) -> None:
    text = f"Samples,Interval\n120,0.5\nChannel,Name\n1,Winding\n\n{csv()}"
    same(taken(write(tmp_path, text), tmp_path / "out", units=COUNTS), TRUE)


@pytest.mark.parametrize(
    "table",
    [
        "Time,Event\n12.5,started by the user\n40.0,stopped by the user\n",
        "Part,Max\nWinding,60.1\nCasing,33.2\n",
        "winding_degC,Max\n21.5,60.1\n",
    ],
)
@pytest.mark.parametrize("above", [False, True])
def test_a_table_that_is_no_log_above_or_below_one_changes_nothing(table: str, above: bool, tmp_path: Path) -> None:
    text = f"{table}\n{csv()}" if above else f"{csv()}\n{table}"
    found = take(write(tmp_path, text), tmp_path / "out", units=COUNTS)
    same(read_run(found.runs[0]), TRUE)
    assert above or any("no row of 5 columns" in what for what in found.counted().index)


def test_events_of_as_many_columns_below_a_log_are_refused(tmp_path: Path) -> None:
    text = f"{csv()}time_s,User,Event,Value,Comment\n12.5,Ann,started,3,none\n14,Ann,speed,5,none\n"
    with pytest.raises(InputError, match="names User, Event, Value, Comment, where that of line 1 names pwm, winding"):
        take(write(tmp_path, text), tmp_path / "out", units=COUNTS)
