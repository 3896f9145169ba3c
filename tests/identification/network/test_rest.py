"""What is said of rest where no run rests: by the law of conductances over speed, with an error that holds."""

from __future__ import annotations

import re

import numpy as np
import pytest

from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.identification.network.fitting.speed_laws import HEAT, OUTSIDE, WITHIN, Law
from gen.identification.network.identify import NetworkFound, identify_network
from gen.identification.network.left_out import each_alone, folds_for_nodes, folds_of
from gen.identification.network.telling.document import network_text, turned_range
from gen.identification.network.telling.resting import Rested, rested
from gen.identification.network.telling.summary import Summary
from gen.identification.network.telling.uncertainty import UNREACHED, spread_of, steady_of
from gen.identification.settings import Settings
from gen.model.network_solution import NetworkSolution
from gen.runs import Run
from tests.identification.network.plant import ROOM, TWO, holds

SPEEDS = (50, 100, 170, 250)


def found_of(runs: list[Run]) -> NetworkFound:
    sources = [Source(f"run_{k}.csv", run) for k, run in enumerate(runs)]
    return identify_network(make_network_data(sources, None), lambda said: None, 0)


def turning(rng: np.random.Generator) -> list[Run]:
    return [TWO.run(holds((pwm, 60)), rng) for pwm in SPEEDS]


def told(result: NetworkFound) -> Rested:
    return rested(result.found, spread_of(result.found), turned_range(result), 255)


@pytest.fixture(scope="module")
def never_rested() -> NetworkFound:
    return found_of(turning(np.random.default_rng(20)))


@pytest.mark.parametrize("law", [OUTSIDE, WITHIN, HEAT], ids=lambda law: law.name)
def test_a_laws_derivatives_are_those_of_its_values(law: Law) -> None:
    rng = np.random.default_rng(21)
    own, speed, step = rng.normal(0.0, 0.5, law.size), np.array([0.0, 0.07, 0.5, 1.0]), 1e-6
    by_turning, by_rest = law.evaluated(law.basis(speed), own)[1], law.at_rest(own)[1]
    for k in range(law.size):
        up, down = (own + step * sign * np.eye(law.size)[k] for sign in (1.0, -1.0))
        numeric = (law.evaluated(law.basis(speed), up)[0] - law.evaluated(law.basis(speed), down)[0]) / (2.0 * step)
        assert by_turning[:, k] == pytest.approx(numeric, abs=1e-8)
        if law is not HEAT:
            assert by_rest[k] == pytest.approx((law.at_rest(up)[0] - law.at_rest(down)[0]) / (2.0 * step), abs=1e-8)


@pytest.mark.parametrize("law", [OUTSIDE, WITHIN, HEAT], ids=lambda law: law.name)
def test_many_curves_of_a_law_are_each_as_one_alone(law: Law) -> None:
    own, speed = np.random.default_rng(22).normal(0.0, 1.0, (3, law.size)), np.array([0.0, 0.2, 0.9])
    value, slopes = law.evaluated(law.basis(speed), own)
    at_rest, slopes_at_rest = law.at_rest(own)
    for m in range(3):
        one, by_one = law.evaluated(law.basis(speed), own[m])
        assert value[:, m] == pytest.approx(one, abs=1e-12)
        assert slopes[:, m] == pytest.approx(by_one, abs=1e-12)
        assert at_rest[m] == pytest.approx(law.at_rest(own[m])[0], abs=1e-12)
        assert slopes_at_rest[m] == pytest.approx(law.at_rest(own[m])[1], abs=1e-12)


