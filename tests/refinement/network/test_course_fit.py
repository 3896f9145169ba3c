"""The heat over time that would explain what is left: where it is, how much, and whether it goes with speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.over_time.course_fit import fitted_courses
from gen.refinement.network.over_time.courses import Course, RunCourse
from gen.refinement.network.over_time.missing_heat import likeliest
from gen.refinement.network.over_time.told_course import told
from gen.refinement.network.over_time.uneven import Uneven, uneven
from gen.runs import Run
from tests.refinement.network.motor import HOURS, ROW_S, Tree, finned, read, run, tree

LOAD_W = 4.0
NAMES = ("one.csv", "two.csv", "three.csv")


def time_s() -> FloatArray:
    return ROW_S * np.arange(int(HOURS * 3600.0 / ROW_S), dtype=np.float64)


def loaded(where: str) -> Tree:
    """The motor with heat of a load, in W, that a column tells; no run file has that column afterwards."""
    motor = tree()
    motor["network"]["channels"] = [{"column": "load_W", "range": [0, 10], "neutral": 0}]
    motor["network"]["heats"].append(
        {"node": where, "power_W": {"poly": [1.0], "at_rest": 1.0}, "factors": [{"channel": "load_W", "poly": [1, 0]}]}
    )
    return motor


def courses(motor: Tree, loads: list[FloatArray] | None = None) -> list[Course]:
    """What is missing in runs of a motor, with the small motor's file."""
    runs: list[tuple[str, Run]] = []
    for number, name in enumerate(NAMES):
        channels = None if loads is None else {"load_W": loads[number]}
        runs.append((name, replace(run(read(motor), 20 + number, channels), extras={})))
    bench = Bench(make_data(read(tree()), runs))
    network = read(tree()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    return likeliest(fitted_courses(bench, base, base.shape))


def judged(found: list[Course]) -> Uneven:
    made = uneven(found)
    assert made is not None
    return made


def on_and_off(period_s: float) -> list[FloatArray]:
    return [
        LOAD_W * np.asarray((time_s() + 700.0 * number) % period_s < 0.5 * period_s, dtype=np.float64)
        for number in range(len(NAMES))
    ]


@pytest.mark.parametrize("where", ["winding", "casing"])
def test_a_load_that_nobody_logged_is_seen_where_and_when_it_was(where: str) -> None:
    loads = on_and_off(3600.0)
    found = courses(loaded(where), loads)
    assert found[0].component == where
    assert found[0].left < 0.1
    for one, load in zip(found[0].runs, loads, strict=True):
        true = np.array([load[np.abs(time_s() - middle) < 150.0].mean() for middle in one.time_s])
        held = (true == 0.0) | (true == LOAD_W)  # blocks in which it does not change
        assert np.corrcoef(one.value, true)[0, 1] > 0.9
        away = (one.value - true)[held]
        assert np.abs(np.median(away)) < 0.05 * LOAD_W  # all heats together are known to some percent
        assert np.mean(np.abs(away) < 3.0 * one.deviation[held] + 0.2) > 0.9
    said = judged(found)
    assert said.pattern == "comes and goes"
    assert said.high - said.low == pytest.approx(LOAD_W, rel=0.1)
    assert where in told(said, found[0], NAMES)


def test_heat_of_one_run_alone_is_told_by_run() -> None:
    still = np.zeros_like(time_s())
    found = courses(loaded("casing"), [still, still + LOAD_W, still])
    said = judged(found)
    assert said.pattern == "by run"
    assert said.levels[1] - said.levels[0] == pytest.approx(LOAD_W, rel=0.1)
    assert "two.csv +" in told(said, found[0], NAMES)


def test_heat_that_begins_and_stays_is_told_since_when() -> None:
    since = 1.5
    still = np.zeros_like(time_s())
    half = np.where(time_s() > 3600.0 * since, LOAD_W, 0.0)
    found = courses(loaded("winding"), [still, half, still + LOAD_W])
    said = judged(found)
    assert (found[0].component, said.pattern) == ("winding", "since")
    assert said.since is not None
    run_number, earliest_h, latest_h = said.since  # in between it stood still
    assert run_number == 1
    assert earliest_h < since < latest_h
    assert "into two.csv" in told(said, found[0], NAMES)


def worn() -> Tree:
    motor = tree()
    motor["network"]["heats"][0]["power_W"]["poly"] = [0.00021, 0.014, 0.0]
    return motor


def slack() -> Tree:
    motor = tree()
    motor["network"]["paths"][0]["conductance_W_per_K"] = {"poly": [0.2]}
    return motor


@pytest.mark.parametrize("motor", [worn(), finned(), slack()], ids=["worn", "a mass more", "a loose joint"])
def test_what_a_file_can_hold_goes_with_speed(motor: Tree) -> None:
    found = courses(motor)
    said = uneven(found)
    assert said is None or said.pattern == "even"
    assert said is None or told(said, found[0], NAMES) == ""


def test_of_a_healthy_motor_no_heat_is_missing() -> None:
    assert max(one.evidence for one in courses(tree())) < 20.0


def stepped(levels: tuple[float, ...], deviation: float, always_W: float = 1.8) -> Uneven:
    """What some heat at all times and so much more in each run is like, each block known to a deviation."""
    made, ones = [], np.ones(48)
    speed: FloatArray = np.asarray(np.linspace(0.2, 0.9, 48), dtype=np.float64)
    for number, level in enumerate(levels):
        values = always_W + level + np.random.default_rng(number).normal(0.0, 0.3 * deviation, 48)
        made.append(RunCourse(number, 300.0 * np.cumsum(ones), values, deviation * ones, ones, speed))
    said = uneven([Course("heat", "casing", 100.0, 100.0, 0.05, tuple(made), 1.0)])
    assert said is not None
    return said


def test_heat_that_goes_one_way_in_the_order_of_many_runs_is_told_though_single_blocks_hardly_show_it() -> None:
    ordered = (-0.9, -0.6, -0.2, 0.2, 0.6, 0.9)
    mixed = (0.2, -0.6, 0.9, -0.9, 0.6, -0.2)
    assert stepped(ordered, 0.4).pattern == "grows"
    assert stepped(ordered[::-1], 0.4).pattern == "grows"
    assert stepped(mixed, 0.4).pattern == "even"
    assert stepped(mixed, 0.2).pattern == "by run"
    assert stepped((-0.8, 0.0, 0.8), 0.4).pattern == "even"  # three runs may be in any order by chance
    assert stepped((-0.8, 0.0, 0.8), 0.2).pattern == "grows"


def test_what_grows_over_several_runs_is_no_change_at_one_time() -> None:
    """Beside what was found for all runs little is left that they share."""
    by_and_by, at_once = (-0.9, -0.6, -0.2, 0.2, 0.6, 0.9), (-0.9, -0.8, -0.8, 0.8, 0.8, 0.9)
    assert stepped(by_and_by, 0.2, 0.0).pattern == "grows"
    assert stepped(by_and_by, 0.4, 0.0).pattern == "grows"
    assert stepped(at_once, 0.2, 0.0).pattern == "since"
    assert stepped((-0.8, 0.8), 0.2, 0.0).pattern == "since"  # two runs: between them, for all that is known


def test_wear_that_is_seen_beside_where_it_arises_grows_all_the_same() -> None:
    """What comes and goes within the runs is more than what they differ by; but that stands in their order."""

    def shaken(levels: FloatArray) -> Uneven:
        def heat_W(speed: FloatArray, chance: np.random.Generator) -> FloatArray:
            return np.asarray(1.8 + next(level) + 0.9 * chance.standard_normal(speed.size))

        level = iter(levels)
        return held(heat_W, len(levels))

    ordered: FloatArray = np.linspace(-0.6, 0.6, 6)
    assert shaken(ordered).pattern == "grows"
    assert shaken(ordered[::-1]).pattern == "grows"
    assert shaken(ordered[[3, 0, 5, 1, 4, 2]]).pattern == "comes and goes"
    assert shaken(ordered[:4]).pattern == "comes and goes"  # four runs are in one of two orders one time in twelve
    assert shaken(0.01 * ordered).pattern == "comes and goes"


def held(heat_W: Callable[[FloatArray, np.random.Generator], FloatArray], runs: int = 6) -> Uneven:
    """What runs at ten speeds each, of half an hour, are like; heat by speed, each block known to 0.1 W."""
    made, ones = [], np.ones(60)
    for number in range(runs):
        chance = np.random.default_rng([31, number])
        levels = chance.uniform(0.2, 1.0, 10)
        values = np.repeat(heat_W(levels, chance), 6) + chance.normal(0.0, 0.03, 60)
        made.append(RunCourse(number, 300.0 * np.cumsum(ones), values, 0.1 * ones, ones, np.repeat(levels, 6)))
    said = uneven([Course("heat", "bearing", 100.0, 100.0, 0.05, tuple(made), 1.0)])
    assert said is not None
    return said


def resonance(speed: FloatArray, _: object) -> FloatArray:
    return np.asarray(0.3 + 2.0 * np.exp(-0.5 * ((speed - 0.65) / 0.06) ** 2))


def test_a_resonance_goes_with_speed_though_it_is_narrow() -> None:
    assert held(resonance).scatter > 0.45  # about a smooth mean over speed
    assert held(resonance).pattern == "even"
    assert held(lambda speed, chance: chance.permutation(resonance(speed, None))).pattern == "comes and goes"


def test_one_run_alone_does_not_tell_a_resonance_from_what_comes_and_goes() -> None:
    def beside_changes(value: float) -> Uneven:
        """2 W, and another value in the blocks at each change of speed, which a course may tell late."""
        speed = np.repeat([0.3, 0.5, 0.7, 0.9, 0.4, 0.6, 0.8, 0.35], 6)
        values = np.where(np.arange(48) % 6 % 5 == 0, value, 2.0)
        one = RunCourse(0, 300.0 * np.arange(48.0), values, np.full(48, 0.1), np.ones(48), speed)
        said = uneven([Course("heat", "bearing", 100.0, 100.0, 0.05, (one,), 1.0)])
        assert said is not None
        return said

    assert beside_changes(5.0).scatter > 0.45  # about a smooth mean over speed; less within what is held
    assert beside_changes(5.0).pattern == "comes and goes"
    assert beside_changes(2.1).pattern == "even"
