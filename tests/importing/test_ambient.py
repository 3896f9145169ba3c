"""Which column is the ambient, in several languages, and what only stands near one."""

from __future__ import annotations

import unicodedata
from pathlib import Path

import numpy as np
import pytest

from gen.errors import InputError
from gen.runs import Run
from tests.importing.logs import take, taken, write

ROWS = 60
ROOM = [21.0 + 0.01 * i for i in range(ROWS)]
WARM = [21.0 + 0.5 * i for i in range(ROWS)]
RISES = [0.5 * i for i in range(ROWS)]


def log(tmp_path: Path, columns: dict[str, list[float]]) -> Path:
    rows = "".join(
        f"{i};80,5;" + ";".join(f"{values[i]:.2f}".replace(".", ",") for values in columns.values()) + "\n"
        for i in range(ROWS)
    )
    return write(tmp_path, f"time [s];duty [%];{';'.join(columns)}\n{rows}")


def room_of(run: Run) -> list[float]:
    assert run.ambient is not None
    return [round(value, 2) for value in run.ambient.tolist()]


@pytest.mark.parametrize(
    "name",
    [
        "Ambient",
        "T_amb",
        "Raum",
        "Raumluft",
        "Raumtemp.",
        "Umgebungstemp.",
        "Außentemp.",
        "Tair",
        "T_umg",
        "Temp Out",
        "Umgebungstemperatur",
        "Umgebungsluft",
        "Außentemperatur",
        "Luft",
        "Température ambiante",
        "Temp. extérieure",
        "Salle",
        "T pièce",
        "Temperatura ambiente",
        "Aria",
        "Temperatura esterna",
        "Sala",
        "Temperatura exterior",
        "Temperatura do ar",
        "Aire",
        "Omgeving",
        "Omgevingstemperatuur",
        "Kamertemperatuur",
        "Buitenlucht",
    ],
)
@pytest.mark.parametrize("unit", [" [°C]", ""])
@pytest.mark.parametrize("form", ["NFC", "NFD"])
def test_the_ambient_in_six_languages(name: str, unit: str, form: str, tmp_path: Path) -> None:
    head = unicodedata.normalize(form, name)  # type: ignore[arg-type]
    run = taken(log(tmp_path, {"winding [°C]": WARM, f"{head}{unit}": ROOM}), tmp_path / "out")
    assert room_of(run) == [round(value, 2) for value in ROOM]
    assert list(run.temps) == ["winding"]


@pytest.mark.parametrize(
    ("other", "name", "part"),
    [
        ("Bearing outside", "room", "bearing_outside"),
        ("Lager außen", "Raum", "lager_aussen"),
        ("air gap", "ambient", "air_gap"),
        ("Luftspalt", "Luft", "luftspalt"),
        ("entrefer", "Température ambiante", "entrefer"),
        ("air outlet", "outside", "air_outlet"),
        ("outside air", "T_amb", "outside_air"),
        ("casing ambient side", "Ambient", "casing_ambient_side"),
    ],
)
@pytest.mark.parametrize("first", [True, False])
def test_the_column_that_says_it_most_plainly_is_the_ambient(
    other: str, name: str, part: str, first: bool, tmp_path: Path
) -> None:
    both = [(f"{other} [°C]", WARM), (f"{name} [°C]", ROOM)]
    columns = {"winding [°C]": WARM, **dict(both if first else both[::-1])}
    run = taken(log(tmp_path, columns), tmp_path / "out")
    assert room_of(run) == [round(value, 2) for value in ROOM]
    assert set(run.temps) == {"winding", part}


@pytest.mark.parametrize("name", ["air gap", "Bearing outside", "Gehäuse außen"])
def test_a_part_beside_the_air_is_no_ambient_though_there_is_no_other(name: str, tmp_path: Path) -> None:
    run = taken(log(tmp_path, {"winding [°C]": WARM, f"{name} [°C]": WARM}), tmp_path / "out")
    assert run.ambient is None
    assert len(run.temps) == 2


def test_air_with_a_word_that_nobody_knows_is_asked_for(tmp_path: Path) -> None:
    path = log(tmp_path, {"winding [°C]": WARM, "air inlet [°C]": ROOM})
    said = r"settle it by --column 'air inlet \[°C\]=ambient_degC' or 'air inlet \[°C\]=NAME_degC'"
    with pytest.raises(InputError, match=said):
        take(path, tmp_path / "out")
    run = taken(path, tmp_path / "a", columns={"air inlet [°C]": "ambient_degC"})
    assert room_of(run) == [round(value, 2) for value in ROOM]
    run = taken(path, tmp_path / "b", columns={"air inlet [°C]": "inlet_degC"})
    assert (run.ambient, set(run.temps)) == (None, {"winding", "inlet"})


RISE_NAMES = [
    "Winding over ambient",
    "Winding_above_ambient",
    "winding minus ambient",
    "Winding rise",
    "Übertemperatur Wicklung",
    "Wicklung über Umgebung",
    "Échauffement bobinage",
    "Δ winding",
    "Winding ΔT",
]


@pytest.mark.parametrize("unit", [" [°C]", " [K]", ""])
@pytest.mark.parametrize("name", RISE_NAMES)
def test_a_rise_over_the_ambient_is_neither_ambient_nor_a_part(name: str, unit: str, tmp_path: Path) -> None:
    columns = {f"{name}{unit}": RISES, "casing [°C]": WARM, "ambient [°C]": ROOM}
    found = take(log(tmp_path, columns), tmp_path / "out")
    run = taken(log(tmp_path, columns), tmp_path / "out", overwrite=True)
    assert room_of(run) == [round(value, 2) for value in ROOM]
    assert list(run.temps) == ["casing"]
    np.testing.assert_allclose(next(iter(run.extras.values())), RISES)
    if unit:
        assert "a rise over the ambient" in str(found.guesses().loc[f"{name}{unit}", "why"])


@pytest.mark.parametrize("name", RISE_NAMES)
def test_a_log_of_rises_alone_is_refused_with_what_they_are(name: str, tmp_path: Path) -> None:
    path = log(tmp_path, {f"{name} [K]": RISES, "ambient [°C]": ROOM})
    with pytest.raises(InputError, match="is a rise, to which the ambient has to be added first; expected") as found:
        take(path, tmp_path / "out")
    assert "=winding_degC" not in found.value.message


@pytest.mark.parametrize("name", ["ambient dew point", "Taupunkt Raum", "Point de rosée", "room wet bulb"])
def test_what_is_told_of_moist_air_is_neither_ambient_nor_a_part(name: str, tmp_path: Path) -> None:
    columns = {"winding [°C]": WARM, f"{name} [°C]": [value - 12 for value in ROOM], "ambient [°C]": ROOM}
    run = taken(log(tmp_path, columns), tmp_path / "out")
    assert room_of(run) == [round(value, 2) for value in ROOM]
    assert list(run.temps) == ["winding"]
