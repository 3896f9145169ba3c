"""Two effects at once: what was found first may be neither of them, and what was found last tells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gen.refinement.network.effects import NetworkEffect, candidates
from gen.refinement.network.effects.schedule_error import ScheduleError
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench, Fitted
from gen.refinement.network.tracing.changed import looks_like_a_change
from gen.refinement.network.tracing.judged import Judged, judged
from gen.refinement.network.tracing.paths import Path, exchanged, from_another_beginning
from gen.refinement.network.tracing.search import ENOUGH_BESIDE, Considered, Step
from tests.refinement.network.motor import Tree, finned, read, run, tree, wave

BOTH = {"airflow", "sensor_offset"}


def blown() -> Tree:
    """The motor with a fan."""
    motor = tree()
    motor["network"]["channels"] = [{"column": "fan_mps", "range": [0, 10], "neutral": 0}]
    motor["network"]["paths"][1]["factors"] = [{"channel": "fan_mps", "poly": [0.15, 1.0]}]
    return motor


class Later:
    """Two runs of a motor with something that the file does not know, whose winding's sensor reads 2 K too much."""

    def __init__(self, motor: Tree, unexplained_K: float = 0.0) -> None:
        runs = [(f"run {seed}", run(read(motor), seed, {"fan_mps": wave(10 * seed, 0.0, 6.0)})) for seed in (1, 2)]
        for _, each in runs:
            swing = unexplained_K * np.sin(each.time_s / 600.0)
            each.temps["winding"] = each.temps["winding"] + 2.0 + swing
        self.bench = Bench(make_data(read(tree()), runs))
        network = read(tree()).model.network
        assert network is not None
        self.base = self.bench.first(Anchored.of(network, 255, self.bench.data.columns))
        self.null = self.judged(())
        self.every = candidates(self.base.shape.motor(), self.bench.data.offered)

    def judged(self, effects: Sequence[NetworkEffect]) -> Judged:
        """Some effects together."""
        fitted = self.bench.fit(self.base.shape.with_effects(*effects), self.base)
        return judged(self.bench.data, fitted, self.bench.left_out(fitted))

    def considered(self, name: str, *before: NetworkEffect) -> Considered:
        """The first candidate of a name on the winding or the whole motor, beside others."""
        places = ("winding", "motor", "casing")
        named = [e for e in self.every if e.name == name and e.component in places]
        effect = min(named, key=lambda e: places.index(e.component))
        return Considered(effect, self.judged([*before, effect]), 0.0, ())


@pytest.fixture(scope="module")
def later() -> Later:
    return Later(blown())


def names(path: Path) -> set[str]:
    return {one.effect.name for one in path.added}


def test_where_the_first_leaves_much_a_pair_begins_with_something_else(later: Later) -> None:
    wrong, right = later.considered("temperature_dependent_loss"), later.considered("airflow")
    first = Step(later.null, (wrong, right), wrong, ())
    path = from_another_beginning(later.bench, Path((first,), wrong.judged), later.every, lambda _: None)
    assert names(path) == BOTH
    assert path.now.floors < 1.1
    assert [one.effect.name for one in path.steps[0].considered if one.reasons] == ["temperature_dependent_loss"]
    assert [one.effect.name for one in path.added] == list(path.now.names)


def test_a_part_without_a_sensor_is_tried_as_the_second_of_a_pair() -> None:
    later = Later(finned())
    wrong, right = later.considered("temperature_dependent_loss"), later.considered("sensor_offset")
    first = Step(later.null, (wrong, right), wrong, ())
    every = [effect for effect in later.every if effect.name == "hidden_node"]
    path = from_another_beginning(later.bench, Path((first,), wrong.judged), every, lambda _: None)
    assert names(path) == {"sensor_offset", "hidden_node"}
    assert path.now.floors < 1.1


def test_what_cannot_be_the_reason_begins_no_pair(later: Later) -> None:
    wrong, right = later.considered("temperature_dependent_loss"), later.considered("airflow")
    right = Considered(right.effect, right.judged, right.p_value, ("its number is at its limit",))
    path = Path((Step(later.null, (wrong, right), wrong, ()),), wrong.judged)
    assert from_another_beginning(later.bench, path, later.every, lambda _: None) is path


