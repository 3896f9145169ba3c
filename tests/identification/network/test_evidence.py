"""Whether curves over speed bend: as the runs ask for it, on motors whose curves are known."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.special import logsumexp

from gen.arrays import FloatArray
from gen.identification.network.evidence import CLEAR, STIFF, in_favour
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.scale import scale_of
from gen.identification.network.identify import NetworkFound
from gen.identification.network.search import Found, bent
from gen.identification.network.telling.uncertainty import spread_of
from gen.runs import Run
from tests.identification.network.plant import TWO, Plant, holds
from tests.identification.network.test_identify import FLOOR, found_of, mixed, off

SPEEDS = (40, 70, 100, 120, 130, 140, 160, 190, 220, 250)


@dataclass(frozen=True, eq=False)
class Resonant(Plant):
    """Its heats are 2.5 times what they were about half speed: no sum of powers of the speed is that."""

    @cache  # noqa: B019
    def step(self, level: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        moved, room, heat = Plant.step(self, level)
        return moved, room, heat * (1.0 + 1.5 * np.exp(-(((level / 255.0 - 0.5) / 0.15) ** 2)))


RESONANT = Resonant(TWO.capacity, TWO.links, TWO.surfaces, TWO.heats, TWO.sensed)


def many_speeds(plant: Plant) -> list[Run]:
    rng = np.random.default_rng(3)
    made = []
    for first in (0, 3, 6):
        order = [SPEEDS[(first + 3 * k) % len(SPEEDS)] for k in range(len(SPEEDS))]
        made.append(plant.run(holds(*((pwm, 25) for pwm in order), (0, 30)), rng))
    return made


@pytest.fixture(scope="module")
def smooth() -> NetworkFound:
    return found_of(mixed(np.random.default_rng(1), TWO), hidden=0)[0]


def test_curves_that_are_sums_of_powers_stay_so(smooth: NetworkFound) -> None:
    assert smooth.found.structure.bend == STIFF


def test_a_curve_that_bends_is_let_bend() -> None:
    result, loaded = found_of(many_speeds(RESONANT), hidden=0)
    assert result.found.structure.bend == BEND
    assert off(loaded, RESONANT, holds((130, 60), (200, 40), (100, 40))) < 2.0 * FLOOR


@pytest.fixture(scope="module")
def bending(smooth: NetworkFound) -> Found:
    (found,) = bent([smooth.found], BEND, scale_of(smooth.inputs))
    return found


def test_a_curve_that_hardly_bends_is_held_for_as_uncertain_as_one_that_may(
    smooth: NetworkFound, bending: Found
) -> None:
    assert spread_of(smooth.found).deviation == pytest.approx(spread_of(bending).deviation, rel=0.5)


def test_the_evidence_is_the_integral_over_the_parameters(smooth: NetworkFound, bending: Found) -> None:
    by_laplace = 0.5 * in_favour(smooth.found, bending)
    by_chance = by_laplace + beyond_laplace(smooth.found) - beyond_laplace(bending)
    assert by_laplace > 0.5 * CLEAR
    assert 0.7 * by_laplace < by_chance < 1.5 * by_laplace


def beyond_laplace(found: Found) -> float:
    """Logarithm of the integral over its approximation, by importance sampling, which knows no determinant."""
    problem = found.problem
    matrix, _ = problem.assembled(found.fit.normal, found.vector)
    root, rng = np.linalg.cholesky(np.linalg.inv(matrix)), np.random.default_rng(0)
    logs = np.empty(1000)
    for k in range(logs.size):
        unit = rng.normal(size=found.vector.size)
        vector = found.vector + root @ unit
        cost = problem.evaluate(vector).cost + problem.penalty(vector)
        logs[k] = 0.5 * (found.fit.cost - cost + float(unit @ unit))
    return float(logsumexp(logs) - np.log(logs.size))
