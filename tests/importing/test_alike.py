"""Columns without a unit that are temperatures by how they begin and move, and those that only stand beside some."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.interface import Import
from gen.runs import Run, read_run
from tests.importing.logs import take, write

ROWS, STEP_S = 400, 10.0
TIME = np.arange(ROWS) * STEP_S
PWM = np.where((TIME // 1000.0) % 2 == 0, 204, 0)
RNG = np.random.default_rng(11)


def warmed(gain_K: float, tau_s: float, begin: float = 21.0) -> np.ndarray:
    """A first-order part of the motor, read to a quarter of a degree."""
    rise, found = 0.0, []
    for pwm in PWM:
        found.append(begin + rise)
        rise += (gain_K * (pwm / 204) ** 2 - rise) * STEP_S / tau_s
    return np.round((np.array(found) + 0.1 * RNG.standard_normal(ROWS)) * 4.0) / 4.0


MOTOR = warmed(55.0, 600.0)
ROOM = np.round(21.0 + np.linspace(0.0, 1.5, ROWS) + 0.05 * RNG.standard_normal(ROWS), 1)
GEARBOX = warmed(30.0, 1500.0)


def taken_beside(
    tmp_path: Path, others: dict[str, np.ndarray], motor: np.ndarray = MOTOR, **options: object
) -> tuple[Run, Import]:
    """A log of a motor and a room, and of some more columns."""
    named = {"time_s": TIME, "pwm": PWM, "motor": motor, "room": ROOM, **others}
    rows = [",".join(f"{values[i]:g}" for values in named.values()) for i in range(ROWS)]
    log = write(tmp_path, "\n".join([",".join(named), *rows, ""]))
    found = take(log, tmp_path / "out", **options)
    return read_run(found.runs[0]), found


@pytest.mark.parametrize(
    "name", ["gearbox", "cab", "esc", "battery", "Getriebe", "heat sink", "battery 2", "motor gearbox"]
)
def test_a_machine_s_part_that_begins_and_moves_as_the_motor_is_a_temperature(name: str, tmp_path: Path) -> None:
    run, found = taken_beside(tmp_path, {name: GEARBOX})
    part = name.lower().replace(" ", "_")
    assert set(run.temps) == {"motor", part}
    np.testing.assert_allclose(run.temps[part], GEARBOX)
    assert "begins and moves as the others do" in str(found.guesses().loc[name, "why"])
    assert found.warnings == []


def test_it_is_in_the_unit_that_the_others_are_in(tmp_path: Path) -> None:
    fahrenheit = {"gearbox": GEARBOX * 1.8 + 32.0}
    told = {"motor": "degF", "room": "degC"}
    run, _ = taken_beside(tmp_path, fahrenheit, MOTOR * 1.8 + 32.0, units=told)
    np.testing.assert_allclose(run.temps["gearbox"], GEARBOX, atol=1e-4)


def test_a_name_that_nobody_knows_is_told_with_the_option_that_takes_it(tmp_path: Path) -> None:
    run, found = taken_beside(tmp_path, {"field3": GEARBOX, "quux": GEARBOX})
    assert set(run.temps) == {"motor"}
    (said,) = found.warnings
    assert "field3 (" in said
    assert "quux (" in said
    assert said.endswith("if these are temperatures: --column field3=field3_degC --column quux=quux_degC")
    columns = {"field3": "field3_degC", "quux": "quux_degC"}
    run, found = taken_beside(tmp_path, {"field3": GEARBOX, "quux": GEARBOX}, columns=columns, overwrite=True)
    assert set(run.temps) == {"motor", "field3", "quux"}
    assert found.warnings == []


def test_a_part_that_does_not_move_with_the_others_is_told_and_not_taken(tmp_path: Path) -> None:
    run, found = taken_beside(tmp_path, {"driver": 23.0 - 3.0 * TIME / TIME[-1]})
    assert set(run.temps) == {"motor"}
    assert [said.endswith("if it is a temperature: --column driver=driver_degC") for said in found.warnings] == [True]


def test_a_battery_that_moves_by_volts_is_told_at_most(tmp_path: Path) -> None:
    """As a charger's log may have it: it rises while the motor warms."""
    volts = 22.0 + (MOTOR - MOTOR.min()) / 12.0
    run, found = taken_beside(tmp_path, {"battery": volts})
    assert set(run.temps) == {"motor"}
    assert ["--column battery=battery_degC" in said for said in found.warnings] == [True]


def test_what_is_named_otherwise_by_the_user_is_not_told(tmp_path: Path) -> None:
    run, found = taken_beside(tmp_path, {"gearbox": GEARBOX}, columns={"gearbox": "gearbox"})
    assert (set(run.temps), found.warnings) == ({"motor"}, [])
    assert list(run.extras) == ["gearbox"]


DRIVEN = PWM / 204.0
OTHERS = {
    "battery": 25.2 - 1.5 * TIME / TIME[-1] - 0.9 * DRIVEN,  # volts
    "pack": 25.2 - 1.5 * TIME / TIME[-1] - 0.5 * DRIVEN + 0.02 * RNG.standard_normal(ROWS),
    "battery_pct": 100.0 - 40.0 * TIME / TIME[-1],
    "battery 2": 90.0 - 40.0 * TIME / TIME[-1],  # percent
    "current_in": 20.0 + 12.0 * DRIVEN,
    "esc": 22.0 + 40.0 * DRIVEN,  # percent of something
    "humidity": np.round(24.0 + 6.0 * np.sin(TIME / 900.0), 1),
    "set_temp": np.where(TIME < 2000.0, 20.0, 60.0),
    "speed": 3000.0 * DRIVEN,
    "cycles": 20.0 + np.arange(ROWS) // 8,
    "count": 20.0 + np.arange(ROWS),
    "noise": 22.0 + 5.0 * RNG.standard_normal(ROWS),
    "gearbox oil level": 25.0 - 4.0 * TIME / TIME[-1],
    "gear": 1.0 + 5.0 * np.abs(np.sin(TIME / 900.0)),
    "elevation": 22.0 + 9.0 * np.sin(TIME / 900.0),
    "out": np.cumsum(DRIVEN - 0.5) / 10.0,
    "slope": 20.0 + 0.013 * np.arange(ROWS),
    "controller": 22.5 + 0.0 * TIME,
}


@pytest.mark.parametrize("name", [name for name in OTHERS if name != "cycles"])
def test_what_is_no_temperature_is_neither_taken_nor_told(name: str, tmp_path: Path) -> None:
    run, found = taken_beside(tmp_path, {name: OTHERS[name]})
    assert set(run.temps) == {"motor"}
    assert found.warnings == []


def test_what_counts_now_and_then_is_told_at_most(tmp_path: Path) -> None:
    run, _ = taken_beside(tmp_path, {"cycles": OTHERS["cycles"]})
    assert set(run.temps) == {"motor"}