def changed(later: Later, floors: float) -> Path:
    """A search that ended in what looks like another motor: heat of the winding has grown at every speed."""
    motor = later.base.shape.motor()
    wear = ScheduleError(motor, [motor.names.index("winding")], "winding")
    shape = later.base.shape.with_effects(wear)
    shared, own = np.split(later.base.vector, [later.base.shape.size])
    vector = np.concatenate([shared, np.log([1.0, 1.3, 1.4, 1.4, 1.4, 1.3]), own])
    fitted = Fitted(later.bench.problem(shape), replace(later.base.fit, vector=vector))
    found = replace(later.null, fitted=fitted, score_K=floors * later.null.noise_K)
    one = Considered(wear, found, 0.0, ())
    assert looks_like_a_change(wear, one.values, later.bench.data)
    return Path((Step(later.null, (one, later.considered("airflow")), one, ()),), found)


def test_a_change_that_leaves_much_is_no_end(later: Later) -> None:
    path = from_another_beginning(later.bench, changed(later, 20.0), later.every, lambda _: None)
    assert names(path) == BOTH
    assert path.now.floors < 1.1


def test_a_change_is_given_up_only_for_what_explains_the_error() -> None:
    """It would be learnt, and the change with it."""
    later = Later(blown(), unexplained_K=0.5)
    path = changed(later, 20.0)
    assert from_another_beginning(later.bench, path, later.every, lambda _: None) is path


@pytest.mark.parametrize(("unexplained_K", "given_up"), [(0.0, True), (0.5, False)])
def test_a_change_that_was_found_first_is_given_up_only_for_what_explains_the_error(
    unexplained_K: float, *, given_up: bool
) -> None:
    later = Later(blown(), unexplained_K)
    first = changed(later, 20.0)
    (wear,) = first.added
    offset = later.considered("sensor_offset")
    shape = later.base.shape.with_effects(wear.effect, offset.effect)
    shared, own = np.split(later.base.vector, [later.base.shape.size])
    vector = np.concatenate([shared, np.log([1.0, 1.3, 1.4, 1.4, 1.4, 1.3]), [2.0], own])
    fitted = Fitted(later.bench.problem(shape), replace(later.base.fit, vector=vector))
    now = replace(later.null, fitted=fitted, score_K=10.0 * later.null.noise_K)
    second = replace(offset, judged=now)
    path = Path((*first.steps, Step(first.now, (second,), second, ())), now)
    other = exchanged(later.bench, path, later.every, lambda _: None)
    assert names(other) == (BOTH if given_up else {"schedule_error", "sensor_offset"})


def test_what_is_left_beside_a_change_that_explains_the_error_is_not_sought(later: Later) -> None:
    path = changed(later, 1.28)
    assert path.now.floors > ENOUGH_BESIDE
    assert from_another_beginning(later.bench, path, later.every, lambda _: None) is path


def test_what_explains_nearly_all_is_not_searched_again(later: Later) -> None:
    first = later.considered("airflow")
    both = later.considered("sensor_offset", first.effect)
    steps = (Step(later.null, (first,), first, ()), Step(first.judged, (both,), both, ()))
    path = Path((*steps, Step(both.judged, (), None, ())), both.judged)
    assert from_another_beginning(later.bench, path, [], lambda _: None) is path


def test_what_was_found_first_is_asked_for_anew_beside_the_last(later: Later) -> None:
    wrong = later.considered("temperature_dependent_loss")
    last = later.considered("sensor_offset", wrong.effect)
    steps = (Step(later.null, (wrong,), wrong, ()), Step(wrong.judged, (last,), last, ()))
    path = exchanged(later.bench, Path(steps, last.judged), later.every, lambda _: None)
    assert names(path) == BOTH
    assert path.now.score_K < last.judged.score_K
    assert [one.effect.name for one in path.added] == list(path.now.names)
    fitted = path.now.fitted
    values = dict(zip(path.now.names, fitted.shape.values(fitted.vector), strict=True))
    assert np.isclose(values["sensor_offset"][0], 2.0, atol=0.3)


def test_a_right_first_effect_is_not_exchanged(later: Later) -> None:
    first = later.considered("airflow")
    both = later.considered("sensor_offset", first.effect)
    path = Path((Step(later.null, (first,), first, ()), Step(first.judged, (both,), both, ())), both.judged)
    kept = exchanged(later.bench, path, later.every, lambda _: None)
    assert kept.now is path.now
    assert [one.effect for one in kept.added] == [first.effect, both.effect]


def test_one_effect_alone_is_not_exchanged(later: Later) -> None:
    first = later.considered("airflow")
    path = Path((Step(later.null, (first,), first, ()),), first.judged)
    assert exchanged(later.bench, path, [], lambda _: None) is path
