"""A run that is left out whole is predicted from where it begins: nothing else of it may tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.refinement.network.effects.sensors import SensorOffset
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench, Fitted, forget
from tests.refinement.network.motor import Tree, read, run, tree

RUNS, OFF_K = 5, 3.0


def with_a_core() -> Tree:
    """The motor with a mass inside that nobody sees."""
    made = tree()
    made["network"]["nodes"].append({"name": "core", "capacity_J_per_K": 900})
    made["network"]["paths"].append({"between": ["core", "winding"], "conductance_W_per_K": {"poly": [0.4]}})
    return made


@pytest.fixture(scope="module")
def bench() -> Bench:
    """Runs of that motor, its core heated, whose casing's sensor reads too much, so that no run seems to begin cold."""
    motor = with_a_core()
    motor["network"]["heats"].append({"node": "core", "power_W": {"poly": [0.01, 0.0]}})
    runs = [(f"run {seed}", run(read(motor), seed)) for seed in range(RUNS)]
    for _, each in runs:
        each.temps["casing"] = each.temps["casing"] + OFF_K
    return Bench(make_data(read(with_a_core()), runs))


@pytest.fixture(scope="module")
def fitted(bench: Bench) -> Fitted:
    """The file beside the offset; the heat that it lacks is not sought."""
    network = read(with_a_core()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    return bench.fit(base.shape.with_effects(SensorOffset(base.shape.motor(), 1)), base)


def rms(error: FloatArray) -> float:
    return float(np.sqrt(np.nanmean(error**2)))


def test_hidden_starts_that_were_fitted_to_a_run_do_not_predict_it(bench: Bench, fitted: Fitted) -> None:
    row = bench.data.inputs.rows[0]
    at = fitted.shape.size + fitted.shape.names.index("core")
    warmer = fitted.vector.copy()
    warmer[at] += 12.0
    other = Fitted(fitted.problem, replace(fitted.fit, vector=warmer))
    error, its = bench.left_out(fitted)[row], bench.left_out(other)[row]
    assert rms(fitted.problem.evaluate(warmer).residual[row] - fitted.fit.evaluated.residual[row]) > 0.5
    assert rms(error - its) < 0.02


def test_a_forgotten_start_is_the_reading_less_what_is_found_wrong_with_the_sensor(fitted: Fitted) -> None:
    """Were it the reading, the casing would begin 3 K too warm, and be 3 K beside its readings."""
    vector = fitted.vector.copy()
    forget(fitted.problem, vector, 0)
    offset = fitted.shape.values(vector)[-1][0]
    assert abs(offset - OFF_K) < 0.5
    assert np.allclose(fitted.problem.per_run(vector)[0], [0.0, -offset, 0.0], atol=1e-6)
    assert np.array_equal(fitted.problem.per_run(vector)[1:], fitted.problem.per_run(fitted.vector)[1:])
