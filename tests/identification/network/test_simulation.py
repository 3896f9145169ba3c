"""The simulation that is fitted: against the model's own exact solution, and its derivatives against differences."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.fitting.bins import binned
from gen.identification.network.fitting.divided import divided_differences
from gen.identification.network.fitting.inputs import inputs_of
from gen.identification.network.fitting.priors import prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.scale import scale_of
from gen.identification.network.fitting.structure import Structure, full
from gen.identification.network.fitting.weights import weights
from gen.identification.network.identify import curves, identify_network
from gen.identification.network.telling.document import network_text
from gen.identification.settings import Settings
from gen.model.network_solution import NetworkSolution
from gen.runs import Run
from tests.identification.network.plant import ROOM, TWO, holds

NAMES = ("a", "b")


@pytest.fixture(scope="module", params=[0.0, 60.0], ids=["forced", "natural"])
def problem(request: pytest.FixtureRequest) -> Problem[Structure]:
    """Runs of different lengths, one of them without a measured ambient, one with PWM that changes all the time."""
    rng = np.random.default_rng(1)
    runs = []
    for number, length in enumerate((900, 600, 750)):
        time = 2.0 * np.arange(length, dtype=np.float64)
        pwm = np.repeat(rng.choice([0, 60, 200, 255], length // 150), 150).astype(np.int64)
        if number == 2:
            pwm[300:] = rng.integers(0, 2, length - 300) * 180
        temps = {name: 25.0 + 5.0 * rng.random() + rng.normal(0.0, 0.2, length) for name in NAMES}
        ambient = 25.0 if number == 1 else 25.0 + np.sin(time / 300.0)
        runs.append(binned(f"r{number}", Run(time, pwm, temps), NAMES, ambient, 255))
    inputs = inputs_of(runs)
    inputs = replace(inputs, weight=weights(inputs, np.full(2, 10.0)))
    structure = replace(full(NAMES, 1), natural=request.param)
    return Problem(structure, inputs, prior_of(structure, inputs, scale_of(inputs)))


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (-2.0, -2.0),
        (-2.0, -2.0 + 1e-7),
        (-1e-3, -0.9e-3),
        (-5e-4, -5e-4),
        (-5e-4, -0.15),
        (-0.3, -0.499),
        (-0.3, -0.501),
        (-3.0, -2.9),
        (-3.0, -1.01),
        (-3.0, -0.99),
        (-40.0, -0.01),
    ],
)
def test_divided_differences_are_right_for_rates_near_each_other_near_none_and_far_apart(
    first: float, second: float
) -> None:
    """Both as integrals of derivatives from one rate to the other (Hermite and Genocchi), by quadrature."""
    width = 7.0
    a, b = first / width, second / width

    def between(time: float) -> float:
        return float(quad(lambda s: np.exp((a + s * (b - a)) * time), 0.0, 1.0, epsabs=0.0, epsrel=1e-13)[0])

    exact = width * between(width), quad(lambda t: t * between(t), 0.0, width, epsabs=0.0, epsrel=1e-12)[0]
    rates, shares = np.array([[a, b]]), np.array([[first, second]])
    made: Any = (np.empty((1, 2, 2)), np.empty((1, 2, 2)))  # fits take single precision
    divided_differences(rates, np.array([width]), np.exp(shares), np.expm1(shares) / rates, *made)
    for found, right in zip(made, exact, strict=True):
        assert found[0, 0, 1] == found[0, 1, 0] == pytest.approx(right, rel=1e-8)


def moved(problem: Problem[Structure]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return problem.prior.mean + np.random.default_rng(2).normal(0.0, 0.3, problem.size)


def columns(problem: Problem[Structure]) -> Iterator[tuple[int, int, int]]:
    """Each run's parameters: run, place among the run's own columns, place in the vector."""
    for run in range(problem.runs):
        for own, place in enumerate(problem.columns(run).tolist()):
            yield run, own, place


def test_derivatives_of_the_readings_agree_with_differences(problem: Problem[Structure]) -> None:
    vector, step = moved(problem), 1e-5
    _, slopes = problem.slopes(vector)
    differences = {}
    for place in range(problem.size):
        up, down = vector.copy(), vector.copy()
        up[place] += step
        down[place] -= step
        change = problem.evaluate(down).residual - problem.evaluate(up).residual
        differences[place] = change / (2.0 * step)
    # Not of nothing: an offset alone moves its reading by 1 K for each kelvin.
    assert max(float(np.abs(d).max()) for d in differences.values()) > 0.9
    for run, own, place in columns(problem):
        row = problem.inputs.rows[run]
        read = problem.inputs.covered[row] > 0.0
        wanted = differences[place][row][read]
        found = slopes[row][..., own][read]
        assert found == pytest.approx(wanted, rel=2e-3, abs=2e-4 + 2e-4 * float(np.abs(wanted).max())), place


def test_normal_equations_give_the_cost_s_own_slope(problem: Problem[Structure]) -> None:
    """Half of minus the cost's gradient, priors and hidden nodes' plausible warmth included."""
    vector, step = moved(problem), 1e-5
    _, normal = problem.linearised(vector)
    _, right = problem.assembled(normal, vector)

    def cost(at: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> float:
        return problem.evaluate(at).cost + problem.penalty(at)

    scale = float(np.abs(right).max())
    for place in range(problem.size):
        up, down = vector.copy(), vector.copy()
        up[place] += step
        down[place] -= step
        assert right[place] == pytest.approx(-0.5 * (cost(up) - cost(down)) / (2.0 * step), abs=1e-3 * scale), place


def test_what_is_written_is_what_was_fitted() -> None:
    """The coefficient file's own exact solution, from the same start, gives the fitted curves.

    Tables, rounding and the least capacity stand between them; so does the start, which is fitted for each run.
    """
    rng = np.random.default_rng(3)
    profiles = (holds((120, 60), (0, 30), (200, 60)), holds((255, 70), (80, 50)))
    runs = [TWO.run(pwm, rng, noise=0.02) for pwm in profiles]
    data = make_network_data([Source(f"r{k}.csv", run) for k, run in enumerate(runs)], None)
    result = identify_network(data, lambda _: None, 0)
    _, loaded = network_text(result, Settings("plant"))
    for number, run in enumerate(runs):
        room = np.full(run.time_s.size, ROOM)
        start = dict.fromkeys(TWO.sensed, ROOM)
        shown = NetworkSolution(loaded.model).simulate_times(run.time_s, run.pwm, room, None, start)
        _, fitted = curves(result)[f"r{number}"]
        edges = data.fine[number].edges
        owner = np.clip(np.searchsorted(edges, run.time_s, side="right") - 1, 0, edges.size - 2)
        late = edges[:-1] > 600.0
        for name in TWO.sensed:
            means = np.bincount(owner, shown[name]) / np.bincount(owner)
            assert means[late] == pytest.approx(fitted[f"{name}_model_degC"][late], abs=0.06)
