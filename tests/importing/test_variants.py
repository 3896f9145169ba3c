"""One log in many dialects of delimited text: the same numbers come back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.coefficients.names import name_fault
from gen.errors import InputError
from gen.importing.guessing.names import component_name
from gen.importing.table import unique_names
from gen.runs import read_run
from tests.importing.logs import TRUE, csv, same, take, taken, write


def test_a_run_file_comes_back_as_it_is(tmp_path: Path) -> None:
    path = write(tmp_path, "# motor: bench 3\n" + csv())
    run = taken(path, tmp_path / "runs")
    same(run, TRUE)
    assert run.comments["motor"] == "bench 3"
    assert run.comments["imported_from"] == "log.csv"


def test_a_byte_order_mark(tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv(), "utf-8-sig"), tmp_path / "runs"), TRUE)


@pytest.mark.parametrize("ends", ["\r\n", "\r", "\n\n"])
def test_line_ends(ends: str, tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv().replace("\n", ends)), tmp_path / "runs"), TRUE)


def test_other_names_of_columns(tmp_path: Path) -> None:
    heads = ["Elapsed (s)", "PWM [counts]", "Winding Temp (°C)", "T_casing [°C]", "Room (°C)"]
    same(taken(write(tmp_path, csv(TRUE.set_axis(heads, axis=1))), tmp_path / "runs"), TRUE)


def test_semicolons_and_decimal_commas(tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv(sep=";", decimal=",")), tmp_path / "runs"), TRUE)


def test_german_names_in_cp1252(tmp_path: Path) -> None:
    heads = ["Zeit [s]", "PWM", "Temperatur Wicklung [°C]", "Temperatur Gehäuse [°C]", "Umgebung [°C]"]
    path = write(tmp_path, csv(TRUE.set_axis(heads, axis=1), sep=";", decimal=","), "cp1252")
    names = {"winding_degC": "wicklung_degC", "casing_degC": "gehaeuse_degC"}
    same(taken(path, tmp_path / "runs"), TRUE, names)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_wide_encodings(encoding: str, tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv(sep="\t"), encoding), tmp_path / "runs"), TRUE)


def test_nan_words_and_text_are_missing_and_counted(tmp_path: Path) -> None:
    frame = TRUE.astype({"winding_degC": object})
    for row, word in ((3, "nan"), (4, "NaN"), (5, "--"), (6, "n/a"), (7, "ERR"), (8, "open circuit")):
        frame.loc[row, "winding_degC"] = word
    found = take(write(tmp_path, csv(frame)), tmp_path / "runs")
    true = TRUE.copy()
    true.loc[3:8, "winding_degC"] = np.nan
    same(read_run(found.runs[0]), true)
    counted = found.counted()
    assert counted.loc['word for "no number", left empty', "count"] == 4
    assert counted.loc["text in a number's field, left empty", "count"] == 2
    assert counted.loc["text in a number's field, left empty", "first"] == "line 9, column winding_degC"


def test_a_row_of_units_below_the_header(tmp_path: Path) -> None:
    heads = ["Time", "PWM", "Winding", "Casing", "Ambient"]
    lines = csv(TRUE.set_axis(heads, axis=1)).splitlines()
    lines.insert(1, "s,counts,°C,°C,°C")
    same(taken(write(tmp_path, "\n".join(lines)), tmp_path / "runs"), TRUE)


def test_a_preamble_and_comments(tmp_path: Path) -> None:
    text = "Logger XY-200\nSerial;1234\n\n% made on the bench\n" + csv(sep=";")
    same(taken(write(tmp_path, text), tmp_path / "runs"), TRUE)


def test_a_header_in_a_comment_as_numpy_writes_it(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    np.savetxt(path, TRUE.to_numpy(), header=" ".join(TRUE.columns), fmt="%.6g")
    same(taken(path, tmp_path / "runs"), TRUE)


@pytest.mark.parametrize("mark", [",", "|", "\t", ";", " "])
def test_delimiters(mark: str, tmp_path: Path) -> None:
    same(taken(write(tmp_path, csv(sep=mark)), tmp_path / "runs"), TRUE)


def test_quotes_and_thousands(tmp_path: Path) -> None:
    frame = TRUE.assign(time_s=[f"{s + 1000:,.1f}" for s in TRUE.time_s])
    run = taken(write(tmp_path, csv(frame, quoting=1)), tmp_path / "runs")
    same(run, TRUE.assign(time_s=TRUE.time_s + 1000))


def test_points_for_thousands_and_decimal_commas(tmp_path: Path) -> None:
    german = [f"{s + 1000:,.1f}".translate(str.maketrans(",.", ".,")) for s in TRUE.time_s]
    run = taken(write(tmp_path, csv(TRUE.assign(time_s=german), sep=";", decimal=",")), tmp_path / "runs")
    same(run, TRUE.assign(time_s=TRUE.time_s + 1000))


def test_three_digits_behind_a_comma_are_doubtful(tmp_path: Path) -> None:
    frame = TRUE[["time_s", "pwm", "winding_degC"]].astype({"time_s": int}).drop_duplicates("time_s")
    text = csv(frame.assign(winding_degC=[f"{v:.3f}".replace(".", ",") for v in frame.winding_degC]), sep=";")
    path = write(tmp_path, text)
    with pytest.raises(InputError, match=r"decimal mark: ,\? .* settle it by --decimal , or --decimal \."):
        take(path, tmp_path / "runs")
    same(taken(path, tmp_path / "runs", decimal=","), frame)


def test_a_row_for_each_sensor_is_refused_with_what_to_do(tmp_path: Path) -> None:
    long = TRUE.melt(["time_s", "pwm"], var_name="sensor", value_name="T_C").sort_values("time_s", kind="stable")
    with pytest.raises(InputError, match=r"column sensor: has a row for each of .*; expected --series sensor"):
        take(write(tmp_path, csv(long)), tmp_path / "runs")


def test_names_that_repeat_and_letters_that_are_no_units(tmp_path: Path) -> None:
    text = csv(TRUE.assign(phase_A=1, phase_B=2, phase_C=3)).replace("casing_degC", "winding_degC", 1)
    run = taken(write(tmp_path, text), tmp_path / "runs")
    assert list(run.temps) == ["winding", "winding_2"]
    assert list(run.extras) == ["phase_A", "phase_B", "phase_C"]
    np.testing.assert_array_equal(run.temps["winding_2"], TRUE.casing_degC)


@pytest.mark.parametrize("names", [["T (degC)", "T (degC)", "T_2 (degC)"], ["T", "T_2", "T", "T"], ["", "T", ""]])
def test_names_that_repeat_become_names_that_no_other_column_has(names: list[str]) -> None:
    made = unique_names(names)
    assert len(set(made)) == len(names)
    assert all(new == old for new, old in zip(made, names, strict=True) if names.count(old) == 1)


@pytest.mark.parametrize("base", ["1st winding", "2", "", "°", "_7_coil"])
def test_a_part_has_a_name_that_a_coefficient_file_can_have_whatever_its_column_is_called(base: str) -> None:
    name = component_name(base, ())
    assert name_fault(name) is None
    assert name.startswith("sensor")


@pytest.mark.parametrize("powers", [("450", "1.500"), ("0", "6.000")])
def test_points_for_thousands_without_any_fraction_are_asked_for(powers: tuple[str, str], tmp_path: Path) -> None:
    rows = [f"{10 * i};{powers[i > 20]};{22 + i // 3}" for i in range(60)]
    path = write(tmp_path, "\n".join(["Zeit [s];Leistung [W];Wicklung [degC]", *rows]))
    options = {"input": "Leistung [W]", "full_scale": 6000.0}
    with pytest.raises(InputError, match=r"\.[05]00 may be a thousand .* settle it by --decimal , or --decimal \."):
        take(path, tmp_path / "out", **options)
    run = taken(path, tmp_path / "out", decimal=",", **options)
    watts = np.array([float(powers[0]), float(powers[1].replace(".", ""))])
    np.testing.assert_allclose(run.pwm[[0, -1]], watts / 6000.0 * 255.0, atol=0.5)


def test_fractions_to_three_digits_are_no_thousands(tmp_path: Path) -> None:
    frame = TRUE[["time_s", "pwm", "winding_degC"]]
    text = csv(frame.assign(winding_degC=[f"{v + 0.001:.3f}" for v in frame.winding_degC], time_s=2 * frame.time_s))
    run = taken(write(tmp_path, text), tmp_path / "runs")
    np.testing.assert_allclose(run.temps["winding"], frame.winding_degC + 0.001)
