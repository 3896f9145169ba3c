"""A small fleet from run files to models, states and pages."""

from __future__ import annotations

import io
import json
import os
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gen.coefficients import parse
from gen.errors import InputError
from gen.fleet import identify
from gen.fleet.chosen import evenly
from gen.fleet.folder.models import COMMON, model_path, refined_path, with_model
from gen.fleet.folder.store import TASKS, Store
from gen.fleet.identify import Identified, identify_fleet, in_rounds, runs_of
from gen.fleet.report import pages_of
from gen.fleet.tasks.common import Common, common_of, kept, structure_json, structure_of
from gen.fleet.tasks.fitting import model_name
from gen.fleet.tasks.motor_data import check_inputs
from gen.fleet.tasks.scouting import without_warmth
from gen.fleet.tasks.work import Arrays, Workers
from gen.fleet.watch import read_watched, watch
from gen.identification.network.fitting.structure import full
from gen.reference.simulate import simulate_run
from tests.fleet.conftest import MOTORS, OPTIONS
from tests.fleet.made import run_of


def silent(_: str) -> None:
    pass


def test_what_cannot_be_used_is_a_line(identified: tuple[Path, Identified]) -> None:
    found = identified[1]
    assert sorted(found.left_out_K) == [f"m{number}" for number in range(MOTORS)]
    assert list(found.refused) == ["short"]
    assert any("fault bearing" in line for line in found.lines)
    assert any("is no run of a store" in line for line in found.lines)


def test_a_motor_that_is_refused_has_no_model_from_another_time(fleet: Store) -> None:
    """It would be watched, refined and built with a model of which the command says that there is none."""
    path = model_path("m4")
    fleet.write(refined_path(path), fleet.read(path))
    (kept,) = fleet.runs("m4")
    fleet.write(kept.path, b"half of")
    for name in fleet.names(TASKS):
        if name.startswith("model_in_common-"):
            fleet.remove(f"{TASKS}/{name}")
    found = identify_fleet(fleet, OPTIONS, Workers(), silent)
    assert sorted(found.refused) == ["m4", "short"]
    assert not fleet.exists(path)
    assert not fleet.exists(refined_path(path))
    assert sorted(with_model(fleet, fleet.motors())) == sorted(found.left_out_K)


def test_every_model_is_a_coefficient_file_that_predicts_another_run(fleet: Store) -> None:
    for path in (COMMON, model_path("m3")):
        model = parse(fleet.read(path))
        assert model.document.provenance is not None
        assert model.document.provenance.source == "gen fleet identify"
        run = run_of(500)
        shown = simulate_run(model, run, "exact", "auto", "run")
        error = np.concatenate([shown[f"{name}_degC"] - values for name, values in run.temps.items()])
        assert np.sqrt(np.mean(error**2)) < 3.0, path


def test_a_motors_own_model_is_nearer_to_it_than_the_fleets(fleet: Store) -> None:
    own: list[float] = []
    mean: list[float] = []
    for number in range(MOTORS):
        rng = np.random.default_rng(1000 + number)
        heat, capacity = np.exp(rng.normal(0.0, 0.08, 2)).tolist()
        run = run_of(900 + number, heat=heat, capacity=capacity)
        for errors, path in ((own, model_path(f"m{number}")), (mean, COMMON)):
            shown = simulate_run(parse(fleet.read(path)), run, "exact", "auto", "run")
            errors.append(float(np.mean([(shown[f"{name}_degC"] - values) ** 2 for name, values in run.temps.items()])))
    assert np.sqrt(np.mean(own)) < 0.6 * np.sqrt(np.mean(mean))


def test_again_gives_the_same_bytes_and_computes_nothing(fleet: Store) -> None:
    before = {path: fleet.read(path) for path in (COMMON, *(model_path(f"m{number}") for number in range(MOTORS)))}
    tasks = fleet.names(TASKS)
    identify_fleet(fleet, OPTIONS, Workers(), silent)
    assert {path: fleet.read(path) for path in before} == before
    assert fleet.names(TASKS) == tasks


