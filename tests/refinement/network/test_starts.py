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
from tests.refinement.network.motor import read, run, tree

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
