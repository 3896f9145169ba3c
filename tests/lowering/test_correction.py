"""The corrected form: its poles, what a change of PWM does to it, and the rounding of its small term."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.lowering.fixed import corrected_format, correction, proof
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.correction import Correction
from gen.lowering.fixed.formats import nested_ranges
from gen.lowering.lower import lower
from gen.lowering.recursion import bounds
from gen.lowering.recursion.dynamics import Dynamics, dynamics
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.reference.fixed import FixedStep, product
from tests.examples import example

NAMES = ("my1016", "my1016_averaged")


@cache
def brush(name: str) -> FixedComponent:
    component = lower(example(name), "fixed", "table").components[0]
    assert isinstance(component, FixedComponent)
    assert component.layout.corrected
    return component


@cache
def tables(name: str) -> tuple[Dynamics, Dynamics]:
    """Exact tables of the carried and of the corrected form."""
    model = example(name).model
    exact = dynamics(model, model.components[0], 1)
    return exact, correction.corrected(exact, Correction.of(brush(name).layout, brush(name).rates))


@pytest.mark.parametrize("name", NAMES)
def test_its_poles_are_those_of_the_differential_equation(name: str) -> None:
    exact, form = tables(name)
    for row in (0, 1, 51, 137, 255):
        wanted = np.poly(exact.exact[row] - np.eye(3))
        np.testing.assert_allclose(np.poly(form.form[row] - np.eye(3)), wanted, rtol=0, atol=3e-16)


@pytest.mark.parametrize("name", NAMES)
def test_without_rounding_it_follows_any_changes_of_pwm(name: str) -> None:
    exact, form = tables(name)
    rng = np.random.default_rng(4)
    assert form.constant_map is not None
    true, board = np.zeros(3), np.zeros(3)
    plain, worst, worst_plain = np.zeros(3), 0.0, 0.0
    row = 0
    for step in range(20_000):
        if step % 400 < 200 or step % 50 == 0:  # every sample for a while, then held
            row = int(rng.integers(0, 256))
        settled = np.array([exact.steady[row], 0.0, 0.0])
        true = exact.exact[row] @ (true - settled) + settled
        board = form.form[row] @ (board - settled) + settled
        plain = exact.form[row] @ (plain - settled) + settled  # without anything handed over
        worst = max(worst, abs(board[0] - true[0]))
        worst_plain = max(worst_plain, abs(plain[0] - true[0]))
    component = brush(name)
    assert component.proof is not None
    assert worst < 0.5 * component.proof.bound_K
    assert worst < worst_plain


@settings(max_examples=300, deadline=None)
@given(
    name=st.sampled_from(NAMES),
    row=st.integers(0, 255),
    x2=st.fractions(-1, 1, max_denominator=1 << 40),
    x3=st.fractions(-1, 1, max_denominator=1 << 40),
    inner=st.fractions(-1, 1, max_denominator=1 << 31),
)
def test_its_small_term_is_as_close_as_the_proof_assumes(
    name: str, row: int, x2: Fraction, x3: Fraction, inner: Fraction
) -> None:
    component = brush(name)
    assert component.proof is not None
    layout, magnitude = component.layout, component.proof.increment_range_K
    rates = [int(rate) for rate in component.rates[row]]
    units = [2.0**bits for bits in layout.fraction_bits]
    state = [0, int(x2 * Fraction(magnitude[0] * units[1])), int(x3 * Fraction(magnitude[1] * units[2]))]
    # q is a product with R2, of something as large as x3 can be.
    q = -product(int(inner * Fraction(magnitude[1] / layout.high_lsb[2])), rates[2], 24, wide=True)
    moved = list(state)
    FixedStep(component).advance(moved, rates, q)
    last = moved[2]
    assert last == state[2] + q
    found = (moved[1] - state[1] - (last >> layout.chain_shifts[1])) / units[1]
    factors = Correction.of(layout, component.rates)
    wanted = factors.on_x2[row] * state[1] / units[1] + factors.on_x3[row] * state[2] / units[2]
    wanted += factors.on_q[row] * q / units[2]
    board_rates = component.rates * 2.0 ** -np.array(layout.rate_fraction_bits)
    rounding = corrected_format.rounding(layout, board_rates, component.rates)
    assert abs(found - wanted) <= rounding.chain[row, 1]


def test_a_sum_s_own_direction_is_narrower_than_its_terms_together() -> None:
    exact, _ = tables("my1016")
    recursion = SwitchedRecursion(exact.exact)
    ranges = bounds.state_ranges(recursion, exact)
    inner = bounds.inner_ranges(recursion, exact).sums
    together = nested_ranges(ranges, exact.rates)
    assert np.all(inner[1:] <= together[1:])  # x1 - S has one term
    assert inner[1] < 0.6 * together[1]
    # And it holds: a random sequence stays within.
    rng = np.random.default_rng(8)
    state, largest = np.zeros(3), np.zeros(3)
    for _ in range(20_000):
        row = int(rng.choice([0, 255, int(rng.integers(0, 256))]))
        for _ in range(int(rng.integers(1, 3))):
            settled = np.array([exact.steady[row], 0.0, 0.0])
            value = 0.0
            for i, x in enumerate(state - settled):
                value = x + (exact.rates[row, i - 1] * value if i else 0.0)
                largest[i] = max(largest[i], abs(value))
            state = exact.exact[row] @ (state - settled) + settled
    assert np.all(largest < inner)


@pytest.mark.parametrize("off", [0, 1 << 12, 1 << 20])
def test_sums_of_integer_rates_stay_within_what_is_counted_beside_those_of_exact_ones(off: int) -> None:
    component = brush("my1016")
    exact, form = tables("my1016")
    ranges = bounds.state_ranges(SwitchedRecursion(exact.exact), form)
    rates = (component.rates + off) * 2.0 ** -np.array(component.layout.rate_fraction_bits)
    counted = proof._changed_sums(ranges, form, rates)
    signs = np.array([[1, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1]])
    for row in (0, 60, 255):
        for away in signs * ranges.distance[row]:
            exactly, found = 0.0, 0.0
            for i in range(3):
                exactly = away[i] + (form.rates[row, i - 1] * exactly if i else 0.0)
                found = away[i] + (rates[row, i - 1] * found if i else 0.0)
                assert abs(found - exactly) <= counted[i] * (1.0 + 1e-12) + 1e-15 * abs(exactly)


def test_words_that_rates_far_off_overfill_have_no_proof() -> None:
    """The corrected form's own check: rates of twice the size, in formats chosen for the right ones."""
    component = brush("my1016")
    exact, _ = tables("my1016")
    with pytest.raises(NoProofError):
        proof.prove_corrected(
            SwitchedRecursion(exact.exact), exact, component.layout, component.rates * 2, component.steady
        )
