"""Which of several names stays: what is needed, what all runs speak for; a fault in doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.refinement.network.effects import NetworkEffect, candidates
from gen.refinement.network.effects.schedule_error import ScheduleError
from gen.refinement.network.effects.sensors import SensorOffset
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench, Fitted
from gen.refinement.network.tracing.judged import Judged, judged
from gen.refinement.network.tracing.search import PRICE, Considered, Step, may_be_a_fault, to_judge
from gen.refinement.network.tracing.trace import needed
from tests.refinement.network.motor import read, run, tree, wave


@pytest.fixture(scope="module")
def bench() -> Bench:
    """Two runs of a motor with a fan that the file does not know."""
    motor = tree()
    motor["network"]["channels"] = [{"column": "fan_mps", "range": [0, 10], "neutral": 0}]
    motor["network"]["paths"][1]["factors"] = [{"channel": "fan_mps", "poly": [0.15, 1.0]}]
    runs = [(f"run {seed}", run(read(motor), seed, {"fan_mps": wave(10 * seed, 0.0, 6.0)})) for seed in (1, 2)]
    return Bench(make_data(read(tree()), runs))


def found(bench: Bench, base: Fitted, names: tuple[str, ...]) -> tuple[list[Step], Judged]:
    """Searches that added one after the other, whatever they brought."""

    def with_effects(*effects: NetworkEffect) -> Judged:
        fitted = bench.fit(base.shape.with_effects(*effects), base)
        return judged(bench.data, fitted, bench.left_out(fitted))

    offered = {effect.name: effect for effect in reversed(candidates(base.shape.motor(), bench.data.offered))}
    steps, so_far, now = [], [], with_effects()
    for name in names:
        so_far.append(offered[name])
        one = with_effects(*so_far)
        considered = Considered(offered[name], one, 0.0, ())
        steps.append(Step(now, (considered,), considered, ()))
        now = one
    return [*steps, Step(now, (), None, ())], now


@pytest.mark.parametrize("names", [("coupling", "airflow"), ("temperature_dependent_loss", "airflow")])
def test_what_stood_for_the_second_goes_when_the_second_is_there(bench: Bench, names: tuple[str, ...]) -> None:
    network = read(tree()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    steps, final = found(bench, base, names)
    left, judged_left = needed(bench, steps, final, lambda _: None)
    assert [step.added.effect.name for step in left if step.added] == ["airflow"]
    assert judged_left.names == ("airflow",)
    assert judged_left.score_K < 1.1 * final.score_K


def test_a_first_effect_that_is_needed_stays(bench: Bench) -> None:
    network = read(tree()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    steps, final = found(bench, base, ("airflow", "coupling"))
    left, judged_left = needed(bench, steps, final, lambda _: None)
    assert (left, judged_left) == (steps, final)


@pytest.mark.parametrize(("relief", "stays"), [(500.0, True), (20.0, False)])
def test_a_first_effect_that_takes_little_stays_where_all_runs_plainly_speak_for_it(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, relief: float, stays: bool
) -> None:
    network = read(tree()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    steps, final = found(bench, base, ("airflow", "coupling"))
    cost = final.fitted.fit.cost + relief
    fitted = replace(final.fitted, fit=replace(final.fitted.fit, cost=cost))
    without = judged(bench.data, fitted, 1.06 * final.error)
    monkeypatch.setattr("gen.refinement.network.tracing.trace._without", lambda *_: without)
    left, _ = needed(bench, steps, final, lambda _: None)
    assert (left == steps) is stays


@pytest.mark.parametrize(("more", "doubt"), [(20.0, True), (300.0, False)])
def test_wear_in_doubt_is_wear_unless_all_runs_speak_against_it(bench: Bench, more: float, doubt: bool) -> None:
    network = read(tree()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    motor = base.shape.motor()
    wear, other = ScheduleError(motor, [motor.names.index("winding")], "winding"), SensorOffset(motor, 0)
    error = bench.left_out(base)

    def considered(effect: NetworkEffect, cost: float, values: tuple[float, ...]) -> Considered:
        shape = base.shape.with_effects(effect)
        vector = np.concatenate([base.vector[: base.shape.size], list(values)])
        price = PRICE * len(effect.numbers)
        fitted = Fitted(bench.problem(shape), replace(base.fit, vector=vector, cost=cost - price))
        return Considered(effect, judged(bench.data, fitted, error), 0.0, ())

    as_good = considered(other, 400.0, (3.0,))
    grown = considered(wear, 400.0 + more, tuple(np.log([1.0, 1.3, 1.4, 1.4, 1.4, 1.3])))
    assert may_be_a_fault(bench.data, as_good, grown) is doubt


def test_beside_a_fit_at_its_limit_the_best_is_judged_that_nothing_speaks_against(bench: Bench) -> None:
    network = read(tree()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    airflow = next(one for one in candidates(base.shape.motor(), bench.data.offered) if one.name == "airflow")
    fitted = bench.fit(base.shape.with_effects(airflow), base)

    def priced(cost: float, gain: float) -> Fitted:
        vector = fitted.vector.copy()
        vector[fitted.shape.places[0].columns] = gain
        return replace(fitted, fit=replace(fitted.fit, vector=vector, cost=cost))

    most = airflow.numbers[0].high
    best, worse, worst = (priced(10.0 * k, 0.5) for k in range(3))
    assert to_judge([worse, best, worst]) == [best]
    best = priced(0.0, most)
    assert to_judge([worst, worse, best]) == [best, worse]
    worse = priced(10.0, most)
    assert to_judge([worst, worse, best]) == [best, worst]
    assert to_judge([worse, best]) == [best]
