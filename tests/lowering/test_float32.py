"""Accuracy of the float32 recursion against the exact solution, and its proof."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example as with_example
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gen.arrays import FloatArray, IntArray, SingleArray
from gen.lowering import float32
from gen.lowering.float32 import FloatComponent
from gen.lowering.recursion import increments
from gen.lowering.recursion.dynamics import domain_rows, dynamics
from gen.model.exact import ExactSolution
from gen.reference.float32 import FloatStep, accumulated
from gen.reference.lanes import FloatLanes
from tests.model.examples import NAMES, model

LIMIT_K = 1e-3
SAMPLES = 43_200


@cache
def lowered(example: str) -> tuple[FloatComponent, ...]:
    thermal = model(example)
    return tuple(float32.lower_component(thermal, c, LIMIT_K) for c in thermal.components)


def rises(component: FloatComponent, rows: IntArray, start_mK: IntArray, every: int) -> FloatArray:
    """Rises in K after every ``every``-th sample of runs of row numbers, shape (lanes, samples // every)."""
    board = FloatLanes(component, start_mK.tolist())
    before, kept = None, []
    for k, row in enumerate(rows.T):
        board.sample(row, before)
        before = row
        if k % every == every - 1:
            kept.append(board.rise())
    return np.array(kept).T


def lanes(samples: int, seed: int) -> IntArray:
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


STARTS_MK = np.array([0, 60_000, 0, 40_300, 100_700, -20_000])


@pytest.mark.parametrize("example", NAMES)
def test_error_stays_below_its_proven_bound(example: str) -> None:
    thermal = model(example)
    samples = SAMPLES if example == "my1016" else 14_400
    profiles = lanes(samples, seed=1)
    exact = ExactSolution(thermal).simulate(profiles, {c.name: STARTS_MK / 1000.0 for c in thermal.components})
    for component in lowered(example):
        found = rises(component, profiles - thermal.domain_pwm[0], STARTS_MK, every=5)
        error = np.abs(found - exact[component.name][:, 5::5]).max()
        assert component.proof is not None
        print(f"{example} {component.name}: bound {component.proof.bound_K:.2e} K, worst seen {error:.2e} K")
        assert error <= component.proof.bound_K <= LIMIT_K


@pytest.mark.parametrize("example", NAMES)
def test_words_of_the_proven_ranges_fit_32_bits(example: str) -> None:
    for component in lowered(example):
        assert component.proof is not None
        ranges = [max(np.abs(component.proof.rise_range_K)), *component.proof.increment_range_K]
        for bits, largest in zip(component.fraction_bits, ranges, strict=True):
            assert largest * 2.0**bits < 2.0**31
        assert np.abs(component.steady).max() < 2**31
        assert all(a <= b for a, b in pairwise(component.fraction_bits))


def test_half_ulp_is_numpys() -> None:
    for value in (1.0, 1.5, 1.99, 160.0, 3e-7):
        assert float32.half_ulp(value) == float(np.spacing(np.float32(value))) / 2.0


def test_bound_follows_the_given_rows() -> None:
    thermal = model("my1016")
    brush, component = lowered("my1016")[0], thermal.components[0]
    exact = dynamics(thermal, component, brush.substeps)
    steady = exact.steady.astype(np.float32)
    same = float32.with_rows(brush, exact, brush.rates, steady)
    assert np.abs(same.steady * 2.0 ** -brush.fraction_bits[0] - exact.steady).max() < 4e-5  # half of 2^9 units
    assert same.proof is not None
    assert brush.proof is not None
    assert same.proof.bound_K < 1.2 * brush.proof.bound_K
    for rates, rises_K in ((brush.rates * np.float32(1.0 + 4e-6), steady), (brush.rates, steady + np.float32(1e-3))):
        worse = float32.with_rows(brush, exact, rates, rises_K)
        assert worse.proof is not None
        assert worse.proof.bound_K > 1.5 * brush.proof.bound_K


def test_rows_far_off_lose_the_proof_and_get_room() -> None:
    thermal = model("my1016")
    brush, component = lowered("my1016")[0], thermal.components[0]
    hot = np.full(len(brush.steady), 250.0, dtype=np.float32)
    given_up = float32.with_rows(brush, dynamics(thermal, component, brush.substeps), brush.rates, hot)
    assert given_up.saturates
    assert np.abs(given_up.steady).max() <= 2**float32.LIMIT_BITS
    assert np.array_equal(given_up.steady * 2.0 ** -given_up.fraction_bits[0], hot)


@given(
    arrays(np.int64, 4, elements=st.integers(-(2**38), 2**38)),
    arrays(np.float32, 4, elements=st.floats(-(2.0**30), 2.0**30, width=32)),
    st.integers(0, 40),
)
def test_an_addition_loses_less_than_the_lowest_bit(sums: IntArray, values: SingleArray, shift: int) -> None:
    found = accumulated(sums, values, shift)
    for before, value, after in zip(sums.tolist(), values.tolist(), found.tolist(), strict=True):
        exact = value * 2.0 ** (8 - shift)  # a power of two: exact in float64
        assert abs(after - before) <= abs(exact)
        assert abs((after - before) - exact) < 1.0


@given(arrays(np.float32, 30, elements=st.floats(2.0**-20, 2.0**-16, width=32, exclude_max=True)))
@with_example(np.array([1e-5, 2e-5, 3.9999e-5], dtype=np.float32))
def test_packing_loses_nothing_below_a_factor_of_4_and_one_bit_below_16(rates: SingleArray) -> None:
    kept = float32.packed(rates)
    assert np.all(np.abs(kept.astype(np.float64) / rates - 1.0) <= 2.0**-23)
    assert np.array_equal(float32.packed(kept), kept)
    if rates.max() < 4.0 * rates.min():
        assert np.array_equal(kept, rates)


@pytest.mark.parametrize("example", NAMES)
def test_stored_columns_give_the_boards_words(example: str) -> None:
    for component in lowered(example):
        *rates, steady = float32.column_words(component)
        for column, words in zip(rates, component.rate_words.T, strict=True):
            got = [(column.base + (n << column.shift)) % 2**32 for n in column.stored]
            assert np.array_equal(np.array(got, dtype=np.uint32).view(np.float32), words)
            assert max(column.stored) < 2**24
        got = [(steady.base + (n << steady.shift)) % 2**32 for n in steady.stored]
        assert np.array_equal(np.array(got, dtype=np.uint32).view(np.int32), component.steady)


def test_a_word_that_three_bytes_cannot_hold_is_refused() -> None:
    brush = lowered("my1016")[0]
    with pytest.raises(ValueError, match=r"brush\.S"):
        float32.column_words(replace(brush, steady=brush.steady + 1))


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


@pytest.mark.parametrize("rise_mK", [-41_000, 121_000, 57_123])  # over 30 degC: temperatures of -10..150 degC
def test_start_is_limited_to_the_domain(rise_mK: int) -> None:
    brush = lowered("my1016")[0]
    step = FloatStep(brush)
    rise = step.rise(step.start(np.array([rise_mK])))[0]
    assert rise == pytest.approx(np.clip(rise_mK, -40_000, 120_000) / 1000.0, abs=2e-5)


def test_literals_round_trip() -> None:
    rng = np.random.default_rng(0)
    values = np.concatenate([rng.normal(size=200) * 10.0 ** rng.integers(-20, 20, 200), [0.0, 768.0, 1e8]])
    for value in values.astype(np.float32):
        text = FloatComponent.literal(float(value))
        assert text.endswith("f")
        assert "." in text or "e" in text
        assert np.float32(text[:-1]) == value
