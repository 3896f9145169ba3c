"""Columns that say little: one letter, a symbol, a unit that is part of the name; and what looks like a temperature."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from gen.errors import InputError
from tests.importing.logs import TRUE, csv, same, take, taken, write

FAHRENHEIT = TRUE.copy()
FAHRENHEIT.iloc[:, 2:] = np.round(TRUE.iloc[:, 2:] * 1.8 + 32.0, 2)


def renamed(frame: pd.DataFrame, **names: str) -> str:
    """A log with these columns alone, called so."""
    return csv(frame[list(names)].rename(columns=names))


@pytest.mark.parametrize(
    ("names", "parts"),
    [
        ({"time_s": "t", "winding_degC": "T"}, {"winding_degC": "T_degC"}),
        ({"winding_degC": "T", "time_s": "t"}, {"winding_degC": "T_degC"}),
        ({"time_s": "s", "winding_degC": "tc0", "casing_degC": "tc1"}, {"winding_degC": "tc0_degC"}),
        ({"time_s": "t", "winding_degC": "T[0]", "casing_degC": "T[1]"}, {"winding_degC": "T0_degC"}),
        ({"time_s": "t", "winding_degC": "Tw", "casing_degC": "Tg"}, {"winding_degC": "tw_degC"}),
        ({"time_s": "t", "winding_degC": "TW", "casing_degC": "TG"}, {"winding_degC": "TW_degC"}),
        ({"time_s": "t", "winding_degC": "Tmot", "ambient_degC": "Tamb"}, {"winding_degC": "tmot_degC"}),
        ({"time_s": "t", "winding_degC": "Tmot", "ambient_degC": "Tamb"}, {"ambient_degC": "ambient_degC"}),
        ({"time_s": "timeSeconds", "winding_degC": "windingDegC"}, {"winding_degC": "winding_degC"}),
    ],
)
def test_short_names_are_temperatures(names: dict[str, str], parts: dict[str, str], tmp_path: Path) -> None:
    run = taken(write(tmp_path, renamed(TRUE, **names, pwm="pwm")), tmp_path / "out")
    same(run, TRUE[["time_s", "pwm", *parts]], parts)


def test_a_temperature_that_rises_evenly_is_no_time_beside_a_time(tmp_path: Path) -> None:
    frame = TRUE.assign(T=22.0 + 0.5 * np.arange(len(TRUE)))
    run = taken(write(tmp_path, csv(frame[["T", "time_s", "pwm"]].rename(columns={"time_s": "t"}))), tmp_path / "out")
    np.testing.assert_allclose(run.temps["T"], frame["T"])


@pytest.mark.parametrize("name", ["Torque", "Tq", "Trq", "Tach", "Ticks", "Tau", "Ts", "Ti", "Td", "Ton", "Toff"])
def test_other_symbols_are_none(name: str, tmp_path: Path) -> None:
    text = csv(TRUE.assign(**{name: np.round(20.0 + np.sin(TRUE.time_s), 3)}))
    found = take(write(tmp_path, text), tmp_path / "out")
    assert found.guesses().taken[name] == name


def test_a_symbol_alone_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="called as one"):
        take(write(tmp_path, renamed(TRUE, time_s="t", winding_degC="Tw", pwm="pwm")), tmp_path / "out")


def test_a_torque_may_be_called_as_a_temperature_is(tmp_path: Path) -> None:
    torque = np.where(np.arange(len(TRUE)) < 10, 0.0, np.round(TRUE.pwm / 12.0 + np.sin(TRUE.time_s), 2))
    with pytest.raises(InputError, match=r"doubtful: T: T_degC\?"):
        take(write(tmp_path, csv(TRUE.assign(T=torque))), tmp_path / "out")


@pytest.mark.parametrize(
    "name", ["tempF", "temp_f", "motorTemperatureF", "temp.fahrenheit", "tempFahrenheit", "Temp (degrees Fahrenheit)"]
)
def test_a_unit_that_is_part_of_a_name(name: str, tmp_path: Path) -> None:
    found = take(write(tmp_path, renamed(FAHRENHEIT, time_s="t", winding_degC=name, pwm="pwm")), tmp_path / "out")
    run = pd.read_csv(found.runs[0], comment="#")
    np.testing.assert_allclose(run.iloc[:, 2], TRUE.winding_degC, atol=0.01)


@pytest.mark.parametrize("names", [("temp_c", "temp_f"), ("Temp (°C)", "Temp (°F)"), ("tempC", "tempF")])
def test_a_temperature_told_in_two_units_is_taken_once(names: tuple[str, str], tmp_path: Path) -> None:
    celsius, fahrenheit = names
    frame = TRUE[["time_s", "pwm"]].assign(**{celsius: TRUE.winding_degC, fahrenheit: FAHRENHEIT.winding_degC.round()})
    found = take(write(tmp_path, csv(frame)), tmp_path / "out")
    same(taken(write(tmp_path, csv(frame)), tmp_path / "again"), TRUE[["winding_degC"]], {"winding_degC": "temp_degC"})
    assert "in another unit" in found.guesses().why[fahrenheit]


def test_units_of_messages_in_words_and_letters(tmp_path: Path) -> None:
    rows = [
        {"t": t, "winding": {"val": w, "u": "F"}, "casing": {"value": c, "unit": "degree_Fahrenheit"}, "pwm": int(p)}
        for t, w, c, p in zip(TRUE.time_s, FAHRENHEIT.winding_degC, FAHRENHEIT.casing_degC, TRUE.pwm, strict=True)
    ]
    run = taken(write(tmp_path, json.dumps(rows), name="log.json"), tmp_path / "out")
    np.testing.assert_allclose(run.temps["winding"], TRUE.winding_degC, atol=0.01)
    np.testing.assert_allclose(run.temps["casing"], TRUE.casing_degC, atol=0.01)


@pytest.mark.parametrize("beside", ["pwm_freq", "PWM Frequency (Hz)", "pwm_pin"])
def test_what_a_pwm_has_beside_its_duty_is_no_input(beside: str, tmp_path: Path) -> None:
    frame = TRUE.assign(duty=TRUE.pwm / 255)
    frame[beside] = 200
    text = csv(frame.drop(columns="pwm"))
    same(taken(write(tmp_path, text), tmp_path / "out"), TRUE)


@pytest.mark.parametrize("name", ["T1", "winding", "tc"])
def test_volts_of_a_sensor_are_no_degrees(name: str, tmp_path: Path) -> None:
    text = csv(TRUE[["time_s", "pwm"]].assign(**{name: np.round(TRUE.winding_degC * 0.005, 4)}))
    with pytest.raises(InputError, match=r"0\.1075\.\.0\.\d+: no motor in degC"):
        take(write(tmp_path, text), tmp_path / "out")


def test_a_resistance_that_falls_is_no_temperature(tmp_path: Path) -> None:
    kelvin = TRUE.winding_degC + 273.15
    text = csv(TRUE[["time_s", "pwm"]].assign(ntc=np.round(10.0 * np.exp(3950.0 * (1.0 / kelvin - 1.0 / 298.15)), 3)))
    with pytest.raises(InputError, match="a resistance"):
        take(write(tmp_path, text), tmp_path / "out")


@pytest.mark.parametrize(
    ("factor", "said"), [(0.005, "rather V than degC"), (100.0, r"no cold motor.*=0\.01degC"), (1000.0, r"=0\.001degC")]
)
def test_numbers_that_are_hardly_in_the_unit_of_their_name(factor: float, said: str, tmp_path: Path) -> None:
    text = csv(TRUE.assign(winding_degC=[f"{w * factor:g}" for w in TRUE.winding_degC]))
    with pytest.raises(InputError, match=said):
        take(write(tmp_path, text), tmp_path / "out")
