"""Cooling that comes and goes: told as a conductance, where and when a fan that nobody logged truly blew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import make_data
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.over_time.course_fit import fitted_courses
from gen.refinement.network.over_time.courses import Course, Quantity, RunCourse
from gen.refinement.network.over_time.missing_heat import likeliest
from gen.refinement.network.over_time.told_course import told
from gen.refinement.network.over_time.uneven import Pattern, Uneven, uneven
from gen.runs import Run
from tests.refinement.network.motor import HOURS, ROW_S, Tree, read, run, tree

BLOWS_W_PER_K, STILL_W_PER_K = 0.35, 0.4
NAMES = ("one.csv", "two.csv", "three.csv")
TIME_S: FloatArray = ROW_S * np.arange(int(HOURS * 3600.0 / ROW_S), dtype=np.float64)


def still() -> Tree:
    """The motor without a fan of its own on its shaft."""
    motor = tree()
    motor["network"]["paths"][1]["conductance_W_per_K"] = {"poly": [STILL_W_PER_K]}
    return motor


def blown() -> Tree:
    """The same with moving air at its casing, which a column tells."""
    motor = still()
    motor["network"]["channels"] = [{"column": "air", "range": [0, 1], "neutral": 0}]
    gain = BLOWS_W_PER_K / STILL_W_PER_K
    motor["network"]["paths"][1]["factors"] = [{"channel": "air", "poly": [gain, 1.0]}]
    return motor


def found(air: list[FloatArray]) -> list[Course]:
    """What is missing in runs of the motor in moving air, with the small motor's file and no column of the air."""
    runs: list[tuple[str, Run]] = [
        (name, replace(run(read(blown()), 60 + number, {"air": air[number]}), extras={}))
        for number, name in enumerate(NAMES)
    ]
    bench = Bench(make_data(read(still()), runs))
    network = read(still()).model.network
    assert network is not None
    base = bench.first(Anchored.of(network, 255, bench.data.columns))
    return fitted_courses(bench, base, base.shape)


def test_a_fan_that_nobody_logged_is_cooling_where_and_when_it_blew() -> None:
    air = [np.asarray((TIME_S + 900.0 * k) % 4000.0 < 1800.0, dtype=np.float64) for k in range(len(NAMES))]
    made = found(air)
    assert (made[0].quantity, made[0].component) == ("conductance", "casing")
    assert made[0].left < 0.1
    assert made[0].usual == pytest.approx(STILL_W_PER_K, rel=0.05)
    heat = max(one.evidence for one in made if one.quantity == "heat")
    assert made[0].evidence > heat + 20.0
    for one, truly in zip(made[0].runs, air, strict=True):
        true = BLOWS_W_PER_K * np.array([truly[np.abs(TIME_S - middle) < 150.0].mean() for middle in one.time_s])
        held = (true == 0.0) | (true == BLOWS_W_PER_K)  # blocks in which it does not change
        away = (one.value - true)[held]
        assert np.abs(np.median(away)) < 0.05 * BLOWS_W_PER_K
        assert np.mean(np.abs(away) < 3.0 * one.deviation[held] + 0.02) > 0.9
    said = uneven(made)
    assert said is not None
    assert said.pattern == "comes and goes"
    assert said.high - said.low == pytest.approx(BLOWS_W_PER_K, rel=0.15)
    assert "cooling comes and goes" in told(said, made[0], NAMES)


def course(quantity: Quantity, evidence: float, values: FloatArray) -> Course:
    """A course of one run in which the motor turns."""
    ones = np.ones_like(values)
    one = RunCourse(0, 300.0 * np.arange(values.size, dtype=np.float64), values, 0.01 * ones, ones, 0.5 * ones)
    return Course(quantity, "casing", evidence, evidence, 0.01, (one,), 1.0)


@pytest.mark.parametrize(
    ("evidence", "sign", "quantity"),
    [(1030.0, 1.0, "conductance"), (1010.0, 1.0, "heat"), (1500.0, -1.0, "heat")],
)
def test_it_is_cooling_where_that_is_plainly_likelier_and_added(evidence: float, sign: float, quantity: str) -> None:
    blown = np.tile([0.0, 0.0, 0.3, 0.3], 12)
    every = [course("heat", 1000.0, -3.0 * sign * blown), course("conductance", evidence, sign * blown)]
    assert likeliest(every)[0].quantity == quantity


@pytest.mark.parametrize(
    ("pattern", "since", "says"),
    [
        ("since", (1, 0.9, 1.0), "since 0.9 to 1.0 h into two.csv it is cooled otherwise"),
        ("by run", None, "another one in each run (one.csv -0.1 W/K, two.csv +0.1 W/K, three.csv +0 W/K"),
        ("grows", None, "goes one way from run to run"),
        ("comes and goes", None, "cooling comes and goes, from -0.1 to +0.2 W/K"),
        ("even", None, ""),
    ],
)
def test_each_pattern_of_cooling_is_told_in_its_unit(
    pattern: Pattern, since: tuple[int, float, float] | None, says: str
) -> None:
    found = Uneven(pattern, 1.0, -0.1, 0.2, 0.01, (-0.1, 0.1, 0.0), since)
    said = told(found, course("conductance", 1.0, np.ones(20)), NAMES)
    assert says in said
    assert bool(said) == (pattern != "even")
    assert " W " not in said
