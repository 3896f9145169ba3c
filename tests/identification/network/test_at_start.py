"""Hidden nodes that start at a multiple of the rise at which they would rest: as the board and the file have it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.identification.network.fitting.bins import binned
from gen.identification.network.fitting.inputs import inputs_of
from gen.identification.network.fitting.priors import prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.structure import Structure, full
from gen.runs import Run

NAMES = ("a", "b")
SENSORS, NODES = 2, 4
AMBIENT = 18.0


def problem_from(*starts: tuple[float, float], ambient: float | None = AMBIENT) -> Problem[Structure]:
    """An hour of each run, some of it at rest; runs begin where they are told to."""
    time = 10.0 * np.arange(360, dtype=np.float64)
    pwm = np.where(time < 2000.0, 150, 0)
    runs = []
    for number, begin in enumerate(starts):
        temps = {name: np.full(time.size, at) for name, at in zip(NAMES, begin, strict=True)}
        around = AMBIENT if ambient is None else ambient
        runs.append(binned(str(number), Run(time, pwm, temps), NAMES, around, 255))
    if ambient is None:
        runs = [replace(run, ambient_known=False) for run in runs]
    inputs = inputs_of(runs)
    structure = replace(full(NAMES, NODES - SENSORS), apart=0.05)
    prior = prior_of(structure, inputs, Scale(np.full(2, 1500.0), np.full(2, 40.0)))
    return Problem(structure, inputs, prior)


def numbers_of(problem: Problem[Structure], seed: int = 3) -> FloatArray:
    return problem.prior.mean + np.random.default_rng(seed).normal(0.0, 0.3, problem.size)


def flows_W(problem: Problem[Structure], vector: FloatArray, rise: FloatArray) -> FloatArray:
    """What flows out of each hidden node at rest, path by path, shape (h,)."""
    structure = problem.structure
    out = np.zeros(NODES)
    for law, at, (i, j) in zip(structure.laws, structure.conductances, structure.paths, strict=True):
        conductance = float(np.exp(law.at_rest(vector[at][None, :])[0][0]))
        out[i] += conductance * (rise[i] - (rise[j] if j >= 0 else 0.0))
        if j >= 0:
            out[j] -= conductance * (rise[i] - rise[j])
    return out[SENSORS:]


def test_without_a_factor_a_hidden_node_starts_where_nothing_flows_into_it() -> None:
    problem = problem_from((61.0, 40.0), (35.0, 52.0))
    vector = numbers_of(problem)
    vector[problem.structure.factors] = 0.0
    sensed = np.array([[61.0, 40.0], [35.0, 52.0]])
    begun = problem.structure.begun(vector, sensed, np.full(2, AMBIENT))
    assert begun is not None
    for own, hidden in zip(sensed, begun.temperature, strict=True):
        rise = np.concatenate([own, hidden]) - AMBIENT
        assert flows_W(problem, vector, rise) == pytest.approx(np.zeros(2), abs=1e-9)


def test_a_factor_multiplies_the_rise_over_the_ambient() -> None:
    problem = problem_from((61.0, 40.0))
    plain, more = numbers_of(problem), numbers_of(problem)
    factors = problem.structure.factors
    plain[factors], more[factors] = 0.0, np.log([0.5, 3.0])
    sensed, ambient = np.array([[61.0, 40.0]]), np.array([AMBIENT])
    at_rest, warmer = (problem.structure.begun(v, sensed, ambient) for v in (plain, more))
    assert at_rest is not None
    assert warmer is not None
    rise = at_rest.temperature - AMBIENT
    assert warmer.temperature - AMBIENT == pytest.approx(rise * np.array([0.5, 3.0]), rel=1e-12)


@pytest.mark.parametrize("ambient", [AMBIENT, None])
def test_derivatives_are_those_of_the_simulation(ambient: float | None) -> None:
    problem = problem_from((61.0, 40.0), (35.0, 52.0), ambient=ambient)
    vector = numbers_of(problem)
    vector[problem.structure.size :] *= 0.1
    _, slopes = problem.slopes(vector)
    runs, shared = problem.inputs.run, problem.structure.size
    for place in range(problem.size):
        step = np.zeros(problem.size)
        step[place] = 1e-4
        up, down = (problem.evaluate(vector + sign * step).residual for sign in (1.0, -1.0))
        wanted = -(up - down) / 2e-4
        if place < shared:
            found = slopes[..., place]
        else:
            run, own = divmod(place - shared, problem.own)
            found = np.where((runs == run)[:, None], slopes[..., shared + own], 0.0)
        assert found == pytest.approx(wanted, abs=2e-4 * max(1.0, float(np.abs(wanted).max()))), place


def test_runs_that_begin_cold_say_nothing_of_it() -> None:
    problem = problem_from((AMBIENT, AMBIENT))
    vector = numbers_of(problem)
    vector[problem.structure.size :] = 0.0
    _, slopes = problem.slopes(vector)
    assert np.abs(slopes[..., problem.structure.factors]).max() < 1e-6
    assert problem.inputs.warm == pytest.approx([0.0])
