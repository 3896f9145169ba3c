"""Natural convection in the simulation that is fitted: against an ODE solver, and against the file that is written."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gen.identification.network.bins import binned
from gen.identification.network.inputs import held, inputs_of
from gen.identification.network.natural import USUAL_K, polynomial
from gen.identification.network.priors import prior_of
from gen.identification.network.problem import Problem
from gen.identification.network.scale import Scale
from gen.identification.network.steady import settled
from gen.identification.network.structure import Structure, full
from gen.runs import Run

NAMES = ("a", "b")
AMBIENT, WIDEST = 22.0, 90.0
SHARE = 0.6


def problem_at(pwm: int, hours: float) -> Problem[Structure]:
    """PWM held from cold, then rest."""
    time = 10.0 * np.arange(round(360.0 * hours), dtype=np.float64)
    run = Run(time, np.where(time < 0.5 * time[-1], pwm, 0), dict.fromkeys(NAMES, np.full(time.size, AMBIENT)))
    inputs = inputs_of([binned("r", run, NAMES, AMBIENT, 255)])
    structure = replace(full(NAMES, 0), natural=WIDEST)
    return Problem(structure, inputs, prior_of(structure, inputs, Scale(np.full(2, 1500.0), np.full(2, 40.0))))


def numbers_of(problem: Problem[Structure]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    vector = problem.prior.mean + np.random.default_rng(4).normal(0.0, 0.2, problem.size)
    vector[problem.structure.still] = np.log(SHARE / (1.0 - SHARE))
    vector[problem.structure.size :] = 0.0
    return vector


def lost_W(problem: Problem[Structure], vector: np.ndarray, pwm: int, rise: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
    """What leaves each node, from the formula of `natural` and conductances alone."""
    structure = problem.structure
    found = structure.physical(held(np.array([float(pwm), 0.0]), 255), vector)
    own, rest = found.conductance
    out = np.zeros(2)
    for q, (i, j) in enumerate(structure.paths):
        if j >= 0:
            flow = own[q] * (rise[i] - rise[j])
            out += flow * np.array([1.0, -1.0]) * (1.0 if i == 0 else -1.0)
        else:
            share = SHARE * own[q] * min(rest[q] / own[q], 1.0) ** 3
            factor = float(np.polyval(polynomial(WIDEST), abs(rise[i])))
            out[i] += (own[q] - share) * rise[i] + share * rise[i] * factor
    return out


@pytest.mark.parametrize("pwm", [120, 255])
def test_the_simulation_is_the_solution_of_the_equations(pwm: int) -> None:
    problem = problem_at(pwm, 3.0)
    vector = numbers_of(problem)
    structure, inputs = problem.structure, problem.inputs
    ends = np.cumsum(inputs.width)
    half = float(ends[-1]) / 2.0
    capacity = np.exp(vector[structure.capacities])

    def flow(now: int) -> object:
        heat = structure.physical(held(np.array([float(now)]), 255), vector).heat[0]
        return lambda _, rise: (heat - lost_W(problem, vector, now, rise)) / capacity

    driven = inputs.rest < 0.5
    turn = float(ends[driven][-1])
    accuracy = {"rtol": 1e-9, "atol": 1e-9, "method": "LSODA"}
    first = solve_ivp(flow(pwm), (0.0, turn), np.zeros(2), t_eval=ends[driven], **accuracy)
    second = solve_ivp(flow(0), (turn, float(ends[-1])), first.y[:, -1], t_eval=ends[~driven], **accuracy)
    wanted = AMBIENT + np.hstack([first.y, second.y]).T
    found = problem.evaluate(vector).after
    assert float(np.ptp(wanted)) > 10.0
    assert half == pytest.approx(turn, abs=60.0)
    assert found == pytest.approx(wanted, abs=0.02)
    without = replace(problem, structure=replace(structure, natural=0.0))
    assert float(np.abs(without.evaluate(np.delete(vector, structure.still)).after - wanted).max()) > 0.5


def test_it_settles_where_heat_and_loss_are_equal() -> None:
    problem = problem_at(120, 1.0)
    vector = numbers_of(problem)
    levels = held(np.array([40.0, 120.0, 255.0]), 255)
    found = settled(problem.structure, levels, vector)
    for k, pwm in enumerate((40, 120, 255)):
        heat = problem.structure.physical(levels, vector).heat[k]
        assert lost_W(problem, vector, pwm, found.rise[k]) == pytest.approx(heat, rel=1e-6)
    step = 1e-5
    for place in range(problem.structure.size):
        up, down = vector.copy(), vector.copy()
        up[place], down[place] = up[place] + step, down[place] - step
        change = settled(problem.structure, levels, up).rise - settled(problem.structure, levels, down).rise
        assert found.slopes[..., place] == pytest.approx(change / (2.0 * step), rel=1e-4, abs=1e-5)


def test_the_polynomial_is_about_the_fourth_root() -> None:
    difference = np.linspace(0.05 * WIDEST, WIDEST, 100)
    assert np.polyval(polynomial(WIDEST), difference) == pytest.approx((difference / USUAL_K) ** 0.25, rel=0.04)
