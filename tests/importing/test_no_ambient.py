"""Which names of rooms are the ambient, and what is said of a log without one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from gen.interface import Import
from gen.runs import Run, read_run
from tests.command import gen
from tests.importing.logs import TRUE, csv, take, write

ROWS = 360
RNG = np.random.default_rng(5)
PWM = np.where((np.arange(ROWS) // 60) % 2 == 0, 204, 0)


def warmed(gain_K: float, rows_to_settle: float) -> np.ndarray:
    rise, found = 0.0, []
    for pwm in PWM:
        found.append(21.0 + rise)
        rise += (gain_K * (pwm / 204) ** 2 - rise) / rows_to_settle
    return np.round((np.array(found) + 0.1 * RNG.standard_normal(ROWS)) * 4.0) / 4.0


WINDING, CASING, HEAVY = warmed(50.0, 30.0), warmed(25.0, 90.0), warmed(9.0, 60.0)
DAY = np.round(21.0 + 2.0 * np.sin(np.arange(ROWS) / 120.0) + 0.05 * RNG.standard_normal(ROWS), 1)


def log(tmp_path: Path, columns: dict[str, np.ndarray], comment: str = "") -> Path:
    named = {"time_s": np.arange(ROWS) * 10.0, "pwm": PWM, **columns}
    rows = [",".join(f"{values[i]:g}" for values in named.values()) for i in range(ROWS)]
    return write(tmp_path, "\n".join([*filter(None, [comment]), ",".join(named), *rows, ""]))


def imported(path: Path, tmp_path: Path, **options: object) -> tuple[Run, Import]:
    found = take(path, tmp_path / "out", **options)
    return read_run(found.runs[0]), found


@pytest.mark.parametrize("unit", [" [°C]", ""])
@pytest.mark.parametrize(
    "name",
    [
        *("Lab", "lab temp", "T_lab", "sensor.lab_temperature", "Laboratory", "Labor", "Workshop", "shop", "Werkstatt"),
        *("Werkstatttemperatur", "Garage", "Keller", "office", "indoor", "atelier", "officina", "taller", "weather"),
        *("room", "Raum", "Zimmer", "Halle", "Hallentemperatur", "outside", "Aussen", "env", "Umgebung", "air", "Luft"),
    ],
)
def test_a_room_by_its_name_is_the_ambient(name: str, unit: str, tmp_path: Path) -> None:
    run, found = imported(log(tmp_path, {"winding": WINDING, f"{name}{unit}": DAY}), tmp_path)
    assert run.ambient is not None
    np.testing.assert_allclose(run.ambient, DAY)
    assert list(run.temps) == ["winding"]
    assert found.warnings == []


def test_a_hall_is_a_room_where_it_is_in_degrees_and_else_a_sensor(tmp_path: Path) -> None:
    run, _ = imported(log(tmp_path, {"winding": WINDING, "Hall [°C]": DAY}), tmp_path)
    assert run.ambient is not None
    for name, values in (("hall", PWM / 51.0), ("hall_1", 22.0 + np.arange(ROWS) % 2)):
        run = read_run(take(log(tmp_path, {"winding": WINDING, name: values}), tmp_path / name).runs[0])
        assert (run.ambient, list(run.temps)) == (None, ["winding"])
    run = read_run(take(log(tmp_path, {"winding": WINDING, "hall sensor [°C]": CASING}), tmp_path / "s").runs[0])
    assert (run.ambient, set(run.temps)) == (None, {"winding", "hall_sensor"})


def test_what_is_named_ambient_goes_before_a_room(tmp_path: Path) -> None:
    run, _ = imported(log(tmp_path, {"winding": WINDING, "lab": DAY + 1.0, "ambient": DAY}), tmp_path)
    assert run.ambient is not None
    np.testing.assert_allclose(run.ambient, DAY)
    assert set(run.temps) == {"winding", "lab"}


def test_of_two_rooms_it_is_asked_which(tmp_path: Path) -> None:
    path = log(tmp_path, {"winding": WINDING, "lab": DAY, "workshop": DAY + 1.0})
    with pytest.raises(InputError, match=r"settle it by --column lab=ambient_degC or lab=NAME_degC$"):
        take(path, tmp_path / "out")
    run, _ = imported(path, tmp_path, columns={"workshop": "ambient_degC"})
    assert run.ambient is not None
    np.testing.assert_allclose(run.ambient, DAY + 1.0)


def only(lines: list[str]) -> str:
    (said,) = (line.partition(": ")[2] for line in lines)
    assert said.startswith("no ambient temperature: ")
    return said


def test_a_sensor_that_moves_little_and_not_with_the_others_is_named_and_not_taken(tmp_path: Path) -> None:
    path = log(tmp_path, {"T1": WINDING, "T2": CASING, "T3": HEAVY, "T4": DAY})
    run, found = imported(path, tmp_path)
    assert (run.ambient, set(run.temps)) == (None, {"T1", "T2", "T3", "T4"})
    said = only(found.warnings)
    assert found.notes == []
    assert "T4 moves by " in said
    assert said.endswith("if it is the room's: --column T4=ambient_degC")
    run, found = imported(path, tmp_path, columns={"T4": "ambient_degC"}, overwrite=True)
    assert run.ambient is not None
    np.testing.assert_allclose(run.ambient, DAY)
    assert found.warnings == []


@pytest.mark.parametrize(
    "columns",
    [
        {"T1": WINDING},
        {"T1": WINDING, "T2": CASING},
        {"T1": WINDING, "T2": HEAVY},  # it moves little, and with the other
        {"winding": WINDING, "rotor": DAY},  # a part by its name, however little it moves
        {"T1": DAY, "T2": DAY + 0.1},  # nothing was driven
        {"T1": WINDING, "T2": CASING, "T3_degC": 0.0 * DAY + 85.5},  # no room, but what holds one temperature
    ],
)
def test_where_no_column_is_like_a_room_none_is_named(columns: dict[str, np.ndarray], tmp_path: Path) -> None:
    _, found = imported(log(tmp_path, columns), tmp_path)
    assert found.warnings == []
    assert only(found.notes).endswith("if a column is the room's: --column OLD=ambient_degC")


@pytest.mark.parametrize("drift_K", [-3.0, 3.0])
def test_a_room_that_warms_or_cools_all_day_is_named(drift_K: float, tmp_path: Path) -> None:
    room = np.round(21.0 + np.linspace(0.0, drift_K, ROWS) + 0.05 * RNG.standard_normal(ROWS), 1)
    _, found = imported(log(tmp_path, {"T1": WINDING, "T2": CASING, "T3": room}), tmp_path)
    assert "--column T3=ambient_degC" in only(found.warnings)


def test_a_log_that_says_its_ambient_is_not_warned_of(tmp_path: Path) -> None:
    _, found = imported(log(tmp_path, {"T1": WINDING}, "# ambient_degC: 22"), tmp_path)
    assert (found.warnings, found.notes) == ([], [])


@pytest.mark.parametrize("renamed", [lambda f: f, lambda f: f.rename(columns={"ambient_degC": "room_degC"})])
def test_a_log_with_its_ambient_is_not_warned_of(renamed: Callable[[object], object], tmp_path: Path) -> None:
    found = take(write(tmp_path, csv(renamed(TRUE))), tmp_path / "out")  # type: ignore[arg-type]
    assert (found.warnings, found.notes) == ([], [])


def test_the_command_says_it_in_one_line(tmp_path: Path) -> None:
    log(tmp_path, {"T1": WINDING})
    done = gen("import", "log.csv", "--out", "runs", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    said = [line for line in done.stdout.splitlines() if "no ambient temperature" in line]
    assert said == [
        "log.csv: no ambient temperature: gen identify takes it from where the runs begin; if a column is the room's: "
        "--column OLD=ambient_degC"
    ]


def test_a_sensor_that_is_not_connected_is_not_proposed_as_the_room(tmp_path: Path) -> None:
    """A DS18B20 without its wires: following the proposal gave an ambient column without a reading."""
    _, found = imported(log(tmp_path, {"T1": WINDING, "T2": CASING, "T3_degC": 0.0 * DAY - 127.0}), tmp_path)
    assert not any("T3" in line and "ambient_degC" in line for line in (*found.warnings, *found.notes))
