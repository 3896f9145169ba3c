"""What is proposed as the input where no column is a PWM, and that all that has to be said is asked for at once."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from gen.runs import read_run
from tests.command import gen
from tests.importing.logs import take, write

ROWS = 120
DRIVEN = np.where(np.arange(ROWS) % 60 < 40, 1.0, 0.2)
RISING = 21.0 + 0.3 * np.arange(ROWS) - 0.2 * np.maximum(np.arange(ROWS) - 80, 0)


def log(tmp_path: Path, columns: dict[str, np.ndarray], winding: str = "winding [°C]") -> Path:
    named = {"t [s]": np.arange(ROWS) * 10.0, **columns, winding: RISING}
    rows = [";".join(f"{values[i]:g}" for values in named.values()) for i in range(ROWS)]
    return write(tmp_path, "\n".join([";".join(named), *rows, ""]))


def asked(path: Path, tmp_path: Path, **options: object) -> str:
    with pytest.raises(InputError) as found:
        take(path, tmp_path / "out", **options)
    return found.value.message


@pytest.mark.parametrize(
    ("name", "scale"),
    [
        ("FU_Ausgangsfrequenz_Hz", " --full-scale 50"),
        ("Frequenz", " --full-scale 50"),
        ("output frequency", " --full-scale 50"),
        ("Output Frequency (Hz)", " --full-scale 50"),
        ("vfd_hz", " --full-scale 50"),
        ("f_out", " --full-scale 50"),
        ("Drehfrequenz [Hz]", " --full-scale 50"),
        ("Antrieb [%]", ""),
        ("Antrieb", " --full-scale 50"),
        ("current_pct", ""),
        ("Umrichter [%]", ""),
    ],
)
def test_what_an_inverter_is_told_is_proposed(name: str, scale: str, tmp_path: Path) -> None:
    path = log(tmp_path, {name: 50.0 * DRIVEN})
    said = asked(path, tmp_path)
    guess = "; --full-scale is only the next round number that the log reaches: say what full drive is" if scale else ""
    assert f"expected what drives it, such as --input {shlex.quote(name)}{scale}{guess}" in said
    assert said.endswith(", if that is known" if scale else shlex.quote(name))
    full = {"full_scale": 50.0} if scale else {}
    run = read_run(take(path, tmp_path / "run", input=name, **full).runs[0])
    assert run.pwm.max() == round(255 * (1.0 if scale else 0.5))


def test_a_speed_controllers_pulses_are_proposed_with_their_rest(tmp_path: Path) -> None:
    """As a thrust stand's log has them, beside servos that stay where they are."""
    columns = {"ESC signal (µs)": 1000.0 + 700.0 * DRIVEN, "Servo 1 (µs)": 1500.0 + 0.0 * DRIVEN}
    path = log(tmp_path, columns)
    said = asked(path, tmp_path)
    assert said.endswith("such as --input 'ESC signal (µs)' --rest 1000 --full-scale 2000")
    run = read_run(take(path, tmp_path / "run", input="ESC signal (µs)", rest=1000.0, full_scale=2000.0).runs[0])
    assert set(run.pwm.tolist()) == {36, 179}  # 0.2 and 1 of 700 us over the rest


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("humidity [%]", 40.0 + 5.0 * DRIVEN),
        ("battery [%]", 100.0 - np.arange(ROWS) / 4.0),
        ("SoC [%]", 100.0 - np.arange(ROWS) / 4.0),
        ("mains frequency", 50.0 + 0.01 * DRIVEN),
        ("Netzfrequenz [Hz]", 50.0 + 0.01 * DRIVEN),
        ("frequency", 50.0 + 0.0 * DRIVEN),
        ("sampling_hz", 10.0 + 0.1 * DRIVEN),
        ("Antrieb Temp", 30.0 + DRIVEN),
    ],
)
def test_what_drives_nothing_is_not_proposed(name: str, values: np.ndarray, tmp_path: Path) -> None:
    said = asked(log(tmp_path, {name: values, "Strom [A]": 4.0 * DRIVEN}), tmp_path)
    assert "such as --input 'Strom [A]' --full-scale 5" in said
    assert f"--input '{name}'" not in said


def test_of_several_each_is_told_with_what_it_means_what_the_motor_is_told_first(tmp_path: Path) -> None:
    columns = {
        "Motorstrom_A": 4.0 * DRIVEN,
        "Leistung [W]": 400.0 * DRIVEN,
        "Drehzahl": 2900.0 * DRIVEN,
        "Frequenz_Hz": 50.0 * DRIVEN,
    }
    said = asked(log(tmp_path, columns), tmp_path)
    places = [
        said.index(text)
        for text in (
            "--input Drehzahl --full-scale 5000 (a speed: what the motor is told)",
            "--input Frequenz_Hz --full-scale 50 (a frequency: what the motor is told)",
            "--input 'Leistung [W]' --full-scale 500 (a power: what it takes)",
            "--input Motorstrom_A --full-scale 5 (a current: what heats it; beside another input, --heat",
        )
    ]
    assert places == sorted(places)


