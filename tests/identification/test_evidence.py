"""What the evidence's figures mean, each against what is known in closed form."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gen.arrays import FloatArray, IntArray
from gen.identification.logs.records import Record, condense
from gen.identification.parts.bands import NEAREST, Band, next_speed
from gen.identification.parts.forms import GAIN_FORMS, TIME_FORMS, Form
from gen.identification.parts.linearity import linearity
from gen.identification.parts.orders import StructureCandidate, _held_out, beats
from gen.identification.parts.output_error import OutputErrorFit, OutputErrorProblem
from gen.identification.parts.structure import Structure
from gen.identification.parts.uncertainty import Uncertainty, criteria, residual_noise, residual_tests


def candidate(losses: list[float]) -> StructureCandidate:
    return cast(StructureCandidate, SimpleNamespace(losses=np.array(losses), loss=float(np.mean(losses))))


@pytest.mark.parametrize(
    ("rich", "better"),
    [
        ([0.9, 0.8, 0.85, 0.9, 0.85, 0.9], True),
        ([0.2, 1.3, 1.2, 1.1, 0.9, 1.05], False),  # one stretch alone: chance
        ([0.997, 0.996, 0.995, 0.997, 0.996, 0.995], False),  # sure, and not worth a pole
        ([1.1, 1.2, 1.1, 1.15, 1.2, 1.1], False),
    ],
)
def test_a_richer_structure_has_to_win_by_more_than_chance_and_by_something(rich: list[float], better: bool) -> None:
    assert beats(candidate(rich), candidate([1.0] * 6)) == better


def test_a_held_out_error_is_that_of_a_fit_which_did_not_see_the_rows() -> None:
    """A fit that is perfect where it looked and 3 K off where it did not is a bad one."""

    def fit(layout: object, vector: object, mask: FloatArray, most: int) -> object:
        return SimpleNamespace(residuals=[np.where(mask == 1.0, 0.0, 3.0)])

    problem = cast(OutputErrorProblem, SimpleNamespace(rows=np.array([0, 12]), weights=[np.full(12, 2.0)], fit=fit))
    given = cast(OutputErrorFit, SimpleNamespace(layout=None, vector=np.zeros(1)))
    stretch = np.repeat(np.arange(4.0), 3)
    folds = [(np.repeat(np.arange(4), 3) % 2 != k).astype(np.float64) for k in (0, 1)]
    assert _held_out(problem, given, stretch, folds).tolist() == [36.0] * 4


@pytest.mark.parametrize(("freedom", "factor"), [(3.0, 3.182), (10.0, 2.228), (30.0, 2.042), (1e6, 1.960)])
def test_an_interval_s_half_width_is_students(freedom: float, factor: float) -> None:
    """Two-sided 95 %, from the printed table."""
    assert Uncertainty(np.eye(1), freedom, ()).factor == pytest.approx(factor, abs=5e-4)


def record(rise: FloatArray, pwm: IntArray | None = None, sample_s: float = 2.0) -> Record:
    time = np.arange(rise.size, dtype=np.float64) * sample_s
    made = condense("run", time, np.full(rise.size, 100) if pwm is None else pwm, 30.0 + rise, 30.0)
    assert made is not None
    return made


def drifting(seed: int, length: int, step_s: float, tau_s: float) -> FloatArray:
    """Noise of variance 1 that forgets itself within tau (first-order autoregression)."""
    random = np.random.default_rng(seed)
    keep = np.exp(-step_s / tau_s)
    values = np.empty(length)
    values[0] = random.normal()
    for k in range(1, length):
        values[k] = keep * values[k - 1] + np.sqrt(1.0 - keep**2) * random.normal()
    return values


def test_noise_that_forgets_itself_slowly_averages_out_slowly() -> None:
    """The mean over a long time D has the variance 2 tau / D, not that of as many independent blocks."""
    tau = 150.0
    densities = []
    for seed in range(12):
        made = record(drifting(seed, 20_000, 2.0, tau))
        densities.append(residual_noise(made, made.rise, 0.0).density)
    assert np.mean(densities) == pytest.approx(2.0 * tau, rel=0.25)


def test_a_residual_that_follows_the_input_is_told_from_one_that_does_not() -> None:
    pwm = np.where(np.arange(6000) // 300 % 2 == 0, 60, 200)
    noise = np.random.default_rng(1).normal(0.0, 0.5, 6000)
    found = []
    for share in (0.0, 1.0):
        made = record(noise + share * (pwm > 100), pwm)
        found.append(residual_tests(made, residual_noise(made, made.rise - made.rise.mean(), 0.0)).independence)
    assert found[0] is not None and found[1] is not None
    assert found[0] < 1.0 < found[1]


def test_white_noise_looks_white_and_drift_does_not() -> None:
    chances = []
    for values in (np.random.default_rng(2).normal(0.0, 0.5, 6000), drifting(2, 6000, 2.0, 400.0)):
        made = record(values)
        chances.append(residual_tests(made, residual_noise(made, made.rise, 0.0)).whiteness_p)
    assert chances[0] > 0.01
    assert chances[1] < 1e-6


def test_with_the_same_error_more_parameters_are_worse() -> None:
    error = np.random.default_rng(3).normal(0.0, 0.2, 500)
    measured = np.linspace(0.0, 10.0, 500)
    few, many = (criteria(error, measured, 400.0, count) for count in (3.0, 6.0))
    mse = float(np.mean(error**2))
    assert few.aic == pytest.approx(400.0 * np.log(mse) + 2.0 * 3.0)
    assert few.bic == pytest.approx(400.0 * np.log(mse) + 3.0 * np.log(400.0))
    assert few.fpe_K2 == pytest.approx(mse * 403.0 / 397.0)
    assert (few.aic, few.bic, few.fpe_K2) < (many.aic, many.bic, many.fpe_K2)
    assert many.aic - few.aic > 0.0 and many.bic - few.bic > 0.0 and many.fpe_K2 > few.fpe_K2


@pytest.mark.parametrize("kind", ["pchip", "trend", "poly"])
@pytest.mark.parametrize("nodes", [[50.0, 250.0], [50.0, 120.0, 250.0], [50.0, 90.0, 170.0, 250.0]])
def test_a_form_goes_on_straight_where_its_points_lie_on_a_line(kind: str, nodes: list[float]) -> None:
    """Leaving out the fastest speed asks for what lies beyond the others."""
    x = np.array(nodes)
    form = Form("rise", kind, 1)  # type: ignore[arg-type]
    parameters = form.fit(x, 3.0 + 0.2 * x, np.ones(x.size))
    at = np.array([20.0, 50.0, 100.0, 250.0, 255.0])
    assert form.evaluate(parameters, x, at) == pytest.approx(3.0 + 0.2 * at)


def test_the_next_speed_is_where_least_is_known() -> None:
    pwm = np.arange(1.0, 256.0)
    plain = Band(pwm, np.zeros(255), np.full(255, 0.1), np.zeros(255))
    peak = replace(plain, forms_K=2.0 * np.exp(-(((pwm - 150.0) / 20.0) ** 2)))
    found = next_speed([plain, peak], [51, 102, 204, 255], {})
    assert found is not None
    assert found[0] == 150
    assert found[1] == pytest.approx(np.hypot(0.1, 2.0))
    near = replace(plain, forms_K=2.0 * np.exp(-(((pwm - 104.0) / 3.0) ** 2)))
    chosen = next_speed([near], [51, 102, 204, 255], {})
    assert chosen is not None
    assert abs(chosen[0] - 102) >= NEAREST  # so near to a speed that is known it would say little


@pytest.mark.parametrize(("spread", "linear"), [(0.0, True), (0.05, True), (0.5, False)])
def test_one_pole_that_moves_with_speed_makes_the_system_not_linear(spread: float, linear: bool) -> None:
    """The slow one stands still: that is not enough."""
    speeds = np.array([60, 130, 200])
    theta = np.stack([np.full(3, np.log(2000.0)), np.log(100.0) + spread * np.array([-1.0, 0.0, 1.0])], axis=1)
    layout = SimpleNamespace(positive=speeds, nodes=speeds, structure=Structure(2))
    fit = SimpleNamespace(layout=layout, theta=theta, steady=0.2 * speeds)
    found = linearity(cast(OutputErrorFit, fit))
    assert found.linear is linear
    assert ("one linear system would do" in found.verdict) is linear


def test_a_steady_rise_that_averaged_poles_miss_makes_the_system_not_linear() -> None:
    """Poles that stand still are not enough: 30 K where the averaged model says 36 K is no linear system."""
    speeds = np.array([60, 130, 200])
    theta = np.tile(np.log([2000.0, 100.0]), (3, 1))
    layout = SimpleNamespace(positive=speeds, nodes=speeds, structure=Structure(2))
    fit = SimpleNamespace(layout=layout, theta=theta, steady=np.array([0.2, 0.2, 0.15]) * speeds)
    found = linearity(cast(OutputErrorFit, fit))
    assert np.all(found.cv < 1e-12)
    assert found.averaged_share == pytest.approx((0.55 / 3.0 - 0.15) / 0.15)
    assert found.linear is False
    assert found.verdict == (
        "not one linear system: poles are alike, the averaged poles' steady rise is off by up to 22%"
    )


def test_a_form_says_what_it_stands_for() -> None:
    assert Form("log", "poly", 0).words == "the same at every speed"
    assert Form("rise", "pchip").words == "smooth curve through the points (of the steady rise)"
    assert len({form.words for form in GAIN_FORMS}) == len(GAIN_FORMS)
    assert len({form.words for form in TIME_FORMS}) == len(TIME_FORMS)


def test_ten_hours_at_one_speed_are_as_many_blocks_as_their_widths_say() -> None:
    """Four rows at first, then 3 % of the time since PWM changed, and never more than 1/180 of the run."""
    time = np.arange(36_000.0)
    record = condense("run", time, np.full(time.size, 100), 30.0 + np.sqrt(time), 30.0)
    assert record is not None
    first, last = 4.0 / 0.03, 200.0 / 0.03  # where the width begins to grow, and ends
    expected = first / 4.0 + np.log(last / first) / 0.03 + (36_000.0 - last) / 200.0
    assert record.time.size == pytest.approx(expected, rel=0.05)
    assert record.count.sum() == time.size
    assert record.count.max() <= 201
