"""Headers with one name less than their rows have columns, and those that say what times are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, same, taken, write

NAMES = ["time_s", "pwm", "winding_degC"]
KNOWN = TRUE[NAMES]


@pytest.mark.parametrize(("first", "mark", "quote"), [(1, ",", ""), (1, " ", '"'), (0, ";", ""), (1, "\t", '"')])
def test_rows_that_are_counted_before_the_first_name(first: int, mark: str, quote: str, tmp_path: Path) -> None:
    """As R writes tables: without a name for the names of its rows."""
    lines = [mark.join(f"{quote}{name}{quote}" for name in NAMES)]
    lines += [
        mark.join([f"{quote}{first + i}{quote}", *(f"{value:g}" for value in row)])
        for i, row in enumerate(KNOWN.to_numpy())
    ]
    same(taken(write(tmp_path, "\n".join(lines)), tmp_path / "out"), KNOWN)


def test_counted_rows_of_which_two_share_a_time(tmp_path: Path) -> None:
    rows = [f"{i + 1},{time:g},{pwm:g},{winding}" for i, (time, pwm, winding) in enumerate(KNOWN.to_numpy())]
    rows[7] = rows[7].replace(f",{KNOWN['time_s'][7]:g},", f",{KNOWN['time_s'][6]:g},")
    run = taken(write(tmp_path, "\n".join([",".join(NAMES), *rows])), tmp_path / "out")
    assert run.time_s[-1] == KNOWN["time_s"].iloc[-1]
    assert run.pwm[-1] == KNOWN["pwm"].iloc[-1]


def test_a_comma_before_milliseconds(tmp_path: Path) -> None:
    """As Python's logging writes times, in a line that commas part."""
    rows = [
        f"2026-03-02 08:{15 + i // 6:02d}:{10 * (i % 6):02d},{(123 + 7 * i) % 1000:03d},{pwm:g},{winding}"
        for i, (_, pwm, winding) in enumerate(KNOWN.to_numpy())
    ]
    log = write(tmp_path, "\n".join(["time,pwm,winding temp", *rows]))
    run = taken(log, tmp_path / "out", units={"pwm": "counts"})
    np.testing.assert_allclose(run.temps["winding"], KNOWN["winding_degC"])
    steps = 10.0 * np.arange(len(TRUE)) + ((123 + 7 * np.arange(len(TRUE))) % 1000) / 1000
    np.testing.assert_allclose(run.time_s, steps - steps[0], atol=1e-9)


def clocked(mark: str, behind: str, form: str = "%Y-%m-%d %H:%M:%S") -> list[str]:
    """Rows of whole seconds, a PWM and a temperature, with something behind them."""
    times = pd.date_range("2026-03-02 08:15:00", periods=len(TRUE), freq="10s").strftime(form)
    return [
        mark.join([time, f"{pwm:g}", str(winding), behind])
        for time, pwm, winding in zip(times, TRUE["pwm"], TRUE["winding_degC"], strict=True)
    ]


@pytest.mark.parametrize("behind", ["ok", "1", "12.5"])
@pytest.mark.parametrize("last", ["", "MARK"], ids=["without a name", "with an empty one"])
@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("form", ["%Y-%m-%d %H:%M:%S", "%d/%m/%Y %H:%M:%S", "%H:%M:%S"])
def test_a_column_without_a_name_behind_the_others(
    form: str, mark: str, last: str, behind: str, tmp_path: Path
) -> None:
    """Notes, or a status: no name goes to another column, and whole seconds get no fractions of it."""
    head = mark.join(["Time", "PWM", "winding [C]"]) + last.replace("MARK", mark)
    log = write(tmp_path, "\n".join([head, *clocked(mark, behind, form)]))
    run = taken(log, tmp_path / "out", units={"PWM": "counts"})
    assert run.pwm.tolist() == TRUE["pwm"].tolist()
    np.testing.assert_array_equal(run.temps["winding"], TRUE["winding_degC"])
    np.testing.assert_allclose(np.diff(run.time_s), 10.0)


