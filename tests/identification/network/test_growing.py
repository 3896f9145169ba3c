"""Heat that grows with temperature in the simulation that is fitted: against an ODE solver, and as it is written."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gen.arrays import FloatArray, IntArray
from gen.firmware.contexts.network_terms import Terms
from gen.identification.choice.models import Options, network_of
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.fitting.inputs import held
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.steady import settled
from gen.identification.network.fitting.structure import Structure, full
from gen.identification.network.identify import identify_network
from gen.identification.network.prune import tables_of
from gen.identification.network.telling.page import network_report
from gen.identification.settings import Settings
from gen.lowering.network.lower import lower_network
from gen.model.network_solution import NetworkSolution
from gen.runs import Run
from tests.identification.network.held_then_rest import NAMES, numbers_about_the_prior, problem_of

AMBIENT, SINCE = 15.0, 22.0
PER_K = 0.006


def problem_at(pwm: int, hours: float) -> Problem[Structure]:
    return problem_of(replace(full(NAMES, 0), warmth=SINCE), pwm, hours, AMBIENT)


def numbers_of(problem: Problem[Structure]) -> FloatArray:
    vector = numbers_about_the_prior(problem)
    vector[problem.structure.growing] = PER_K
    return vector


def gained_W(problem: Problem[Structure], vector: FloatArray, pwm: int, degC: FloatArray, room: float) -> FloatArray:
    """What each node gains, from heats that do not grow and the formula of `growing` alone."""
    plain = replace(problem.structure, warmth=None)
    found = plain.physical(held(np.array([float(pwm)]), 255), np.delete(vector, problem.structure.growing))
    out = found.heat[0] * (1.0 + PER_K * (degC - SINCE))
    for q, (i, j) in enumerate(plain.paths):
        flow = found.conductance[0, q] * (degC[i] - (degC[j] if j >= 0 else room))
        out[i] -= flow
        if j >= 0:
            out[j] += flow
    return np.asarray(out)


def test_the_simulation_is_the_solution_of_the_equations() -> None:
    problem = problem_at(200, 3.0)
    vector = numbers_of(problem)
    inputs, ends = problem.inputs, np.cumsum(problem.inputs.width)
    capacity = np.exp(vector[problem.structure.capacities])

    def flow(pwm: int) -> Callable[[float, FloatArray], FloatArray]:
        return lambda _, degC: gained_W(problem, vector, pwm, degC, AMBIENT) / capacity

    driven = inputs.rest < 0.5
    turn, start = float(ends[driven][-1]), np.full(2, AMBIENT)
    first = solve_ivp(flow(200), (0.0, turn), start, "LSODA", ends[driven], rtol=1e-10, atol=1e-10)
    then = (turn, float(ends[-1]))
    second = solve_ivp(flow(0), then, first.y[:, -1], "LSODA", ends[~driven], rtol=1e-10, atol=1e-10)
    wanted = np.hstack([first.y, second.y]).T
    assert problem.evaluate(vector).after == pytest.approx(wanted, abs=1e-5)
    plain = vector.copy()
    plain[problem.structure.growing] = 0.0
    assert float(np.abs(problem.evaluate(plain).after - wanted).max()) > 0.3


def test_derivatives_are_those_of_the_simulation() -> None:
    problem = problem_at(200, 1.0)
    vector = numbers_of(problem)
    _, slopes = problem.slopes(vector)
    for place in range(problem.structure.size):
        step = 1e-6 if place == problem.structure.growing[0] else 1e-4
        up, down = vector.copy(), vector.copy()
        up[place], down[place] = up[place] + step, down[place] - step
        # Where a reading is covered, what is left of it falls as the model's reading grows.
        change = (problem.evaluate(down).residual - problem.evaluate(up).residual) / (2.0 * step)
        read = problem.inputs.covered > 0.0
        scale = float(np.abs(change).max())
        assert slopes[..., place][read] == pytest.approx(change[read], rel=2e-3, abs=2e-4 * scale + 1e-5)


def test_it_settles_where_heat_and_loss_are_equal() -> None:
    problem = problem_at(120, 1.0)
    vector = numbers_of(problem)
    levels = held(np.array([40.0, 120.0, 255.0]), 255)
    found = settled(problem.structure, levels, vector)
    for k, pwm in enumerate((40, 120, 255)):
        assert gained_W(problem, vector, pwm, SINCE + found.rise[k], SINCE) == pytest.approx(0.0, abs=1e-8)
    for place in range(problem.structure.size):
        step = 1e-7 if place == problem.structure.growing[0] else 1e-5
        up, down = vector.copy(), vector.copy()
        up[place], down[place] = up[place] + step, down[place] - step
        change = settled(problem.structure, levels, up).rise - settled(problem.structure, levels, down).rise
        assert found.slopes[..., place] == pytest.approx(change / (2.0 * step), rel=1e-3, abs=1e-4)


def logged(seed: int, pwm: IntArray) -> Run:
    """What sensors read of a winding in a casing, both with heat of their own that grows by 0.6 % for each kelvin."""
    time = 10.0 * np.arange(pwm.size, dtype=np.float64)
    chance = np.random.default_rng(seed)
    room = 20.0 + 4.0 * np.sin(time / 5000.0 + 2.0 * seed)
    degC, made = np.full(2, room[0]), np.empty((time.size, 2))
    capacity = np.array([60.0, 500.0])
    for k, count in enumerate(pwm):
        made[k] = degC
        for _ in range(10):
            share = count / 255.0
            heat = np.array([14.0, 5.0]) * share**2 * (1.0 + PER_K * (degC - 20.0))
            inner, out = 0.5 * (degC[0] - degC[1]), (0.25 + 0.15 * share) * (degC[1] - room[k])
            degC = degC + (heat + np.array([-inner, inner - out])) / capacity
    temps = {name: made[:, s] + chance.normal(0.0, 0.1, time.size) for s, name in enumerate(("winding", "casing"))}
    return Run(time, pwm, temps, room)


ROWS = np.repeat(np.random.default_rng(5).choice([0, 120, 180, 255], (3, 12)), 90, axis=1).astype(np.int64)


def test_a_motor_whose_heat_grows_is_identified_written_and_built() -> None:
    found = network_of(
        [Source(f"r{k}.csv", logged(k, pwm)) for k, pwm in enumerate(ROWS)],
        Options(Settings("copper"), max_hidden=0),
        lambda _: None,
    )
    structure = found.result.found.structure
    assert structure.warmth is not None
    heats = found.coefficients.model.network.heats if found.coefficients.model.network else ()
    assert {round(heat.per_K, 3) for heat in heats} == {PER_K}
    report = network_report(found.result, found.coefficients)
    assert re.search(r"Heats grow by 0\.6\d% .* warmer than \d+ degC; heats are those of nodes at that", report)
    program, network = lower_network(found.coefficients, "fixed"), found.coefficients.model.network
    assert max(part.proof.bound_K for part in program.components()) < 1e-3
    assert network is not None
    assert len(Terms(program, network, "copper").tables) <= tables_of(structure)
    test = logged(9, np.repeat([255, 0, 120], [500, 300, 300]).astype(np.int64))
    assert test.ambient is not None
    first = {name: float(values[0]) for name, values in test.temps.items()}
    shown = NetworkSolution(found.coefficients.model).simulate_times(test.time_s, test.pwm, test.ambient, start=first)
    error = np.concatenate([shown[name] - test.temps[name] for name in first])
    assert float(np.sqrt(np.mean(error**2))) < 0.2


def test_a_power_is_what_heats_however_warm_it_is() -> None:
    sources = [Source(f"r{k}.csv", logged(k, pwm)) for k, pwm in enumerate(ROWS)]
    found = identify_network(make_network_data(sources, None, machine="heater"), lambda _: None, 0)
    assert found.found.structure.warmth is None
