"""Runs that begin at a wrong reading: the start is as wrong as the sensor, whatever is wrong with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.refinement.network.effects import NetworkEffect
from gen.refinement.network.effects.sensors import Drift, SensorGain, SensorOffset
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.tracing.warm_start import _free
from gen.refinement.network.written import _begun_anew
from tests.refinement.network.motor import finned, read, run, tree

OFF_K = 6.0
CASING = 1


def benched() -> tuple[Bench, Anchored]:
    motor = read(tree())
    runs = []
    for seed in (1, 2):
        made = run(motor, seed)
        runs.append((str(seed), replace(made, temps=made.temps | {"casing": made.temps["casing"] + OFF_K})))
    data = make_data(motor, runs)
    assert motor.model.network is not None
    bench = Bench(data)
    bench.weigh(np.full(2, 10.0))
    return bench, Anchored.of(motor.model.network, 255, data.columns)


def effects_at_the_casing(shape: Anchored) -> dict[str, NetworkEffect]:
    motor = shape.motor()
    return {
        "offset": SensorOffset(motor, CASING),
        "of rise": SensorGain(motor, CASING, of_rise=True),
        "of degC": SensorGain(motor, CASING, of_rise=False),
        "drift": Drift(motor, CASING),
    }


@pytest.mark.parametrize("names", [("offset",), ("offset", "of rise"), ("of degC", "offset", "drift")])
def test_the_prior_is_a_distribution_with_any_effects_at_one_sensor(names: tuple[str, ...]) -> None:
    bench, base = benched()
    every = effects_at_the_casing(base)
    prior = bench.problem(base.with_effects(*(every[name] for name in names))).prior
    assert np.linalg.eigvalsh(prior.precision).min() > 0.0
    assert np.all(prior.deviation > 0.0)


@pytest.mark.parametrize(("name", "value"), [("offset", OFF_K), ("of degC", 0.2)])
def test_a_start_that_follows_its_sensor_costs_nothing_beside_what_the_sensor_does(name: str, value: float) -> None:
    bench, base = benched()
    effect = effects_at_the_casing(base)[name]
    problem = bench.problem(base.with_effects(effect))
    column = int(problem.structure.places[0].columns[0])
    vector = problem.prior.mean.copy()
    vector[column] = value
    own = problem.per_run(vector)
    for r in range(bench.data.later):
        read_K = float(bench.data.inputs.begin[r, CASING])
        own[r, CASING] = -value * (1.0 if name == "offset" else read_K)
    assert problem.penalty(vector) == pytest.approx((value / effect.numbers[0].deviation) ** 2, rel=1e-9)


@pytest.mark.parametrize(("most", "differs"), [(60.0, 1.0), (2.6, 0.0)])
def test_a_factor_that_would_end_at_the_most_that_a_file_holds_is_none(most: float, differs: float) -> None:
    """A file holds less than 8 K for each K of all sensed nodes, factor and shares together."""
    unit, said = np.ones((40, 1, 1)), np.ones(1)
    residual, weight = np.full((40, 1), 49.0), np.full((40, 1), 100.0)
    free = _free(unit, residual, weight, np.ones((40, 1), dtype=np.bool_), said, np.array([most]))
    assert free.tolist() == [differs]


def test_starts_go_with_what_was_refined_but_not_those_with_a_factor_of_their_own() -> None:
    motor = finned()
    motor["network"]["nodes"][-1]["start_from"] = {"casing": 0.5}
    made = read(motor)
    before = made.document.network
    assert before is not None
    anew = _begun_anew(before, before, made, {}).nodes[-1].start_from
    assert anew is not None
    assert anew["casing"] + anew["winding"] == pytest.approx(0.7, abs=0.2)
    assert _begun_anew(before, before, made, {"fins": 1.4}) == before
    without = read(finned())
    assert without.document.network is not None
    assert _begun_anew(without.document.network, without.document.network, without, {}) == without.document.network
