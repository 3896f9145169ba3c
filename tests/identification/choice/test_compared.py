"""By how much, how sure, and when no further run can turn it: against scipy's own test, and against trying it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import ttest_1samp

from gen.arrays import FloatArray
from gen.identification.choice.compared import KINDS, NETWORK, PARTS, Comparison, comparison
from gen.identification.choice.decision import Tried, decided, told_without_folds
from gen.identification.choice.left_out import BLOCKS, Judged


def of(logs: FloatArray | list[float]) -> Comparison:
    """Both kinds with these logarithms of the parts' error over the network's."""
    parts = tuple(np.exp(logs).tolist())
    rms = math.sqrt(float(np.mean(np.square(parts))))
    return Comparison({PARTS: rms, NETWORK: 1.0}, {PARTS: parts, NETWORK: (1.0,) * len(parts)})


@pytest.mark.parametrize("count", [2, 3, 5, 9])
def test_the_interval_is_that_of_students_t(count: int) -> None:
    logs = np.random.default_rng(count).normal(-0.3, 0.4, count)
    low, high = ttest_1samp(logs, 0.0).confidence_interval(0.95)
    made = of(logs)
    assert made.ratio == pytest.approx(np.exp(np.mean(logs)))
    assert made.interval == pytest.approx((np.exp(low), np.exp(high)))


def test_one_run_alone_is_never_sure() -> None:
    assert of([-3.0]).interval == (0.0, math.inf)
    assert decided(of([-3.0]), "run", 0).kind == NETWORK


@pytest.mark.parametrize("seed", range(30))
def test_what_is_called_settled_no_further_runs_turn(seed: int) -> None:
    """Tried with further runs that are alike, and with ones that are not."""
    rng = np.random.default_rng(seed)
    known, further = rng.normal(-0.1, 0.3, int(rng.integers(1, 5))), int(rng.integers(1, 4))
    alike = [np.full(further, value) for value in -np.geomspace(1e-4, 1e4, 400)]
    mixed = [-np.exp(rng.normal(0.0, 2.0, further)) for _ in range(100)]
    turned = any(of(np.append(known, more)).interval[1] < 1.0 for more in (*alike, *mixed))
    assert of(known).may_show_parts(further) == turned


def test_runs_and_parts_that_only_one_predicts_do_not_count() -> None:
    def blocks(square: float) -> FloatArray:
        return np.append(np.full(BLOCKS - 1, square), np.nan)

    casing, winding = Judged("a.csv", "casing"), Judged("a.csv", "winding")
    other = Judged("b.csv", "casing")
    made = comparison(
        {
            NETWORK: [{casing: blocks(4.0), winding: blocks(100.0)}, {other: blocks(1.0)}, None],
            PARTS: [{casing: blocks(16.0)}, {other: blocks(9.0)}, {other: blocks(1.0)}],
        }
    )
    assert made is not None
    assert made.by_run == {NETWORK: (2.0, 1.0), PARTS: (4.0, 3.0)}
    assert made.error_K == pytest.approx({NETWORK: math.sqrt(2.5), PARTS: math.sqrt(12.5)})
    assert comparison({kind: [None] for kind in KINDS}) is None


@pytest.mark.parametrize(
    ("logs", "kind", "said"),
    [
        ([-0.5, -0.6, -0.55, -0.45], PARTS, "parts, because on 4 runs left out"),
        ([-0.5, 0.4, -0.6, 0.1], NETWORK, "within chance, and its guarantee is the better founded"),
        ([-0.020, -0.021, -0.019, -0.020], NETWORK, "within chance"),  # sure, and next to nothing
        ([0.9, 1.0, 1.1], NETWORK, "(2.72 times, 95 %: 2.12 to 3.48)"),
    ],
)
def test_within_chance_the_network_is_taken(logs: list[float], kind: str, said: str) -> None:
    made = decided(of(logs), "run", 0)
    assert made.kind == kind
    assert said in made.why


def test_what_refuses_or_leaves_a_part_out_is_not_taken() -> None:
    both = Tried(("casing", "winding"))
    made = told_without_folds({NETWORK: Tried(refused="no way out"), PARTS: both})
    assert made is not None
    assert (made.kind, made.why) == (PARTS, "parts, because the network refused: no way out")
    made = told_without_folds({NETWORK: both, PARTS: Tried(("casing",))})
    assert made is not None
    assert (made.kind, made.lacks) == (NETWORK, ("winding",))
    assert told_without_folds({NETWORK: both, PARTS: both}) is None
