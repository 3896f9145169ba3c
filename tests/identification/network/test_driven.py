"""An input that is a current or a power: what that says of heats and conductances that no run shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

import gen
from gen.errors import InputError
from gen.identification.logs.data import make_data
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.fitting.driven import known
from gen.identification.network.fitting.speed_laws import HEAT
from gen.identification.network.fitting.structure import full
from gen.runs import Run, write_run
from tests.identification.network.plant import Plant, holds

COIL = Plant(
    capacity=(60.0, 200.0),
    links=((0, 1, 0.8),),
    surfaces=((1, 0.4, 0.0),),
    heats=((0, 0.0, 24.0),),
    sensed={"coil": 0},
)
"""Heated by the square of its current, in still air."""
HEATER = replace(COIL, heats=((0, 24.0, 0.0),))


def logged(plant: Plant, level: int, seed: int, said: str) -> Run:
    run = plant.run(holds((level, 40), (0, 30)), np.random.default_rng(seed), noise=0.05)
    return replace(run, comments={"input": said} if said else {})


def missed_K(plant: Plant, said: str, folder: Path) -> float:
    """Error at a quarter of full scale of what was identified at 70 % and at full scale."""
    paths = [folder / f"{level}.csv" for level in (178, 255)]
    for seed, path in enumerate(paths):
        write_run(path, logged(plant, int(path.stem), seed, said))
    test = folder / "test.csv"
    write_run(test, logged(plant, 64, 9, said))
    model = gen.identify(paths, model="network").model
    shown, read = gen.simulate(model, test)["coil_degC"], gen.read_run(test)["coil_degC"]
    return float(np.sqrt(np.nanmean((shown.to_numpy() - read.to_numpy()) ** 2)))


@pytest.mark.parametrize(("plant", "said"), [(COIL, "I, 255 = 12 A"), (HEATER, "P, 255 = 2 kW")])
def test_what_the_input_is_tells_of_levels_that_were_not_run(plant: Plant, said: str, tmp_path: Path) -> None:
    folders = tmp_path / "told", tmp_path / "not"
    for folder in folders:
        folder.mkdir()
    told, not_told = missed_K(plant, said, folders[0]), missed_K(plant, "", folders[1])
    assert told < 0.5
    assert told < 0.5 * not_told


@pytest.mark.parametrize(
    ("said", "machine", "driven"),
    [
        ("I, 255 = 12 A", "", "current"),
        ("P, 255 = 500 W", "", "power"),
        ("duty, 255 = 100 percent", "", ""),
        ("U, 255 = 24 V", "", ""),
        ("", "", ""),
        ("duty, 255 = 100 percent", "heater", "power"),
        ("U, 255 = 24 V", "heater", "current"),
        ("", "heater", "power"),
        ("I, 255 = 12 A", "motor", ""),
    ],
)
def test_it_is_known_by_the_unit_and_by_what_it_drives(said: str, machine: str, driven: str) -> None:
    run = logged(COIL, 200, 1, said)
    assert make_network_data([Source("r.csv", run)], None, machine=machine).driven == driven
    if machine:
        said_so = replace(run, comments={**run.comments, "drives": machine})
        assert make_network_data([Source("r.csv", said_so), Source("s.csv", run)], None).driven == driven


def test_a_heaters_share_tells_of_levels_that_were_not_run(tmp_path: Path) -> None:
    paths = [tmp_path / f"{level}.csv" for level in (178, 255)]
    for seed, path in enumerate(paths):
        write_run(path, logged(HEATER, int(path.stem), seed, ""))
    test = tmp_path / "test.csv"
    write_run(test, logged(HEATER, 64, 9, ""))
    read = gen.read_run(test)["coil_degC"].to_numpy()

    def missed(drives: Literal["motor", "heater"]) -> float:
        found = gen.identify(paths, model="network", drives=drives)
        assert ("it moves no air" in found.text()) == (drives == "heater")
        return float(np.sqrt(np.nanmean((gen.simulate(found.model, test)["coil_degC"].to_numpy() - read) ** 2)))

    assert missed("heater") < min(0.5, 0.5 * missed("motor"))


def test_runs_that_drive_different_machines_are_refused() -> None:
    run = logged(COIL, 200, 1, "")
    said = [replace(run, comments={"drives": what}) for what in ("heater", "motor", "a fan")]
    with pytest.raises(InputError, match=r"b\.csv: comment drives: found motor; .* a\.csv has a heater"):
        make_network_data([Source("a.csv", said[0]), Source("b.csv", said[1])], None)
    with pytest.raises(InputError, match=r'a\.csv: comment drives: found "a fan", expected motor or heater'):
        make_network_data([Source("a.csv", said[2])], None)
    with pytest.raises(InputError, match=r'a\.csv: comment drives: found "a fan", expected motor or heater'):
        make_data([Source("a.csv", said[2])], None)


def test_a_motors_pwm_tells_nothing() -> None:
    structure = full(("casing",), 1)
    assert not list(known(structure))
    squares = {at.start + HEAT.terms.index("square") for at in structure.heats}
    assert {place for place, mean, _ in known(replace(structure, driven="current")) if mean > 0.0} == squares
