"""What is searched for is what tells most: held against exact solutions and another optimiser."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import least_squares

from gen.arrays import FloatArray, IntArray
from gen.errors import InputError
from gen.identification.network.fitting.inputs import START_K
from gen.identification.network.fitting.problem import Problem
from gen.model.network_solution import NetworkSolution
from gen.planning.limits import Wishes, limits_of
from gen.planning.march import March, problem_of
from gen.planning.search import BINS
from tests.planning.open_question import AMBIENT, AT_REST, DENSITY, changed, question, searched, short_run
from tests.refinement.network.motor import read, tree

ROW_S = 30.0
WISHES = Wishes(hours=2.0)


PRIOR = np.array([0.15] * 6 + [0.05])
"""Standard deviations of the logarithms of what the file may be off by: two capacities, the path between, the way out,
two heats, and the way out at rest over that while turning."""
AS_CHANGED = np.array([0.0] * 6 + [np.log(AT_REST)])


def read_at(numbers: FloatArray, time: FloatArray, pwm: IntArray) -> FloatArray:
    """Exact readings of the small motor, its equations written anew, shape (2 N,).

    Parameters
    ----------
    numbers
        How far it is off its file, as `PRIOR` has them.
    time, pwm
        Evenly spaced; shape (N,) each.
    """
    factor = np.exp(numbers)
    capacity = np.array([120.0 * factor[0], 400.0 * factor[1]])
    inner = 0.5 * factor[2]
    step = {}
    for level in np.unique(pwm).tolist():
        way_out = factor[3] * (0.2 + 0.3 * (level / 255.0) ** 0.8 if level else 0.18 * factor[6])
        heats = [factor[4] * (0.00015 * level**2 + 0.01 * level), factor[5] * 0.015 * level]
        whole = np.zeros((3, 3))
        whole[:2, :2] = np.array([[-inner, inner], [inner, -inner - way_out]]) / capacity[:, None]
        whole[:2, 2] = np.array(heats) / capacity
        step[level] = expm(whole * (time[1] - time[0]))
    state, made = np.array([0.0, 0.0, 1.0]), []
    for level in pwm.tolist():
        made.append(AMBIENT + state[:2])
        state = step[level] @ state
    return np.asarray(made).T.ravel()


def evidence(*pwm: IntArray) -> float:
    """Least weighed squares with which the file without the effect takes the short run of the motor, and another."""
    asked = [(short_run().time_s[::10], short_run().pwm[::10])]
    asked += [(ROW_S * np.arange(one.size, dtype=np.float64), one) for one in pwm]
    true = [read_at(AS_CHANGED, *run) for run in asked]

    def off(numbers: FloatArray) -> FloatArray:
        each = zip(asked, true, strict=True)
        away = [(read_at(numbers, *run) - shown) * np.sqrt((run[0][1] - run[0][0]) / DENSITY) for run, shown in each]
        return np.concatenate([*away, numbers / PRIOR])

    return 2.0 * float(least_squares(off, np.zeros(PRIOR.size)).cost)


def test_the_oracle_s_motor_is_the_file_s() -> None:
    run = short_run()
    exact = NetworkSolution(read(changed()).model).simulate_times(run.time_s, run.pwm, AMBIENT)
    assert read_at(AS_CHANGED, run.time_s, run.pwm) == pytest.approx(np.concatenate(list(exact.values())), abs=1e-6)


def held(blocks: IntArray, block_s: float) -> IntArray:
    """Blocks at the oracle's rows."""
    return np.repeat(blocks, round(block_s / ROW_S))


def test_the_planned_run_tells_more_against_the_file_alone_than_any_constant_one_by_another_optimiser() -> None:
    expected, limits, grid, sought = searched(WISHES)
    before = evidence()
    planned = evidence(held(expected.levels[sought.best], grid.block_s)) - before
    plain = evidence(held(expected.levels[sought.plain], grid.block_s)) - before
    each = [evidence(held(np.full(grid.blocks, level), grid.block_s)) - before for level in limits.levels]
    assert planned > 2.0 * max(each)
    assert planned >= plain


def test_whole_fits_agree_with_their_linear_part_where_hypotheses_are_near() -> None:
    expected, limits, grid, _ = searched(WISHES)
    for level in range(1, len(limits.levels)):
        index = np.full(grid.blocks * BINS, level)
        assert expected.whole(index).worth == pytest.approx(expected.worth(index[None])[0], rel=0.05)


def test_the_fast_march_is_the_fit_s_own_simulation() -> None:
    expected, limits, _, sought = searched(WISHES)
    for one in expected.remaining.hypotheses:
        index = np.repeat(np.stack([sought.best, sought.plain]), BINS, axis=1)
        found = March(one, expected.stage, limits.levels).predicted(index)
        problem: Problem[Any] = problem_of(one, expected.stage, expected.levels[index], expected.remaining.density)
        evaluated, slopes = problem.slopes(problem.prior.mean)
        for k, rows in enumerate(problem.inputs.rows):
            assert found.reading[k] == pytest.approx(-evaluated.residual[rows].ravel(), abs=1e-6)
            exact = slopes[rows].reshape(found.slopes[k].shape)
            assert found.slopes[k] == pytest.approx(exact, abs=2e-3 * float(np.abs(exact).max()))


