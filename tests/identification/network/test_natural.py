"""Natural convection in the simulation that is fitted: against an ODE solver, and against the file that is written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gen
from gen.arrays import FloatArray, IntArray
from gen.identification.choice.models import Options, network_of
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.fitting.inputs import held
from gen.identification.network.fitting.natural import USUAL_K, polynomial
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.steady import settled
from gen.identification.network.fitting.structure import Structure, full
from gen.identification.network.identify import identify_network
from gen.identification.network.telling.document import network_text
from gen.identification.network.telling.page import network_report
from gen.identification.settings import Settings
from gen.lowering.network.lower import lower_network
from gen.model.network_solution import NetworkSolution
from gen.runs import Run
from tests.examples import ROOT
from tests.identification.network.held_then_rest import NAMES, numbers_about_the_prior, problem_of

AMBIENT, WIDEST = 22.0, 90.0
SHARE = 0.6


def problem_at(pwm: int, hours: float) -> Problem[Structure]:
    return problem_of(replace(full(NAMES, 0), natural=WIDEST), pwm, hours, AMBIENT)


def numbers_of(problem: Problem[Structure]) -> FloatArray:
    vector = numbers_about_the_prior(problem)
    vector[problem.structure.still] = np.log(SHARE / (1.0 - SHARE))
    return vector


def lost_W(problem: Problem[Structure], vector: FloatArray, pwm: int, rise: FloatArray) -> FloatArray:
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

    def flow(now: int) -> Callable[[float, FloatArray], FloatArray]:
        heat = structure.physical(held(np.array([float(now)]), 255), vector).heat[0]
        return lambda _, rise: np.asarray((heat - lost_W(problem, vector, now, rise)) / capacity)

    driven = inputs.rest < 0.5
    turn = float(ends[driven][-1])
    first = solve_ivp(flow(pwm), (0.0, turn), np.zeros(2), "LSODA", ends[driven], rtol=1e-9, atol=1e-9)
    warm = first.y[:, -1]
    second = solve_ivp(flow(0), (turn, float(ends[-1])), warm, "LSODA", ends[~driven], rtol=1e-9, atol=1e-9)
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


def logged(seed: int, pwm: IntArray) -> Run:
    """What a closed motor's sensors read whose casing natural convection and radiation cool (the example's)."""
    time = 10.0 * np.arange(pwm.size, dtype=np.float64)
    room = 20.0 + np.sin(time / 4000.0 + seed)
    motor = gen.load(ROOT / "examples" / "natural_cooling" / "coeffs.json").coefficients.model
    chance = np.random.default_rng(seed)
    temps = {
        name: values + chance.normal(0.0, 0.05, time.size)
        for name, values in NetworkSolution(motor).simulate_times(time, pwm, room).items()
    }
    return Run(time, pwm, temps, room)


def test_a_motor_in_still_air_is_identified_and_written_as_one() -> None:
    """From holds of ten minutes, and stops; then three quarters of an hour at full speed, and a long rest."""
    rows = np.repeat(np.random.default_rng(5).choice([0, 150, 220, 255], (2, 30)), 60, axis=1).astype(np.int64)
    data = make_network_data([Source(f"r{k}.csv", logged(k, pwm)) for k, pwm in enumerate(rows)], None)
    found = identify_network(data, lambda _: None, 1)
    assert found.found.structure.natural > 0.0
    text, loaded = network_text(found, Settings("closed"))
    assert '"convection"' in text
    assert "of what surfaces lose at rest goes by natural convection" in network_report(found, loaded)
    test = logged(9, np.repeat([255, 0], [270, 1000]).astype(np.int64))
    assert test.ambient is not None
    first = {name: float(values[0]) for name, values in test.temps.items()}
    shown = NetworkSolution(loaded.model).simulate_times(test.time_s, test.pwm, test.ambient, start=first)
    error = np.concatenate([shown[name] - test.temps[name] for name in first])
    assert float(np.sqrt(np.mean(error**2))) < 0.01 * float(np.ptp(test.temps["magnet"]))


def test_what_no_board_can_be_shown_to_follow_is_left_out() -> None:
    """The same motor with a twentieth of its masses: a model is there to be built."""
    rows = np.repeat(np.random.default_rng(5).choice([0, 150, 220, 255], (2, 30)), 60, axis=1).astype(np.int64)
    slow = [logged(k, pwm) for k, pwm in enumerate(rows)]
    quick = [Source(f"r{k}.csv", replace(run, time_s=run.time_s / 20.0)) for k, run in enumerate(slow)]
    found = network_of(quick, Options(Settings("quick"), max_hidden=1), lambda _: None)
    assert '"convection"' not in found.text
    assert [said for said in found.result.data.warnings if "natural convection is left out, as no board" in said]
    assert max(part.proof.bound_K for part in lower_network(found.coefficients, "fixed").components()) < 1e-3


def test_where_nobody_measured_the_room_none_is_sought() -> None:
    rows = np.repeat([120, 0, 200, 0], 90).astype(np.int64)
    run = replace(logged(1, rows), ambient=None)
    found = identify_network(make_network_data([Source("r.csv", run)], None), lambda _: None, 0)
    assert found.found.structure.natural == 0.0