def test_an_interval_is_wider_where_no_run_came_near(
    never_rested: NetworkFound, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, spread = never_rested.found, spread_of(never_rested.found)
    run, between = 170, 210  # runs of an hour, and a speed that no run is near

    def widened(pwm: int) -> tuple[float, float]:
        """What is added to the first part's variance, K^2, and its rise, K."""
        steady = steady_of(found, spread, [pwm], 255)
        with monkeypatch.context() as without:
            without.setattr("gen.identification.network.telling.uncertainty.UNREACHED", 0.0)
            plain = steady_of(found, spread, [pwm], 255)
        return float(steady.deviation[0, 0] ** 2 - plain.deviation[0, 0] ** 2), float(steady.rise[0, 0])

    more, rise = widened(between)
    assert more == pytest.approx((UNREACHED * rise) ** 2, rel=1e-6)
    more, rise = widened(run)
    assert more < (0.2 * UNREACHED * rise) ** 2  # it came to within a fifth


def test_rest_follows_from_the_law_of_the_speeds(never_rested: NetworkFound) -> None:
    """The plant's conductances go in a straight line to rest: what cools it there is 0.3 of 0.7 W/K at full speed."""
    structure = never_rested.found.structure
    levels = never_rested.inputs.levels
    outside = [q for q, (_, j) in enumerate(structure.paths) if j < 0]
    at_rest = sum(
        np.exp(structure.laws[q].at_rest(never_rested.found.vector[structure.conductances[q]])[0]) for q in outside
    )
    speed = levels.speed.max()

    def moved(q: int) -> float:
        law = structure.laws[q]
        return float(np.exp(law.evaluated(law.basis(np.array([speed])), vector[structure.conductances[q]])[0][0]))

    vector = never_rested.found.vector
    full = sum(moved(q) for q in outside)
    assert at_rest / full == pytest.approx(0.3 / (0.3 + 0.4 * speed), rel=0.25)


def test_the_error_declared_at_rest_holds_though_no_run_rests(never_rested: NetworkFound) -> None:
    _, loaded = network_text(never_rested, Settings("plant"))
    provenance = loaded.document.provenance
    assert provenance is not None
    pwm = holds((250, 60), (0, 40))
    around = np.full(pwm.size, ROOM)
    true = TWO.true(pwm, around)
    time = 4.0 * np.arange(pwm.size, dtype=np.float64)
    start = dict.fromkeys(TWO.sensed, ROOM)
    shown = NetworkSolution(loaded.model).simulate_times(time, pwm, around, None, start)
    for name, node in TWO.sensed.items():
        (band,) = (band for band in provenance.error if band.component == name and band.pwm == (0, 0))
        low, high = band.model_minus_measured_K
        error = (shown[name] - true[:, node])[pwm == 0]
        assert np.mean((low <= error) & (error <= high)) >= 0.95
        # One that would hold for any model says nothing.
        assert high - low < 0.5 * np.ptp(true[:, node])


def test_what_a_rest_would_tell_is_what_it_tells(never_rested: NetworkFound) -> None:
    before = told(never_rested)
    rng = np.random.default_rng(20)
    after = told(found_of([*turning(rng), TWO.run(holds((250, 180), (0, 20)), rng)]))
    assert before.then_K < 0.7 * before.now_K
    assert after.now_K == pytest.approx(before.then_K, rel=0.5)


def test_the_warning_says_what_it_costs_and_what_would_help(never_rested: NetworkFound) -> None:
    (said,) = (warning for warning in Summary(never_rested).warnings() if "PWM 0" in warning)
    now, then = (float(number) for number in re.findall(r"(\d+\.\d) K", said))
    assert now > then
    assert "20 minutes at PWM 0" in said


def test_runs_of_one_speed_each_are_cut_into_stretches_to_count_the_nodes() -> None:
    rng = np.random.default_rng(22)
    alone = found_of(turning(rng)).inputs
    assert each_alone(alone)
    assert not any(mask[row].all() for mask in folds_for_nodes(alone) for row in alone.rows)
    assert all(any(mask[row].all() for mask in folds_of(alone)) for row in alone.rows)
    alike = found_of([TWO.run(holds((90, 30), (200, 30), (0, 20)), rng) for _ in range(3)]).inputs
    assert not each_alone(alike)
    assert all(np.array_equal(a, b) for a, b in zip(folds_for_nodes(alike), folds_of(alike), strict=True))