@pytest.mark.parametrize("last", ["", " "], ids=["without a name", "with an empty one"])
def test_a_column_without_a_name_in_a_workbook(last: str, tmp_path: Path) -> None:
    rows = [row.split(",") for row in clocked(",", "ok")]
    frame = pd.DataFrame(rows, columns=["Time", "PWM", "winding [C]", last]).astype({"PWM": int, "winding [C]": float})
    frame.to_excel(tmp_path / "log.xlsx", index=False)
    run = taken(tmp_path / "log.xlsx", tmp_path / "out", units={"PWM": "counts"})
    assert run.pwm.tolist() == TRUE["pwm"].tolist()
    np.testing.assert_array_equal(run.temps["winding"], TRUE["winding_degC"])


def test_a_header_that_counts_like_rows_keeps_its_names(tmp_path: Path) -> None:
    """A second a row, and something behind each: no numbers of rows, for then the next column would rise."""
    rows = [f"{i},{pwm:g},{winding},1" for i, (_, pwm, winding) in enumerate(KNOWN.to_numpy())]
    for last in ("", ","):
        log = write(tmp_path, "\n".join([",".join(NAMES) + last, *rows]))
        run = taken(log, tmp_path / "out", overwrite=True)
        assert run.pwm.tolist() == TRUE["pwm"].tolist()
        np.testing.assert_array_equal(run.time_s, np.arange(len(TRUE)))


def test_a_first_name_that_nobody_knows_is_that_of_the_times(tmp_path: Path) -> None:
    log = write(tmp_path, "\n".join(["Messpunkt,PWM,winding [C]", *clocked(",", "21.5")]))
    run = taken(log, tmp_path / "out", units={"PWM": "counts"})
    assert run.pwm.tolist() == TRUE["pwm"].tolist()
    np.testing.assert_array_equal(run.temps["winding"], TRUE["winding_degC"])


@pytest.mark.parametrize("form", ["%Y-%m-%d %H:%M:%S", "%H:%M:%S"])
@pytest.mark.parametrize("mark", [",", ";"])
def test_times_before_the_first_name(mark: str, form: str, tmp_path: Path) -> None:
    """No name is one of times: it is that of the names of rows that is missing."""
    rows = clocked(mark, "21.5", form)
    head = mark.join(["PWM", "winding [C]", "casing [C]"])
    run = taken(write(tmp_path, "\n".join([head, *rows])), tmp_path / "out", units={"PWM": "counts"})
    assert run.pwm.tolist() == TRUE["pwm"].tolist()
    np.testing.assert_array_equal(run.temps["winding"], TRUE["winding_degC"])
    np.testing.assert_allclose(np.diff(run.time_s), 10.0)


@pytest.mark.parametrize(
    "part",
    [lambda i: 153, lambda i: 153 + i % 2, lambda i: 153 + 29 * i % 847 if i else 7],
    ids=["one", "two", "not of three digits"],
)
def test_what_may_be_milliseconds_or_a_number_of_its_own(part: Callable[[int], int], tmp_path: Path) -> None:
    rows = [
        f"2026-03-02 08:{15 + i // 6:02d}:{10 * (i % 6):02d},{part(i)},{pwm:g},{winding}"
        for i, (_, pwm, winding) in enumerate(KNOWN.to_numpy())
    ]
    with pytest.raises(InputError, match=r"is 2026-03-02 08:15:00,(153|7) one time, .* a point before milliseconds"):
        taken(write(tmp_path, "\n".join(["time,pwm,winding temp", *rows])), tmp_path / "out")


def test_milliseconds_behind_a_time_of_day(tmp_path: Path) -> None:
    """Behind a date in a column of its own."""
    rows = [
        f"2026-03-02,08:{15 + i // 6:02d}:{10 * (i % 6):02d},{(123 + 7 * i) % 1000:03d},{pwm:g},{winding}"
        for i, (_, pwm, winding) in enumerate(KNOWN.to_numpy())
    ]
    log = write(tmp_path, "\n".join(["date,time,pwm,winding temp", *rows]))
    run = taken(log, tmp_path / "out", units={"pwm": "counts"})
    assert run.pwm.tolist() == TRUE["pwm"].tolist()
    np.testing.assert_allclose(np.diff(run.time_s), 10.007, atol=1e-6)


