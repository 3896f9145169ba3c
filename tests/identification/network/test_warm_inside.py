"""Runs that begin while a mass that nobody measures is warmer than its motor's sensor says."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gen
from gen.identification.logs.sources import read_sources
from gen.identification.network.data import make_network_data
from gen.identification.network.identify import NetworkFound, identify_network
from gen.identification.network.telling.document import network_text
from gen.identification.network.telling.summary import Summary
from gen.identification.settings import Settings
from gen.runs import Run, write_run
from tests.identification.network.plant import ROW_S, Plant, holds

INSIDE = Plant(
    capacity=(80.0, 400.0),
    links=((0, 1, 0.6),),
    surfaces=((0, 0.25, 0.3),),
    heats=((1, 5.0, 12.0),),
    sensed={"casing": 0},
)
"""A rotor that heats its casing, and is not measured."""
BEFORE_MIN, PAUSE_MIN = (30, 45, 70, 100, 50), 6
"""Driven for so long before each run, then paused; the last run is for the test."""


def logged(number: int, *, pause: float = PAUSE_MIN) -> Run:
    """One run whose logger was switched on after a pause."""
    rng = np.random.default_rng(number)
    before = holds((int(rng.integers(120, 255)), BEFORE_MIN[number]), (0, pause))
    speeds = rng.integers(60, 255, 4)
    run = INSIDE.run(np.concatenate([before, holds(*((int(s), 25) for s in speeds), (0, 30))]), rng, noise=0.05)
    kept = slice(before.size, None)
    temps = {name: values[kept] for name, values in run.temps.items()}
    ambient = None if run.ambient is None else run.ambient[kept]
    return Run(ROW_S * np.arange(run.pwm.size - before.size, dtype=np.float64), run.pwm[kept], temps, ambient)


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("runs")
    made = [folder / f"warm{number}.csv" for number in range(len(BEFORE_MIN))]
    for number, path in enumerate(made):
        write_run(path, logged(number))
    return made


@pytest.fixture(scope="module")
def found(paths: list[Path]) -> NetworkFound:
    return identify_network(make_network_data(read_sources(paths[:-1]), None), lambda _: None)


def rms_K(model: gen.Model, path: Path) -> float:
    run = gen.read_run(path)
    error = gen.simulate(model, path)["casing_degC"].to_numpy() - run["casing_degC"].to_numpy()
    return float(np.sqrt(np.nanmean(error**2)))


def test_the_file_says_how_warm_it_begins_and_predicts_the_next_run(
    found: NetworkFound, paths: list[Path], tmp_path: Path
) -> None:
    text, _ = network_text(found, Settings("motor"))
    document = json.loads(text)
    hidden = [node for node in document["network"]["nodes"] if "sensor" not in node]
    assert hidden
    assert any(node["start_factor"] > 1.1 for node in hidden)
    (tmp_path / "as_found.json").write_text(text)
    for node in hidden:
        node["start_factor"] = 1.0
    (tmp_path / "at_rest.json").write_text(json.dumps(document))
    as_found, at_rest = (gen.load(tmp_path / name) for name in ("as_found.json", "at_rest.json"))
    assert rms_K(as_found, paths[-1]) < 0.3
    assert rms_K(at_rest, paths[-1]) > 3.0 * rms_K(as_found, paths[-1])


def test_the_error_that_is_told_is_the_one_that_simulate_gives(
    found: NetworkFound, paths: list[Path], tmp_path: Path
) -> None:
    """Means over bins hide a sensor's noise and steps of 0.25 K: no more than that."""
    text, _ = network_text(found, Settings("motor"))
    (tmp_path / "model.json").write_text(text)
    model = gen.load(tmp_path / "model.json")
    for row, path in zip(Summary(found).rms_K, paths, strict=False):
        noise = np.hypot(0.05, 0.25 / np.sqrt(12.0))
        assert row[0] == pytest.approx(np.sqrt(max(rms_K(model, path) ** 2 - noise**2, 0.0)), abs=0.06)


def test_a_run_that_begins_otherwise_than_the_others_is_named(found: NetworkFound) -> None:
    """The network is right and its start is wrong: the file errs, and that is said."""
    assert not any("begins warmer or colder inside" in warning for warning in Summary(found).warnings())
    problem, vector = found.found.problem, found.found.vector.copy()
    problem.per_run(vector)[1, problem.structure.sensors :] += 12.0
    there = problem.evaluate(vector)
    target = problem.inputs.target - there.residual
    other = replace(problem, inputs=replace(problem.inputs, target=target))
    fit = replace(found.found.fit, vector=vector, evaluated=other.evaluate(vector))
    wrong = replace(found, found=replace(found.found, problem=other, fit=fit))
    said = [warning for warning in Summary(wrong).warnings() if "begins warmer or colder inside" in warning]
    assert len(said) == 1
    assert said[0].startswith("warm1: casing is followed to ")


def test_runs_from_cold_tell_how_warm_a_motor_is_found_that_has_run(paths: list[Path], tmp_path: Path) -> None:
    """None of them begins warm; but what the network does after it has run tells that the rotor is warmer then."""
    made = []
    for number in range(3):
        rng = np.random.default_rng(50 + number)
        speeds = rng.integers(60, 255, 4)
        made.append(tmp_path / f"cold{number}.csv")
        run = INSIDE.run(
            holds(*((int(s), m) for s in speeds for m in (25,)), (0, 30), (200, 20), (0, 15)), rng, noise=0.05
        )
        write_run(made[-1], run)
    found = identify_network(make_network_data(read_sources(made), None), lambda _: None)
    document = json.loads(network_text(found, Settings("motor"))[0])
    hidden = [node for node in document["network"]["nodes"] if "sensor" not in node]
    assert all(node["start_from"]["casing"] > 0.0 for node in hidden)
    errors = []
    for likely in (True, False):
        for node in hidden if not likely else ():
            del node["start_from"]
        (tmp_path / "model.json").write_text(json.dumps(document))
        errors.append(rms_K(gen.load(tmp_path / "model.json"), paths[-1]))
    assert errors[0] < 0.6 * errors[1]
