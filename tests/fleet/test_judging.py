"""What is common and what is one motor's, on residuals whose truth is drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.fleet.statistics.batches import Group
from gen.fleet.statistics.findings import Finding, limit_of
from gen.fleet.statistics.judging import Judged, judge
from gen.fleet.statistics.patterns import Hypothesis, Products
from gen.fleet.watch import _explained, _state

ROWS, HYPOTHESES = 200, 4


def patterns(seed: int) -> FloatArray:
    """Overlapping, as heats at neighbouring nodes are."""
    rng = np.random.default_rng(seed)
    shared = rng.normal(size=ROWS)
    return np.array([shared + rng.normal(size=ROWS) for _ in range(HYPOTHESES)])


def products(seed: int, amounts: dict[int, float], scatter: float = 0.1) -> Products:
    rng = np.random.default_rng([seed, 1])
    shapes = patterns(seed)
    amount = rng.normal(0.0, scatter, HYPOTHESES)
    for place, more in amounts.items():
        amount[place] += more
    residual = amount @ shapes + rng.normal(0.0, 0.1, ROWS)
    return Products(shapes @ shapes.T, shapes @ residual, float(residual @ residual), ROWS)


def judged(fleet: list[Products], groups: Sequence[Group], level: float) -> Judged:
    """Motors whose models rest on as many runs as each other's."""
    return judge(fleet, np.full(len(fleet), 3), groups, level)


def test_a_healthy_fleet_is_called_so() -> None:
    false = 0
    for fleet in range(40):
        found = judged([products(1000 * fleet + m, {}) for m in range(30)], (), 0.01)
        assert found.common is None
        false += sum(finding is not None for finding in found.own)
    # 1200 runs at a level of 1 % for both models together, so half of that here: 6 are expected at most.
    assert false <= 12


def test_one_is_found_and_named_among_many_that_share_an_effect() -> None:
    fleet = [products(m, {1: 2.0} | ({3: 3.0} if m == 7 else {})) for m in range(30)]
    found = judged(fleet, (), 0.01)
    assert found.common is not None
    assert found.common.place == 1
    assert found.common.amount == pytest.approx(2.0, abs=0.2)
    own = found.own[7]
    assert own is not None
    assert own.place == 3
    assert own.amount == pytest.approx(3.0, abs=0.5)
    assert sum(finding is not None for finding in found.own) == 1


def test_motors_with_one_run_are_no_more_often_called_than_others() -> None:
    """Half of a fleet has models that rest on one run, and scatters by half as much again."""
    false = {1: 0, 3: 0}
    for fleet in range(20):
        runs = np.where(np.arange(100) % 2, 1, 3)
        made = [products(1000 * fleet + m, {}, scatter=0.15 if runs[m] == 1 else 0.1) for m in range(100)]
        for count, finding in zip(runs, judge(made, runs, (), 0.01).own, strict=True):
            false[count] += finding is not None
    # 1000 of each at half of the level: 5 are expected at most. With one scale for all it is 22 and 1.
    assert false[1] <= 9
    assert false[3] <= 9


def test_a_fault_is_found_among_few_motors_that_rest_on_many_runs() -> None:
    """Three motors are no class: they are judged with those that rest on the next fewer runs."""
    runs = np.array([40] * 3 + [1] * 30)
    made = [products(m, {3: 3.0} if m in (1, 20) else {}) for m in range(33)]
    found = judge(made, runs, (), 0.01).own
    assert [m for m, finding in enumerate(found) if finding is not None] == [1, 20]


def test_what_explains_less_than_a_step_of_the_converter_is_no_finding() -> None:
    fleet = [products(m, {0: 0.1} if m == 3 else {}, scatter=0.001) for m in range(30)]
    assert judged(fleet, (), 0.01).own[3] is None


def test_few_motors_need_more() -> None:
    limits = [limit_of(motors, 10, 0.01) for motors in (8, 20, 100, 1000)]
    assert limits == sorted(limits, reverse=True)
    assert limits[-1] == pytest.approx(3.5, abs=0.1)  # of a normal distribution: Phi^-1(1 - 0.01 / 40) = 3.48


@pytest.mark.parametrize(
    ("errors_K", "state"),
    [([0.1, 0.12, 0.15], "differs from its fleet"), ([0.1, 0.12, 4.0], "warmer"), ([3.0], "differs from its fleet")],
)
def test_a_motor_that_its_own_model_no_longer_explains_was_not_always_so(errors_K: list[float], state: str) -> None:
    """Where a fleet scatters, a change may hide from the comparison with its own model, not from that with the mean."""
    names = [Hypothesis("heat", "brush")]
    beside = Finding(0, 0.6, 40.0, 9.0)
    assert _state(names, None, beside, explained=_explained(np.array(errors_K)))[0] == state