def test_a_space_within_timestamps_among_spaces_between_columns(tmp_path: Path) -> None:
    rows = clocked(" ", "21.5")
    run = taken(write(tmp_path, "\n".join(["t PWM winding casing", *rows])), tmp_path / "out", units={"PWM": "counts"})
    assert run.pwm.tolist() == TRUE["pwm"].tolist()
    np.testing.assert_array_equal(run.temps["winding"], TRUE["winding_degC"])
    assert set(run.temps["casing"]) == {21.5}
    np.testing.assert_allclose(np.diff(run.time_s), 10.0)


def test_a_mark_behind_each_row_is_no_column(tmp_path: Path) -> None:
    lines = [",".join(NAMES), *(",".join(f"{value:g}" for value in row) + "," for row in KNOWN.to_numpy())]
    run = taken(write(tmp_path, "\n".join(lines)), tmp_path / "out")
    same(run, KNOWN)
    assert run.extras == {}


@pytest.mark.parametrize(
    ("head", "mark"),
    [
        ("t [s],PWM,winding, hot spot [C],casing [C]", ","),
        ("Time, s,PWM,winding [C],casing [C]", ","),
        ("t [s];PWM;setpoint [C];winding [C];casing [C]", ";"),
        ("t [s]\tPWM\tfan\twinding [C]\tcasing [C]", "\t"),
        ("t s PWM winding_C casing_C", " "),
        ("t,PWM,winding, hot spot,casing\ns,-,C,C", ","),
        ("t [s],PWM,winding [C],casing [C],status", ","),
    ],
)
def test_a_header_with_a_name_more_than_its_rows_have_fields(head: str, mark: str, tmp_path: Path) -> None:
    frame = TRUE[[*NAMES, "casing_degC"]]
    log = write(tmp_path, head + "\n" + frame.to_csv(index=False, header=False, sep=mark))
    names = ", ".join(name.strip() for name in head.split("\n")[0].split(mark))
    with pytest.raises(InputError) as found:
        taken(log, tmp_path / "out")
    assert found.value.place == "line 1"
    assert found.value.message.startswith(f"found 5 names ({names}) above rows of 4 fields; expected one for each")


@pytest.mark.parametrize("head", ["Comment", "notes", "Remark", ""])
def test_a_name_of_comments_that_no_row_has(head: str, tmp_path: Path) -> None:
    log = write(tmp_path, csv(KNOWN).replace("winding_degC\n", f"winding_degC,{head}\n"))
    same(taken(log, tmp_path / "out"), KNOWN)


def test_a_name_with_the_mark_between_columns_in_quotes(tmp_path: Path) -> None:
    log = write(tmp_path, csv(KNOWN).replace("winding_degC\n", '"winding, hot spot [C]"\n'))
    np.testing.assert_array_equal(taken(log, tmp_path / "out").temps["winding_hot_spot"], KNOWN["winding_degC"])


def test_four_lines_above_the_rows(tmp_path: Path) -> None:
    """Of a Campbell logger: where it is from, names, units, and what was made of an interval."""
    head = [
        '"TOA5","CR1000","CR1000","1","Std.32","CPU:m.CR1","5","T1"',
        '"TIMESTAMP","RECORD","Case","Winding_Avg","PWM"',
    ]
    head += ['"TS","RN","Deg C","Deg F","%"', '"","","Smp","Avg","Smp"']
    rows = [
        f'"2026-03-02 08:{15 + i // 6:02d}:{10 * (i % 6):02d}",{i},{casing},{winding * 1.8 + 32:.2f},{pwm / 2.55:.0f}'
        for i, (pwm, winding, casing) in enumerate(TRUE[["pwm", "winding_degC", "casing_degC"]].to_numpy())
    ]
    run = taken(write(tmp_path, "\n".join(head + rows)), tmp_path / "out")
    np.testing.assert_allclose(run.temps["Winding_Avg"], TRUE["winding_degC"], atol=1e-9)
    assert run.pwm.tolist() == TRUE["pwm"].tolist()


