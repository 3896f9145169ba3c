"""What all motors show is learnt, what one shows is told: on motors that are integrated here, by Euler's method."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from gen.coefficients import parse
from gen.fleet.folder.models import COMMON, identified_paths, model_path, models_of, refined_path, sound
from gen.fleet.folder.store import Store
from gen.fleet.identify import Identified, identify_fleet
from gen.fleet.refine import RefinedFleet, refine_fleet
from gen.fleet.tasks.work import Workers
from gen.fleet.watch import Watched, watch
from gen.reference.simulate import simulate_run
from gen.runs import Run
from tests.command import gen
from tests.fleet.conftest import MOTORS, OPTIONS
from tests.fleet.made import run_of

GROWN = 1.3
"""Factor on the brush's heat in all later runs, as of another make of brush."""
WORN, SHIFTED = 5, 2
"""Motors with more heat than that, and with a sensor that has shifted."""


def later(number: int, seed: int, *, offset: float = 0.0, worn: bool = False) -> Run:
    """A run of a motor as it is now."""
    rng = np.random.default_rng(1000 + number)
    heat, capacity = np.exp(rng.normal(0.0, 0.08, 2)).tolist()
    return run_of(seed, heat=heat * GROWN * (1.4 if worn else 1.0), capacity=capacity, offset=offset)


def add_later(store: Store, number: int, *, offset: float = 0.0, worn: bool = False) -> None:
    store.add(f"m{number}", "2026-02-01", "later", later(number, 700 + number, offset=offset, worn=worn))


def error_K(store: Store, path: str, run: Run) -> float:
    shown = simulate_run(parse(store.read(path)), run, "exact", "auto", "run")
    return float(np.sqrt(np.mean([(shown[f"{name}_degC"] - run.temps[name]) ** 2 for name in run.temps])))


@pytest.fixture(scope="module")
def refined(
    identified: tuple[Path, Identified], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Store, RefinedFleet, Watched]:
    folder = tmp_path_factory.mktemp("refined") / "store"
    shutil.copytree(identified[0], folder)
    store = Store(str(folder))
    for number in range(MOTORS):
        add_later(store, number, offset=3.0 if number == SHIFTED else 0.0, worn=number == WORN)
    found = refine_fleet(store, 6, Workers(), lambda _: None)
    return store, found, watch(store, 0.01, Workers(), lambda _: None)


def test_what_all_show_is_named_and_what_one_shows_is_told(refined: tuple[Store, RefinedFleet, Watched]) -> None:
    _, found, watched = refined
    assert [(one.key["what"], one.key["where"]) for one in found.common] == [("schedule_error", "brush")]
    assert (found.common[0].motors, found.common[0].better) == (6, 6)
    states = {state.motor: state.state for state in watched.motors}
    assert states[f"m{SHIFTED}"] == "sensor differs"
    assert states[f"m{WORN}"] == "warmer"
    healthy = [f"m{number}" for number in range(MOTORS) if number not in (WORN, SHIFTED)]
    assert [states[motor] for motor in healthy] == ["ok"] * len(healthy)
    assert not watched.common


def test_every_file_predicts_later_runs_as_the_motors_are_now(refined: tuple[Store, RefinedFleet, Watched]) -> None:
    store, found, _ = refined
    assert set(found.refined) == {f"m{number}" for number in range(MOTORS)}
    for number in (0, WORN, 7):
        run = later(number, 900 + number)  # the worn one as it would be without its fault
        path = model_path(f"m{number}")
        assert error_K(store, refined_path(path), run) < 0.6
        assert error_K(store, path, run) > 3.0


def test_a_file_in_use_is_the_refined_one_until_the_fleet_is_identified_anew(
    refined: tuple[Store, RefinedFleet, Watched], tmp_path: Path
) -> None:
    shutil.copytree(refined[0].url, tmp_path / "store")
    store = Store(str(tmp_path / "store"))
    assert models_of(store, ["m0"])["m0"] == store.read(refined_path(model_path("m0")))
    identify_fleet(store, OPTIONS, Workers(), lambda _: None)
    assert models_of(store, ["m0"])["m0"] == store.read(model_path("m0"))
    assert not store.exists(refined_path(COMMON))


def test_again_gives_the_same_and_computes_nothing(
    refined: tuple[Store, RefinedFleet, Watched], tmp_path: Path
) -> None:
    shutil.copytree(refined[0].url, tmp_path / "store")
    store = Store(str(tmp_path / "store"))
    said: list[str] = []
    assert refine_fleet(store, 6, Workers(), said.append) == refined[1]
    assert said == []
    assert store.read(refined_path(COMMON)) == refined[0].read(refined_path(COMMON))


def test_too_few_newer_runs_are_told(fleet: Store, tmp_path: Path) -> None:
    for number in range(3):
        add_later(fleet, number)
    done = gen("fleet", "refine", "store", "--jobs", "1", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert "3 motor(s) have a newer run than their model; expected 6 at least" in done.stderr
    assert not fleet.exists("refined")


def test_a_broken_file_of_a_motor_is_a_line_and_of_the_mean_the_end(fleet: Store, tmp_path: Path) -> None:
    fleet.write(model_path("m3"), fleet.read(model_path("m3"))[:200])
    models, broken = sound(fleet, identified_paths(fleet, fleet.motors()))
    assert sorted(models) == [f"m{number}" for number in range(MOTORS) if number != 3]
    assert broken["m3"].startswith(f"{fleet.url}/models/motor=m3.json: line ")
    for number in range(6):
        add_later(fleet, number)
    fleet.write(COMMON, b"{")
    done = gen("fleet", "refine", "store", "--jobs", "1", cwd=tmp_path)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert done.stderr.startswith("error: store/models/common.json: line 1, column 2: not valid JSON")
    assert not fleet.exists("refined")