def test_what_is_maximised_is_what_least_squares_leaves_of_the_difference() -> None:
    expected, _, _, sought = searched(WISHES)
    index = np.repeat(sought.best, BINS)
    weight = expected.weight(index.size)
    first, second = (March(h, expected.stage, tuple(expected.levels)) for h in expected.remaining.hypotheses)
    one, two = first.predicted(index[None]), second.predicted(index[None])
    hypotheses, left = expected.remaining.hypotheses, []
    (standing, none) = hypotheses
    for true, other, a, b in ((one, two, standing, none), (two, one, none, standing)):
        size = other.slopes.shape[-1]
        known = np.eye(size) / START_K**2
        known[: b.shape.size, : b.shape.size] = b.precision
        lines = np.concatenate([other.slopes[0] * np.sqrt(weight)[:, None], np.linalg.cholesky(known).T])
        each = []
        for moved in a.truths:
            shown = true.reading[0] + true.slopes[0, :, : moved.size] @ moved
            right = np.concatenate([np.sqrt(weight) * (shown - other.reading[0]), np.zeros(size)])
            each.append(float(np.sum((right - lines @ np.linalg.lstsq(lines, right)[0]) ** 2)))
        left.append(np.mean(each))
    assert expected.worth(index[None])[0] == pytest.approx(np.mean(np.log1p(left)), rel=1e-4)


def test_no_part_comes_near_a_limit_and_no_pwm_beyond_it() -> None:
    free, _, grid, sought = searched(WISHES)
    hot = float(free.hottest(np.repeat(sought.best, BINS)[None]).max())
    limit = hot - 6.0
    expected, limits, grid, sought = searched(Wishes(hours=2.0, limit_degC=limit, margin_K=3.0, max_pwm=230))
    pwm = expected.levels[sought.best]
    assert np.abs(pwm).max() <= 230
    time = ROW_S * np.arange(grid.blocks * round(grid.block_s / ROW_S), dtype=np.float64)
    true = read_at(AS_CHANGED, time, held(pwm, grid.block_s))
    assert true.max() < limit - 2.0
    assert limits.hottest == pytest.approx(limit - 3.0)


def test_an_over_temperature_alarm_is_a_limit_of_its_part() -> None:
    _, data, left = question()
    made = tree()
    made["alarms"] = [
        {"name": "hot", "kind": "over_temperature", "component": "casing", "limit_degC": 60, "persistence_s": 1}
    ]
    limits = limits_of(read(made), WISHES, data, left)
    assert limits.hottest.tolist() == [197.0, 57.0]
    # Its sensor shows 60 degC where it is at 40: half as much again. One that shows too little allows no more.
    for gain, about, limit in ((0.5, "zero_degC", 37.0), (0.25, "ambient", 50.0), (-0.5, "ambient", 57.0)):
        made["network"]["nodes"][1]["sensor"] = {"gain_error": gain, "gain_about": about}
        limits = limits_of(read(made), WISHES, data, left)
        assert limits.hottest.tolist() == pytest.approx([197.0, limit])


def test_it_turns_backwards_only_where_a_run_did_and_it_matters_or_as_asked() -> None:
    coefficients, data, left = question()
    levels = [limits_of(coefficients, Wishes(hours=2.0, reverse=asked), data, left).levels for asked in (None, True)]
    assert min(levels[0]) == 0
    assert [level for level in levels[1] if level < 0] == [-255, -146]
    assert all(abs(level) in levels[0] for level in levels[1])


def test_a_limit_that_no_run_keeps_is_told() -> None:
    with pytest.raises(InputError, match=r"comes to 2\d\.\d degC at PWM 0 already"):
        searched(Wishes(hours=2.0, limit_degC=20.0))


def test_the_same_seed_plans_the_same_run_and_chance_has_a_say() -> None:
    first, again = (searched(WISHES)[3].best for _ in range(2))
    assert np.array_equal(first, again)


def test_one_hypothesis_alone_is_known_better_after_the_planned_run_than_after_a_constant_one() -> None:
    expected, limits, grid, sought = searched(WISHES, ("standstill_cooling",))
    planned = np.repeat(sought.best, BINS)
    before, after = expected.deviations(planned)
    at = expected.remaining.hypotheses[0].shape.places[0].columns[0]
    assert after[at] < before[at]
    assert np.all(after <= before * (1.0 + 1e-9))
    constants = [np.full((1, planned.size), level) for level in range(len(limits.levels))]
    assert expected.worth(planned[None])[0] > max(float(expected.worth(one)[0]) for one in constants)
    own = expected.remaining.hypotheses[0].shared[at]
    assert np.exp(own) == pytest.approx(AT_REST, rel=0.3)
    assert grid.blocks == planned.size // BINS
