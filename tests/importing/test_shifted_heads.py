"""Headers with one name less than their rows have columns, and those that say what times are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.importing.logs import TRUE, same, taken, write

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


def test_a_mark_behind_each_row_is_no_column(tmp_path: Path) -> None:
    lines = [",".join(NAMES), *(",".join(f"{value:g}" for value in row) + "," for row in KNOWN.to_numpy())]
    run = taken(write(tmp_path, "\n".join(lines)), tmp_path / "out")
    same(run, KNOWN)
    assert run.extras == {}


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