def test_of_many_motors_some_make_the_mean_and_all_get_a_model(fleet: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = runs_of(fleet)
    names = sorted(runs)
    assert evenly(names, 3) == [names[0], names[(MOTORS - 1) // 2], names[-1]]
    assert evenly(names, 100) == names
    before = set(fleet.names(TASKS))
    monkeypatch.setattr(identify, "MOST_POOLED", 3)
    found = identify_fleet(fleet, OPTIONS, Workers(), silent)
    fits = [name for name in set(fleet.names(TASKS)) - before if name.startswith("fitted_in_common")]
    assert len(fits) == 4  # of the second and the third round, the first is there; the run of "short" cannot be used
    assert set(found.left_out_K) == set(runs) - {"short"}


def test_a_scout_in_still_air_lends_its_form_without_that() -> None:
    """Numbers keep their places: what is left out stands before the sensors' offsets."""
    plain = full(("casing", "magnet"), 1)
    numbers = np.arange(plain.size + 40.0)
    there = replace(plain, natural=80.0)
    vector = np.insert(numbers, int(there.still[0]), -1.0)
    form, shared = without_warmth(there, vector)
    assert form == structure_of(structure_json(form)) == plain
    assert shared.tolist() == numbers[: plain.size].tolist()


@pytest.mark.parametrize(("errors", "stays"), [((0.11, 0.12, 0.11), 2), ((0.11, 0.12, 0.57), 1), ((0.1, 0.3), 0)])
def test_a_round_that_fits_motors_worse_is_not_taken(fleet: Store, errors: tuple[float, ...], stays: int) -> None:
    """Whatever it says of itself: the fleet stays with the mean and spread of the round before."""
    begun, seen = kept(fleet), list[Common]()
    size = begun.structure.size
    told = {"matrix": np.eye(size), "vector": np.full(size, 0.5)}

    def fits_of(common: Common) -> list[Arrays]:
        seen.append(common)
        return [{**told, "off_K": np.array(errors[len(seen) - 1])}]

    assert in_rounds(fits_of, begun) is seen[stays]
    assert len(seen) == len(errors)
    assert len({common.pool.mean.tobytes() for common in seen}) == len(seen)


def test_what_the_fleet_shares_is_kept_exactly(fleet: Store) -> None:
    common = kept(fleet)
    assert common_of(json.loads(json.dumps(common.as_json()))).as_json() == common.as_json()
    assert np.all(common.pool.variance > 0.0)
    assert np.all(common.pool.mean[common.structure.offsets] == 0.0)


def test_a_store_of_somebody_else_runs_no_code(tmp_path: Path) -> None:
    store = Store(str(tmp_path / "store"))
    made = io.BytesIO()
    np.savez(made, said=np.array([Harmful(str(tmp_path / "harm"))], dtype=object))
    store.write("models/common.npz", made.getvalue())
    with pytest.raises(ValueError, match="allow_pickle"):
        kept(store)
    assert not (tmp_path / "harm").exists()


class Harmful:
    """Makes a folder when it is unpickled."""

    def __init__(self, path: str) -> None:
        self._path = path

    def __reduce__(self) -> tuple[Callable[[str], None], tuple[str]]:
        return os.mkdir, (self._path,)


def test_a_new_motor_gets_a_model_and_the_others_keep_theirs(fleet: Store, tmp_path: Path) -> None:
    store = Store(str(tmp_path / "other"))
    for path in (COMMON, model_path("m3"), "models/common.npz"):
        store.write(path, fleet.read(path))
    store.add("m3", "2026-01-01", "run", run_of(30))
    store.add("new", "2026-01-02", "run", run_of(40, hours=0.6))
    found = identify_fleet(store, replace(OPTIONS, only_new=True), Workers(), silent)
    assert list(found.left_out_K) == ["new"]
    assert store.read(model_path("m3")) == fleet.read(model_path("m3"))


def _more_heat_shows_K() -> float:
    """What 15 % more heat does to all readings of a usual motor, root mean square: the same noise with and without."""
    shown = []
    for number in range(MOTORS):
        heat, capacity = np.exp(np.random.default_rng(1000 + number).normal(0.0, 0.08, 2)).tolist()
        with_it, without = (
            run_of(600 + number, heat=more * heat, capacity=capacity, hours=3.0) for more in (1.15, 1.0)
        )
        away = [with_it.temps[part] - without.temps[part] for part in with_it.temps]
        shown.append(float(np.sqrt(np.mean(np.square(away)))))
    return float(np.median(shown))


def test_a_fault_of_one_and_an_effect_of_all_are_told_apart(fleet: Store) -> None:
    with pytest.raises(InputError, match="gen fleet watch"):
        pages_of(fleet)
    for number in range(MOTORS):
        rng = np.random.default_rng(1000 + number)
        heat, capacity = np.exp(rng.normal(0.0, 0.08, 2)).tolist()
        # All are 15 % warmer than when they were identified; one has a shifted sensor beside.
        run = run_of(600 + number, heat=1.15 * heat, capacity=capacity, offset=12.0 if number == 4 else 0.0, hours=3.0)
        fleet.add(f"m{number}", "2026-02-01", "later", run)
    found = watch(fleet, 0.05, Workers(), silent)
    states = {state.motor: state for state in found.motors}
    assert len(found.common) == 1
    assert "warmer" in found.common[0]
    said_K = re.search(r"by ([+-][\d.]+) K in the readings", found.common[0])
    assert said_K is not None
    assert float(said_K[1]) == pytest.approx(_more_heat_shows_K(), rel=0.15)
    assert states["m4"].state == "sensor differs"
    assert "casing" in states["m4"].said
    assert states["m4"].last_alarm == "2026-02-01: sensor differs"
    assert {state.state for name, state in states.items() if name != "m4"} == {"ok", "not enough data"}
    assert states["short"].state == "not enough data"
    assert read_watched(fleet) == found
    pages = pages_of(fleet)
    assert set(pages) == {"index.html", "manifest.json", *(f"motors/{motor}.html" for motor in states)}
    assert "casing" in pages["motors/m4.html"]
    for text in pages.values():
        assert "http" not in text.replace("http-equiv", "")
        assert "innerHTML" not in text


def test_in_a_small_fleet_a_motor_is_held_against_its_own_model(fleet: Store) -> None:
    """Two motors tell no scale, but one of them heats by half more than it did when it was identified."""
    for number, grown in ((0, 1.0), (1, 1.5)):
        heat, capacity = np.exp(np.random.default_rng(1000 + number).normal(0.0, 0.08, 2)).tolist()
        fleet.add(
            f"m{number}", "2026-02-01", "later", run_of(700 + number, heat=grown * heat, capacity=capacity, hours=3.0)
        )
    states = {state.motor: state for state in watch(fleet, 0.05, Workers(), silent).motors}
    assert states["m0"].state == "not enough data"
    assert states["m1"].state == "differs from its model"
    assert "2 motors have a newer run than their model; expected 8" in states["m1"].said
    assert states["m1"].last_alarm == "2026-02-01: differs from its model"


@pytest.mark.parametrize("readings", [0, 3])
def test_a_motor_that_was_hardly_read_is_not_judged(readings: int, fleet: Store) -> None:
    """Neither well nor different: its sensors came off, or were not wired, and nothing is known of it."""
    for number in range(MOTORS):
        heat, capacity = np.exp(np.random.default_rng(1000 + number).normal(0.0, 0.08, 2)).tolist()
        run = run_of(600 + number, heat=1.15 * heat, capacity=capacity, offset=2.0, hours=1.5)
        if number == 4:
            there = np.arange(run.time_s.size) < readings
            run = replace(run, temps={part: np.where(there, values, np.nan) for part, values in run.temps.items()})
        fleet.add(f"m{number}", "2026-02-01", "later", run)
    found = watch(fleet, 0.05, Workers(), silent)
    states = {state.motor: state for state in found.motors}
    assert states["m4"].state == "not enough data"
    (kept,) = [run for run in fleet.runs("m4") if run.day == "2026-02-01"]
    assert kept.path in states["m4"].said
    assert found.limit is not None  # eight others are judged as ever
    assert "expected 8 at least" not in " ".join(state.said for state in found.motors)


@pytest.mark.parametrize("name", ["../../x", "a/b", ""])
def test_states_of_somebody_else_lead_no_page_out_of_its_folder(name: str, tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    state = {"motor": name, "state": "ok", "said": "", "course_K": [], "days": []}
    store.write("watch.json", json.dumps({"motors": [state], "common": [], "limit": None, "level": 0.01}).encode())
    with pytest.raises(InputError, match="is not what gen fleet watch writes"):
        pages_of(store)


def test_what_a_state_says_is_text_and_no_markup(tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    bad = "<script>alert(1)</script>"
    state = {"motor": "a", "state": bad, "said": bad, "course_K": [0.1, None], "days": [bad, bad], "last_alarm": bad}
    store.write("watch.json", json.dumps({"motors": [state], "common": [bad], "limit": 4.0, "level": 0.01}).encode())
    for text in pages_of(store).values():
        assert bad not in text


PERCENT = {"input": "pwm_percent, 255 = 100 percent"}
CURRENT = {"input": "current_A, 255 = 12 A"}


@pytest.mark.parametrize("other", ["m0", "m2"])
def test_another_input_is_told_before_anything_is_fitted(other: str, tmp_path: Path) -> None:
    """Of one of a motor's runs, or of a motor: what a count stands for has to be one for all."""
    store = Store(str(tmp_path / "store"))
    for number in range(2):
        store.add(f"m{number}", "2026-01-01", "run", replace(run_of(number), comments=PERCENT))
    kept, _ = store.add(other, "2026-01-02", "later", replace(run_of(7), comments=CURRENT))
    assert store.comments(kept) == CURRENT
    with pytest.raises(InputError) as told:
        identify_fleet(store, OPTIONS, Workers(), silent)
    assert kept.path in str(told.value)
    assert "found current_A, 255 = 12 A; expected one input for all runs" in str(told.value)
    assert not store.exists(TASKS)


def test_the_input_of_a_run_that_takes_no_part_does_not_count(tmp_path: Path) -> None:
    store = Store(str(tmp_path / "store"))
    store.add("m0", "2026-01-01", "run", replace(run_of(0), comments=PERCENT))
    store.add("m0", "2026-01-02", "worn", replace(run_of(1), comments={**CURRENT, "fault": "bearing"}))
    broken, _ = store.add("m0", "2026-01-03", "broken", run_of(2))
    store.write(broken.path, b"half of")
    check_inputs(store, runs_of(store))


def test_a_store_without_runs_is_told(tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    for command in (runs_of, lambda store: watch(store, 0.01, Workers(), silent)):
        with pytest.raises(InputError, match="there are no runs"):
            command(store)


def test_a_store_that_was_not_identified_is_told(tmp_path: Path) -> None:
    store = Store(str(tmp_path))
    store.add("m0", "2026-01-01", "run", run_of(1, hours=0.1))
    with pytest.raises(InputError, match="gen fleet identify"):
        watch(store, 0.01, Workers(), silent)


@pytest.mark.parametrize(
    ("motor", "name"), [("pump-17", "pump_17"), ("7", "motor_7"), ("int", "motor"), ("a.b__c", "a_b_c")]
)
def test_a_motor_has_a_name_that_firmware_can_have(motor: str, name: str) -> None:
    assert model_name(motor) == name
