"""A short run of the small motor that two effects explain, fitted with both."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from gen.coefficients import Coefficients
from gen.planning.expected import Expected
from gen.planning.hypotheses import Hypothesis, Remaining
from gen.planning.limits import Limits, Wishes, limits_of
from gen.planning.search import Grid, Search, Sought, grid_of
from gen.planning.stage import Stage
from gen.refinement.network.effects import NetworkEffect, candidates
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data, make_data
from gen.refinement.network.fitting.fit import Bench
from gen.runs import Run
from tests.refinement.network.motor import ROW_S, Tree, read, run, tree

AMBIENT, DENSITY, NOISE_K = 24.0, 4.0, 0.1
SECONDS = 7200.0
AT_REST = 1.6
"""By how much more the motor cools at rest than its file says."""


def changed() -> Tree:
    """The motor that is measured."""
    made = tree()
    made["network"]["paths"][1]["conductance_W_per_K"]["at_rest"] *= AT_REST
    return made


@cache
def short_run() -> Run:
    """Three quarters of an hour, the last minutes of it at rest."""
    whole = run(read(changed()), 5, noise_K=0.02)
    rows = round(2700.0 / ROW_S)
    pwm = np.where(np.arange(rows) < rows * 6 // 7, 200, 0).astype(np.int64)
    room = np.full(rows, AMBIENT)
    from gen.model.network_solution import NetworkSolution

    temps = NetworkSolution(read(changed()).model).simulate_times(whole.time_s[:rows], pwm, room)
    chance = np.random.default_rng(7)
    noisy = {name: values + chance.normal(0.0, 0.05, rows) for name, values in temps.items()}
    return replace(whole, time_s=whole.time_s[:rows], pwm=pwm, temps=noisy, ambient=room)


def effect(data: Data, shape: Anchored, name: str) -> NetworkEffect:
    """The first candidate of a name at the casing, or at the whole motor."""
    every = candidates(shape.motor(), data.offered)
    return next(one for one in every if one.name == name and one.component in ("casing", "motor"))


@cache
def question(names: tuple[str, ...] = ("standstill_cooling", "none")) -> tuple[Coefficients, Data, Remaining]:
    """What the short run leaves open, were it between these effects."""
    coefficients = read(tree())
    data = make_data(coefficients, [("short", short_run())])
    network = coefficients.model.network
    assert network is not None
    shape = Anchored.of(network, 255, data.columns)
    bench = Bench(data)
    density = np.full(2, DENSITY)
    base = bench.first(shape)
    bench.weigh(density)
    made = []
    for name in names:
        own = None if name == "none" else effect(data, shape, name)
        made.append(Hypothesis(own, bench.fit(shape.with_effects(*([own] if own else [])), base)))
    return coefficients, data, Remaining(tuple(made), density, NOISE_K, ())


def searched(
    wishes: Wishes, names: tuple[str, ...] = ("standstill_cooling", "none")
) -> tuple[Expected, Limits, Grid, Sought]:
    """A whole search."""
    coefficients, data, left = question(names)
    limits = limits_of(coefficients, wishes, data, left)
    grid = grid_of(np.array([2500.0, 400.0]), 3600.0 * wishes.hours)
    expected = Expected(left, Stage(data, 255, AMBIENT, grid.bin_s, np.full(2, NOISE_K)), limits.levels)
    return expected, limits, grid, Search(expected, limits, grid, wishes.seed).run()
