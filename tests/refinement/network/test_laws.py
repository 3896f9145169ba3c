"""Natural convection and radiation: in a file that is refined, and as what is missing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gen
from gen.refinement.network.changing.excess import REFERENCE
from gen.refinement.network.effects.radiation import Radiation
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from tests.refinement.network.motor import NOISE_K, Tree, read, run, tree
from tests.refinement.network.test_refine_network import error_K, files

AREA_W_PER_K = 0.12
RADIATES: dict[str, Any] = {
    "between": ["casing", "ambient"],
    "conductance_W_per_K": {"poly": [AREA_W_PER_K]},
    "radiation": {"reference_degC": REFERENCE},
}
CONVECTS: dict[str, Any] = {
    "between": ["winding", "ambient"],
    "conductance_W_per_K": {"poly": [0.1]},
    "convection": {"poly": [-3e-5, 0.011, 0.6]},
}


def with_paths(*paths: dict[str, Any]) -> Tree:
    made = tree()
    made["network"]["paths"] += paths
    return made


def away_K(motor: Tree, file: Tree, *conductances: float) -> float:
    """Largest error of the fit's curves along runs of a motor, the file with a radiation of the casing beside."""
    plant, known = read(motor), read(file)
    data = make_data(known, [("one", run(plant, 1, noise_K=0.001)), ("two", run(plant, 2, noise_K=0.001))])
    bench = Bench(data)
    bench.weigh(np.full(2, 10.0))
    assert known.model.network is not None
    base = Anchored.of(known.model.network, 255, data.columns)
    if not conductances:
        return float(np.nanmax(np.abs(bench.as_it_is(base))))
    shape = base.with_effects(Radiation(base.motor(), 1))
    problem = bench.problem(shape)
    vector = problem.prior.mean.copy()
    vector[shape.places[0].columns] = np.log(conductances)
    seen = data.is_later[:, None] & (data.inputs.covered > 0.0)
    return float(np.abs(problem.evaluate(vector).residual[seen]).max())


def test_a_file_with_laws_predicts_in_the_fit_what_it_predicts() -> None:
    """The fit is exact over bins for conductances; a law's excess is held over a bin."""
    curved = with_paths(RADIATES, CONVECTS)
    assert away_K(curved, curved) < 0.1
    assert away_K(curved, tree()) > 10.0


def test_a_radiation_beside_a_file_is_the_law_of_the_network() -> None:
    assert away_K(with_paths(RADIATES), tree(), AREA_W_PER_K) < 0.1
    # Nearest by a conductance alone, which is what a coupling to the ambient would be.
    assert away_K(with_paths(RADIATES), tree(), 1e-6) > 3.0


def refined(motor: Tree, file: Tree, folder: Path) -> gen.Refinement:
    path = folder / "small.json"
    path.write_text(json.dumps(file), encoding="utf-8")
    one, two, three = files(motor, folder)
    return gen.refine(gen.load(path), fit=[one, two], test=[three])


def test_radiation_is_found_and_written_as_a_law(tmp_path: Path) -> None:
    found = refined(with_paths(RADIATES), tree(), tmp_path)
    row = found.effects().iloc[0].to_dict()
    assert (row["effect"], row["component"]) == ("radiation", "casing")
    assert row["parameters"]["conductance_W_per_K"] == pytest.approx(AREA_W_PER_K, rel=0.15)
    assert found.verdict == "explained"
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    network = found.model.coefficients.model.network
    assert network is not None
    assert len(network.laws) == 1


def test_a_file_with_a_law_is_refined_and_keeps_it(tmp_path: Path) -> None:
    """A motor with natural convection, whose cooling at rest has changed."""
    motor = with_paths(CONVECTS)
    motor["network"]["paths"][1]["conductance_W_per_K"]["at_rest"] = 0.5
    found = refined(motor, with_paths(CONVECTS), tmp_path)
    assert found.effects().iloc[0].to_dict()["effect"] == "standstill_cooling"
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    network = found.model.coefficients.model.network
    assert network is not None
    assert len(network.laws) == 1


def test_radiation_is_added_to_one_that_is_there(tmp_path: Path) -> None:
    """Half of it was known, for another temperature."""
    known = {**RADIATES, "radiation": {"reference_degC": 80}}
    known["conductance_W_per_K"] = {"poly": [0.5 * AREA_W_PER_K * (353.15 / 298.15) ** 3]}
    found = refined(with_paths(RADIATES), with_paths(known), tmp_path)
    assert found.effects().iloc[0].to_dict()["effect"] == "radiation"
    assert error_K(found, tmp_path) < 1.2 * NOISE_K
    network = found.model.coefficients.model.network
    assert network is not None
    assert len(network.laws) == 1
