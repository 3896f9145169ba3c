"""A narrow error of a schedule: found where runs were, and nothing made up where none was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.fleet.statistics.shared_effects import together
from gen.model.network_solution import NetworkSolution
from gen.refinement.network.effects.base import WHOLE, NetworkEffect
from gen.refinement.network.effects.schedule_error import NARROW, ScheduleError, offered
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.tracing.search import to_fit
from gen.runs import Run
from tests.refinement.network.motor import NOISE_K, ROW_S, read, tree

HELD = (60, 100, 130, 150, 165, 172)
"""PWM of half an hour each: nothing between two thirds of full speed and full speed."""


def run(seed: int) -> Run:
    """The motor of `tree` whose heats rise steeply at the upper end of what it is run at, by 40 % at 172."""
    motor = tree()
    pwm = np.arange(0, 256, 5)
    factor = 1.0 + 0.4 / (1.0 + np.exp(-(pwm - 160) / 6.0))
    for heat in motor["network"]["heats"]:
        watts = factor * np.polyval(heat["power_W"]["poly"], pwm)
        heat["power_W"] = {"table": {"pwm": pwm.tolist(), "value": watts.tolist(), "interpolation": "pchip"}}
    chance = np.random.default_rng(seed)
    levels = np.repeat(chance.permutation([0, *HELD]), round(1800.0 / ROW_S)).astype(np.int64)
    time = ROW_S * np.arange(levels.size, dtype=np.float64)
    room = np.full(time.size, 24.0)
    temps = NetworkSolution(read(motor).model).simulate_times(
        time, levels, room, {}, dict.fromkeys(("winding", "casing"), 24.0)
    )
    noisy = {name: values + chance.normal(0.0, NOISE_K, values.size) for name, values in temps.items()}
    return Run(time, levels, noisy, room, {})


@pytest.fixture(scope="module")
def bench() -> Bench:
    return Bench(make_data(read(tree()), [(f"run {seed}", run(seed)) for seed in (1, 2)]))


def test_runs_say_at_which_speeds_they_were(bench: Bench) -> None:
    percent = np.arange(0, 101, 5)
    known = bench.data.offered.was_run(percent / 100.0, 0.05)
    assert percent[known].tolist() == [20, 25, 35, 40, 50, 55, 60, 65, 70]


def test_what_no_run_says_stays_what_the_file_says(bench: Bench) -> None:
    network = read(tree()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    motor = base.shape.motor()
    (narrow,) = (
        effect
        for effect in offered(motor, bench.data.offered)
        if isinstance(effect, ScheduleError) and effect.component == WHOLE and len(effect.numbers) == NARROW.knots.size
    )
    fitted = bench.finished(bench.fit(base.shape.with_effects(narrow), base))
    factor = narrow.factor(np.array([150 / 255, 172 / 255, 0.8, 0.9, 1.0]), fitted.shape.values(fitted.vector)[-1])
    assert factor[:2] == pytest.approx([1.08, 1.35], abs=0.05)
    assert np.all(np.abs(np.log(factor[2:])) < 0.25)


def test_a_fleet_has_run_where_any_of_its_motors_has(bench: Bench) -> None:
    one = bench.data.offered
    other = replace(one, turned_s=tuple(reversed(one.turned_s)))
    mine, its = (each.was_run(NARROW.knots, 0.05) for each in (one, other))
    assert not np.array_equal(mine, its)
    assert np.array_equal(together([one, other]).was_run(NARROW.knots, 0.05), mine | its)


def test_of_forms_at_one_place_the_best_elsewhere_is_fitted_too(bench: Bench) -> None:
    network = read(tree()).model.network
    assert network is not None
    every = list(offered(Anchored.of(network, 255, bench.data.columns).motor(), bench.data.offered))
    whole = [effect for effect in every if effect.component == WHOLE]
    winding, casing = ([effect for effect in every if effect.component == name] for name in ("winding", "casing"))
    assert min(len(whole), len(winding), len(casing)) == 2

    def fitted(*promises: tuple[float, NetworkEffect]) -> list[NetworkEffect]:
        return [effect for _, effect in to_fit(promises)]

    assert fitted((9.0, whole[0]), (8.0, whole[1]), (1.0, winding[0]), (0.5, casing[0])) == [*whole, winding[0]]
    # At two places, one more only where it promises nearly as much.
    assert fitted((9.0, whole[0]), (8.0, winding[0]), (7.0, casing[0]), (6.9, casing[1])) == [
        whole[0],
        winding[0],
        casing[0],
    ]
    assert fitted((9.0, whole[0]), (8.0, winding[0]), (6.0, casing[0])) == [whole[0], winding[0]]
    assert fitted((9.0, whole[0])) == [whole[0]]
