"""Accuracy of the float32 recursion against the exact solution, and its proof."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from gen.lowering import float32, increments
from gen.lowering.dynamics import LoweringError, domain_rows, dynamics
from gen.lowering.float32 import FloatComponent, Singles
from gen.model.exact import ExactSolution
from gen.reference.float32 import FloatStep, Word
from tests.model.examples import NAMES, model

LIMIT_K = 1e-3
SAMPLES = 43_200

PWM = NDArray[np.int64]
Words = NDArray[np.uint32]


@dataclass
class Run:
    """Words after every kept sample, shape (kept, lanes, 2 n), and rises in K, shape (kept, lanes)."""

    words: Words
    rises: Singles
    folds: int
    saturations: int


@cache
def lowered(example: str) -> tuple[FloatComponent, ...]:
    thermal = model(example)
    return tuple(float32.lower_component(thermal, c, LIMIT_K) for c in thermal.components)


def simulate(component: FloatComponent, rows: PWM, start: Singles, every: int = 1) -> Run:
    """Run lanes of row numbers, shape (lanes, samples); a change without a change is a change by 0."""
    step = FloatStep(component)
    state: list[Word] = step.start(start)
    steady: Word = np.zeros_like(start)
    rates: list[Word] = [np.zeros_like(start) for _ in range(component.order)]
    words, rises = [], []
    for k in range(rows.shape[1]):
        row = rows[:, k]
        old, old_steady = rates, steady
        steady, rates = component.steady[row], list(component.rates[row].T)
        step.changed(state, old, rates, old_steady, steady)
        for _ in range(1, component.substeps):
            step.constant(state, rates)
        if k % every == every - 1:
            rises.append(step.rise(state, steady))
            if every == 1:
                words.append(np.stack(step.words(state), axis=-1))
    assert all(word.dtype == np.float32 for word in (*state, *rises))
    return Run(np.array(words), np.array(rises), step.folds, int(step.saturations.sum()))


def lanes(samples: int, seed: int) -> PWM:
    rng = np.random.default_rng(seed)
    block = samples // 18
    return np.stack(
        [
            np.full(samples, 255),
            np.repeat(rng.integers(0, 256, 18), block)[:samples],
            np.tile([0, 255], samples // 2),
            rng.integers(0, 256, samples),
            np.tile(np.r_[np.full(2000, 255), np.full(3000, 0)], samples // 5000 + 1)[:samples],
            np.repeat(rng.integers(0, 256, samples // 8), 8),
        ]
    )


STARTS = np.array([0.0, 60.0, 0.0, 40.3, 100.7, -20.0])


@pytest.mark.parametrize("example", NAMES)
def test_error_stays_below_its_proven_bound(example: str) -> None:
    thermal = model(example)
    samples = SAMPLES if example == "my1016" else 14_400
    profiles = lanes(samples, seed=1)
    start = STARTS.astype(np.float32)
    initial = {c.name: start.astype(np.float64) for c in thermal.components}
    exact = ExactSolution(thermal).simulate(profiles, initial)
    for component in lowered(example):
        run = simulate(component, profiles - thermal.domain_pwm[0], start, every=5)
        error = np.abs(run.rises.T - exact[component.name][:, 5::5]).max()
        assert component.proof is not None
        print(f"{example} {component.name}: bound {component.proof.bound_K:.2e} K, worst seen {error:.2e} K")
        assert error <= component.proof.bound_K <= LIMIT_K
        assert run.saturations == 0
        assert run.folds > 0


def test_steady_rises_lie_on_the_grid_and_products_keep_their_range() -> None:
    for example in NAMES:
        for component in lowered(example):
            scaled = component.steady.astype(np.float64) / component.grid
            assert np.array_equal(scaled, np.rint(scaled))
            assert component.proof is not None
            assert max(np.abs(component.proof.rise_range_K)) < 2.0**component.range_bits
            for threshold, word in zip(component.thresholds, component.threshold_words, strict=True):
                assert np.array(word << 16, dtype=np.uint32).view(np.float32) == np.float32(threshold)


def test_half_ulp_is_numpys() -> None:
    for value in (1.0, 1.5, 1.99, 160.0, 3e-7):
        assert float32.half_ulp(value) == float(np.spacing(np.float32(value))) / 2.0


def test_bound_follows_the_given_rows() -> None:
    thermal = model("my1016")
    brush, component = lowered("my1016")[0], thermal.components[0]
    exact = dynamics(thermal, component, brush.substeps)
    same = float32.with_rows(brush, exact, brush.rates, brush.steady)
    assert same == replace(brush, rates=same.rates, steady=same.steady)
    worse = float32.with_rows(brush, exact, brush.rates * np.float32(1.0 + 2e-6), brush.steady)
    assert worse.proof is not None
    assert brush.proof is not None
    assert worse.proof.bound_K > 2.0 * brush.proof.bound_K
    with pytest.raises(LoweringError, match="off the grid"):
        float32.with_rows(brush, exact, brush.rates, brush.steady + np.float32(2.0**-18))


@pytest.mark.parametrize(("example", "place"), [("my1016", 0), ("two_mass", 0), ("two_mass", 1)])
def test_state_map_is_continuous_with_the_carry(example: str, place: int) -> None:
    """The proof rests on it: z stays at a change of PWM, x moves by the carry and nothing else."""
    thermal = model(example)
    exact = dynamics(thermal, thermal.components[place], 1)
    n = exact.order
    z = np.array([60.0, 1e-2, 1e-5, 1e-8][:n])
    settled = np.outer(exact.steady, np.eye(n)[0])
    x = settled + np.einsum("pij,pj->pi", increments.state_map(exact.c), z - settled)
    q = -np.einsum("pj,pj->p", exact.c, x - settled)
    moved = np.zeros_like(x)
    moved[:, n - 2] = (q - q[0]) / 12.0
    left = np.abs(x - x[0] - moved)
    assert left.max() < 1e-13
    assert left[:, n - 2].max() < 1e-5 * np.abs(moved).max()


def test_rows_cover_the_domain() -> None:
    thermal = model("my1016")
    assert len(lowered("my1016")[0].steady) == len(domain_rows(thermal))


def test_literals_round_trip() -> None:
    rng = np.random.default_rng(0)
    values = np.concatenate([rng.normal(size=200) * 10.0 ** rng.integers(-20, 20, 200), [0.0, 768.0, 1e8]])
    for value in values.astype(np.float32):
        text = FloatComponent.literal(float(value))
        assert text.endswith("f")
        assert "." in text or "e" in text
        assert np.float32(text[:-1]) == value