@pytest.mark.parametrize(
    ("head", "step_s"),
    [("Elapsed (hh:mm)", 300), ("Laufzeit [h:mm]", 300), ("Uhrzeit [mm:ss]", 5), ("Time (min:sec)", 5)],
)
def test_a_header_says_whether_it_is_hours_or_minutes(head: str, step_s: int, tmp_path: Path) -> None:
    """Where the texts are the same."""
    rows = [f"{5 * i // 60}:{5 * i % 60:02d},{pwm:g},{winding}" for i, (_, pwm, winding) in enumerate(KNOWN.to_numpy())]
    run = taken(write(tmp_path, "\n".join([f"{head},PWM,winding [C]", *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, step_s * np.arange(len(TRUE)))


@pytest.mark.parametrize("unit", ["F°", "˚F", "∘F", "Â°F", "\ufffdF", "*F", "@F", "Fahr."])
def test_fahrenheit_as_it_comes_out_of_other_encodings(unit: str, tmp_path: Path) -> None:
    frame = KNOWN.assign(winding_degC=(KNOWN["winding_degC"] * 1.8 + 32).round(6))
    text = frame.rename(columns={"winding_degC": f"winding [{unit}]"}).to_csv(index=False)
    same(taken(write(tmp_path, text), tmp_path / "out"), KNOWN)


def test_a_rule_between_names_and_rows(tmp_path: Path) -> None:
    lines = ["time\tpwm\twinding", "s\t-\t°C", "---\t---\t---", *("\t".join(map(str, row)) for row in KNOWN.to_numpy())]
    same(taken(write(tmp_path, "\n".join(lines)), tmp_path / "out", units={"pwm": "counts"}), KNOWN)


def test_hours_of_five_digits(tmp_path: Path) -> None:
    """As a Hioki counts them."""
    rows = [f"{i // 6:05d}:{i % 6}0:00.0,{pwm:g},{winding}" for i, (_, pwm, winding) in enumerate(KNOWN.to_numpy())]
    run = taken(write(tmp_path, "\n".join(["Time,PWM,winding [C]", *rows])), tmp_path / "out")
    np.testing.assert_allclose(run.time_s, 600.0 * np.arange(len(TRUE)))


@pytest.mark.parametrize(
    "first",
    [lambda i: f"{1714684205 + 10 * i}:", lambda i: f"{1714684205 + 10 * i}", lambda i: f"{10.5 * i:g}"],
    ids=["rrdtool", "since 1970", "from 0"],
)
def test_a_number_that_rises_before_the_first_name_is_the_time(first: Callable[[int], str], tmp_path: Path) -> None:
    rows = [f"{first(i)} {pwm:g} {winding}" for i, (_, pwm, winding) in enumerate(KNOWN.to_numpy())]
    for blank in ([], [""]):
        log = write(tmp_path, "\n".join(["duty  winding", *blank, *rows]))
        run = taken(log, tmp_path / "out", units={"duty": "counts"}, overwrite=True)
        assert run.pwm.tolist() == TRUE["pwm"].tolist()
        np.testing.assert_array_equal(run.temps["winding"], TRUE["winding_degC"])
        np.testing.assert_allclose(np.diff(run.time_s), 10.5 if first(1) == "10.5" else 10.0)


def test_words_before_the_first_name_are_not_of_it(tmp_path: Path) -> None:
    rows = [f"S{i:03d} {pwm:g} {winding}" for i, (_, pwm, winding) in enumerate(KNOWN.to_numpy())]
    log = write(tmp_path, "\n".join(["duty winding", *rows]))
    run = taken(log, tmp_path / "out", units={"duty": "counts"}, time="5")
    assert run.pwm.tolist() == TRUE["pwm"].tolist()
    np.testing.assert_array_equal(run.temps["winding"], TRUE["winding_degC"])