def test_the_input_and_what_is_doubtful_are_asked_for_in_one_line(tmp_path: Path) -> None:
    path = log(tmp_path, {"Frequenz_Hz": 50.0 * DRIVEN, "quux rotor": RISING + 1.0})
    said = asked(path, tmp_path)
    assert "--input Frequenz_Hz --full-scale 50; " in said
    assert "if that is known; and doubtful: quux rotor: " in said
    assert "settle it by --unit 'quux rotor=degC' or " in said
    run = read_run(
        take(path, tmp_path / "b", input="Frequenz_Hz", full_scale=50.0, units={"quux rotor": "degC"}).runs[0]
    )
    assert set(run.temps) == {"winding", "quux_rotor"}


def test_options_that_two_columns_of_pwm_need_come_with_what_is_doubtful(tmp_path: Path) -> None:
    said = asked(log(tmp_path, {"pwm_1": 200 * DRIVEN, "pwm_2": 200 * DRIVEN, "quux rotor": RISING}), tmp_path)
    assert "2 columns may be the input; expected --input pwm_1 or --input pwm_2; and doubtful: quux rotor: " in said


def exported(tmp_path: Path) -> Path:
    """As an operator's panel exports it: a row for each reading."""
    found = ['"VarName";"TimeString";"VarValue";"Validity"']
    series = {
        "Lager_quux": RISING,
        "Motor_Wicklung": RISING + 2.0,
        "Hallentemperatur": 21.0 + 0.0 * RISING,
        "FU_Ausgangsfrequenz_Hz": 50.0 * DRIVEN,
        "FU_Motorstrom_A": 4.0 * DRIVEN,
    }
    for i in range(ROWS):
        time = f"20.03.2026 07:{i // 6:02d}:{10 * (i % 6):02d}"
        found += [f'"{name}";"{time}";{values[i]:.1f};1' for name, values in series.items()]
    return write(tmp_path, "\n".join([*found, ""]))


def test_a_row_for_each_reading_is_asked_for_together_with_all_that_comes_after_it(tmp_path: Path) -> None:
    path = exported(tmp_path)
    said = asked(path, tmp_path)
    assert "expected --series VarName, which gives each a column of its own" in said
    later = said.partition(". With --series VarName: ")[2]
    assert "--input FU_Ausgangsfrequenz_Hz --full-scale 50 (a frequency" in later
    assert "--input FU_Motorstrom_A --full-scale 5 (a current" in later
    assert "settle it by --unit Lager_quux=degC" in later
    options = ["--series", "VarName", "--input", "FU_Ausgangsfrequenz_Hz", "--full-scale", "50"]
    options += ["--unit", "Lager_quux=degC"]
    done = gen("import", path.name, "--out", "runs", *options, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    run = read_run(tmp_path / "runs" / "log.csv")
    np.testing.assert_allclose(run.extras["FU_Motorstrom_A"], 4.0 * DRIVEN)


def test_where_the_current_is_taken_the_frequency_is_kept_and_told(tmp_path: Path) -> None:
    path = exported(tmp_path)
    said = {"series": "VarName", "units": {"Lager_quux": "degC"}}
    found = take(path, tmp_path / "a", input="FU_Motorstrom_A", full_scale=5.0, **said)
    np.testing.assert_allclose(read_run(found.runs[0]).extras["FU_Ausgangsfrequenz_Hz"], 50.0 * DRIVEN)
    assert ["what the motor is told may be FU_Ausgangsfrequenz_Hz (10..50)" in note for note in found.notes] == [True]
    found = take(path, tmp_path / "b", input="FU_Ausgangsfrequenz_Hz", full_scale=50.0, **said)
    assert found.notes == []


def test_a_row_for_each_reading_of_which_nothing_else_is_doubtful_asks_for_that_alone(tmp_path: Path) -> None:
    found = ["name,time,value"]
    for i in range(ROWS):
        found += [f"pwm,{10 * i},{200 * DRIVEN[i]:g}", f"winding_degC,{10 * i},{RISING[i]:.1f}"]
    said = asked(write(tmp_path, "\n".join([*found, ""])), tmp_path)
    assert "--series name" in said
    assert "With --series" not in said
