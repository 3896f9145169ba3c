"""Columns that rise, and are no temperatures though their names look like it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, take, taken, write

ROWS = len(TRUE)
N = np.arange(ROWS)
WARM = TRUE.winding_degC.to_numpy() - 1.0
COOLS = TRUE.assign(winding_degC=np.where(N < 80, 20 + 0.5 * N, 60 - 0.4 * (N - 80)).round(1))


@pytest.mark.parametrize(
    ("name", "values"),
    [("T_x", N), ("T3", N + 17), ("motor", 0.5 * N), ("t_n", 2 * N + 2), ("stator", np.round(0.1 * N + 0.1, 1))],
)
def test_what_rises_by_one_step_in_every_row_is_a_counter(name: str, values: np.ndarray, tmp_path: Path) -> None:
    found = take(write(tmp_path, csv(TRUE.assign(**{name: values}))), tmp_path / "runs")
    assert "in every row: a counter" in str(found.guesses().loc[name, "why"])
    assert found.guesses().loc[name, "taken"] == name


@pytest.mark.parametrize("name", ["T3", "bearing", "T_x", "TC1"])
def test_what_never_falls_beside_a_temperature_that_does_is_asked_for(name: str, tmp_path: Path) -> None:
    path = write(tmp_path, csv(COOLS.assign(**{name: WARM - 18})))
    said = "never falls, though winding_degC does, and begins "
    with pytest.raises(InputError, match=rf"{name}: .* {said}\d.*; settle it by --unit {name}=degC .* out$"):
        take(path, tmp_path / "runs")
    assert len(taken(path, tmp_path / "yes", units={name: "degC"}).temps) == 3
    assert list(taken(path, tmp_path / "no", columns={name: ""}).temps) == ["winding", "casing"]


def test_a_slow_part_still_warms_while_another_cools(tmp_path: Path) -> None:
    found = take(write(tmp_path, csv(COOLS.assign(T3=WARM))), tmp_path / "runs")
    assert found.guesses().loc["T3", "taken"] == "T3_degC"
    assert "it never falls, though winding_degC does" in str(found.guesses().loc["T3", "why"])


def test_it_is_taken_where_no_other_falls_and_where_its_name_or_unit_says_so(tmp_path: Path) -> None:
    rising = TRUE.assign(T3=WARM)
    found = take(write(tmp_path, csv(rising)), tmp_path / "a")
    assert "; it never falls" in str(found.guesses().loc["T3", "why"])
    said = COOLS.assign(**{"T3 [°C]": WARM - 18, "temp_back": WARM - 18})
    assert {"T3", "back"} < set(taken(write(tmp_path, csv(said)), tmp_path / "b").temps)


@pytest.mark.parametrize("name", ["Charge (C)", "Capacitance [F]", "total charge used [C]", "Ladung (C)"])
def test_coulomb_and_farad_are_no_degrees(name: str, tmp_path: Path) -> None:
    run = taken(write(tmp_path, csv(TRUE.assign(**{name: WARM}))), tmp_path / "runs")
    assert list(run.temps) == ["winding", "casing"]
    assert "charge_air" in taken(write(tmp_path, csv(TRUE.assign(**{"charge air (C)": WARM}))), tmp_path / "air").temps


def test_a_controllers_counters_of_energy_are_no_times(tmp_path: Path) -> None:
    """As VESC Tool writes them."""
    frame = TRUE.assign(ms_today=36_000_000 + 500 * N, amp_hours_used=0.001 * N, watt_hours_used=0.04 * N)
    run = taken(write(tmp_path, csv(frame.drop(columns="time_s"), sep=";")), tmp_path / "runs")
    np.testing.assert_allclose(run.time_s - run.time_s[0], TRUE.time_s)


@pytest.mark.parametrize(
    ("duty", "ambient", "winding"),
    [
        ("PLC_PRG.rDuty", "PLC_PRG.rTempAmbient", "PLC_PRG.rTempWinding"),
        ("fPWM", "TUmgebung", "TWicklung"),
        ("motorDuty", "AmbientTemp", "MotorTemp"),
    ],
)
def test_words_that_begin_with_capitals_are_words(duty: str, ambient: str, winding: str, tmp_path: Path) -> None:
    frame = TRUE.drop(columns="casing_degC").rename(
        columns={"pwm": duty, "ambient_degC": ambient, "winding_degC": winding}
    )
    run = taken(write(tmp_path, csv(frame)), tmp_path / "runs", units={duty: "counts"})
    np.testing.assert_array_equal(run.pwm, TRUE.pwm)
    np.testing.assert_array_equal(run.ambient, TRUE.ambient_degC)
    np.testing.assert_array_equal(next(iter(run.temps.values())), TRUE.winding_degC)
    assert len(run.temps) == 1


def test_the_time_before_a_firmwares_line(tmp_path: Path) -> None:
    """As ESP-IDF logs it, in colours, between lines of others."""
    lines = "".join(
        f"\x1b[0;32mI ({1234 + 500 * i}) motor: duty: {TRUE.pwm[i]}, T_winding: {TRUE.winding_degC[i]:.1f}\x1b[0m\n"
        + ("\x1b[0;33mW (999) wifi: rssi -60\x1b[0m\n" if i % 9 == 0 else "")
        for i in range(ROWS)
    )
    run = taken(write(tmp_path, lines, name="monitor.txt"), tmp_path / "runs", units={"duty": "counts"})
    np.testing.assert_allclose(run.time_s, 1.234 + TRUE.time_s)
    np.testing.assert_array_equal(run.temps["winding"], TRUE.winding_degC)
