"""Names of quantities in other languages, and words that mean something else in one of them."""

from __future__ import annotations

import unicodedata
from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from tests.importing.logs import take, taken, write

ROWS = 60
RISING = 20 + 0.3 * np.arange(ROWS)


def log(tmp_path: Path, *columns: str, time: str = "t [s]") -> Path:
    """A winding that warms; of the other columns each goes its own way, from 0 to 90."""
    head = ";".join((time, "Winding [°C]", *columns))
    rows = "".join(
        f"{20 * i};{RISING[i]:.1f}" + "".join(f";{90 - 30 * (i // 20) + k}" for k in range(len(columns))) + "\n"
        for i in range(ROWS)
    )
    return write(tmp_path, f"{head}\n{rows}")


@pytest.mark.parametrize(
    "name",
    [
        "Commande",
        "Consigne",
        "Ansteuerung",
        "Stellgroesse",
        "Stellgröße",
        "Stellgröße [x]",
        "Stellgrad",
        "Mando",
        "Comando motore",
        "Aansturing",
        "Puissance",
        "Potenza (W)",
        "Potência",
        "Potencia_motor",
        "Vermogen",
        "Vitesse [tr/min]",
        "Velocidad",
        "Velocità",
        "Toerental",
        "Umdrehungen",
        "Courant",
        "Corriente (A)",
        "Stroom",
        "Corrente",
        "Chauffage",
        unicodedata.normalize("NFD", "Stellgröße"),
    ],
)
def test_what_drives_a_motor_is_proposed_as_its_input(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected what drives it, such as --input ") as found:
        take(log(tmp_path, name, "Umgebung [°C]"), tmp_path / "out")
    assert name in str(found.value)


@pytest.mark.parametrize("name", ["Tastverhältnis", "Rapport cyclique", "Ciclo de trabajo", "Ciclo di lavoro"])
def test_a_duty_cycle_is_the_input(name: str, tmp_path: Path) -> None:
    run = taken(log(tmp_path, f"{name} [%]"), tmp_path / "out")
    assert run.pwm[0] == 230  # 90 % of 255


@pytest.mark.parametrize(
    ("name", "column"),
    [
        ("Courant moteur [mA]", "current_A"),
        ("Corriente del motor", "current_A"),
        ("Stroom", "current_A"),
        ("Intensité", "current_A"),
        ("Corrente (A)", "current_A"),
        ("Tensione [V]", "voltage_V"),
        ("Tension [V]", "voltage_V"),
        ("Spanning [V]", "voltage_V"),
        ("Tensão", "voltage_V"),
        ("Vitesse [tr/min]", "speed_rpm"),
        ("Velocità motore [giri/min]", "speed_rpm"),
        ("Toerental [omw/min]", "speed_rpm"),
        ("Motordrehzahl [U/min]", "speed_rpm"),
        ("Régime [tr/min]", "speed_rpm"),
    ],
)
def test_current_voltage_and_speed(name: str, column: str, tmp_path: Path) -> None:
    run = taken(log(tmp_path, "PWM [%]", name), tmp_path / "out")
    assert list(run.extras) == [column]
    assert list(run.temps) == ["winding"]


@pytest.mark.parametrize("name", ["Vitesse moteur", "Couple moteur", "Puissance stator", "Lager Stellgröße"])
def test_another_quantity_of_a_part_is_no_temperature(name: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t [s];PWM [%];Winding [°C];" + name + "\n")
    with path.open("a", encoding="utf-8") as file:
        file.writelines(f"{20 * i};60;{RISING[i]:.1f};{RISING[i] + 1:.1f}\n" for i in range(ROWS))
    assert list(taken(path, tmp_path / "out").temps) == ["winding"]


def test_a_belts_tension_is_no_voltage_and_a_bearings_output_side_no_command(tmp_path: Path) -> None:
    run = taken(log(tmp_path, "PWM [%]", "Tension"), tmp_path / "a")
    assert list(run.extras) == ["Tension"]
    rows = "".join(f"{20 * i};60;{RISING[i]:.1f};{RISING[i] + 1:.1f}\n" for i in range(ROWS))
    path = write(tmp_path, f"t [s];PWM [%];Winding [°C];bearing output\n{rows}")
    with pytest.raises(InputError, match=r"bearing output: .*nothing says that it is a temperature"):
        take(path, tmp_path / "b")


@pytest.mark.parametrize("name", ["Temps", "Tempo", "Tiempo", "Tijd", "Temps écoulé", "Tempo trascorso"])
def test_the_time_in_other_languages(name: str, tmp_path: Path) -> None:
    assert taken(log(tmp_path, "PWM [%]", time=name), tmp_path / "out").time_s[-1] == 20 * (ROWS - 1)


@pytest.mark.parametrize("name", ["core temps", "Temps [°C]"])
def test_temperatures_in_english_are_no_time(name: str, tmp_path: Path) -> None:
    rows = "".join(f"{60 if i < 40 else 0};{RISING[i]:.1f};{RISING[i] - 1:.1f}\n" for i in range(ROWS))
    with pytest.raises(InputError, match="no column is a time"):
        take(write(tmp_path, f"PWM [%];{name};Winding [°C]\n{rows}"), tmp_path / "out")


def test_a_column_of_temperatures_is_not_proposed_as_an_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"such as --input Puissance --full-scale 100; "):
        take(log(tmp_path, "Heater [°C]", "Puissance"), tmp_path / "out")
