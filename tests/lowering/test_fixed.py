"""Proven ranges and bounds against what happens."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.arrays import IntArray
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.formats import CARRY_FACTOR, Format, carry_error, dropped_error, steady_excess
from gen.lowering.fixed.lower import lower_component
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.lowering.recursion import bounds
from gen.lowering.recursion.dynamics import dynamics
from gen.lowering.recursion.guarantee import rounded_up
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.model.exact import ExactSolution
from gen.reference.fixed import FixedStep, Word, product
from gen.reference.model import ReferenceModel
from gen.verification.accuracy import LENGTH, error_course
from gen.verification.profiles import campaign
from tests.examples import EXAMPLES, example


@cache
def fixed(name: str) -> Program:
    return lower(example(name), "fixed", "table")


@cache
def carried_brushes() -> tuple[FixedComponent, ...]:
    """The order-3 components as a schedule on board needs them."""
    models = [example(name).model for name in ("my1016", "my1016_averaged")]
    return tuple(lower_component(model, model.components[0], 1e-5) for model in models)


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_component_is_proven_within_the_file_s_limit(name: str) -> None:
    for component in fixed(name).components:
        assert component.proof is not None
        assert component.proof.bound_K <= example(name).accuracy.fixed_limit_K == 1e-5


@pytest.mark.parametrize("name", EXAMPLES)
def test_hours_of_any_profile_stay_within_1e_5_K_and_within_the_proof(name: str) -> None:
    """Three of the first example, one of each other."""
    program = fixed(name)
    worst = error_course(program, lanes=6, length=LENGTH if name == EXAMPLES[0] else LENGTH // 3).largest()
    for component in program.components:
        assert component.proof is not None
        assert worst[component.name] < 1e-5
        assert worst[component.name] < component.proof.bound_K


def test_no_state_leaves_its_proven_range() -> None:
    program = fixed("my1016")
    profile = campaign(program.model, lanes=24, length=6000, seed=3)
    model = ReferenceModel(program, [int(value) for value in profile.start_mK])
    low = np.full(len(program.components), np.inf)
    high = -low
    for step in range(6000):
        model.step(profile.pwm[:, step])
        low, high = np.minimum(low, model.rises.min(axis=1)), np.maximum(high, model.rises.max(axis=1))
    for index, component in enumerate(program.components):
        assert component.proof is not None
        assert component.proof.rise_range_K[0] <= low[index] < high[index] <= component.proof.rise_range_K[1]


class WatchedStep(FixedStep):
    """Notes the largest word of every kind on the way to q, as parts of its 32 bits."""

    def __init__(self, component: FixedComponent) -> None:
        super().__init__(component)
        self.sums = np.zeros(component.order)
        self.products = np.zeros(component.order)
        self.change = 0.0

    def increment(self, state: list[Word], rates: list[Word], steady: Word) -> Word:
        layout = self._component.layout
        inner = (state[0] >> 16) - steady
        for i, shift in enumerate(layout.product_shifts):
            self.sums[i] = max(self.sums[i], np.abs(inner).max() / 2.0**31)
            if i + 1 < layout.order:
                part = product(inner, rates[i], shift, wide=False)
                self.products[i + 1] = max(self.products[i + 1], np.abs(part).max() / 2.0**31)
                inner = (state[i + 1] >> 16) + part + 1
        return super().increment(state, rates, steady)

    def carry(self, state: list[Word], old: Word, new: Word) -> None:
        cut = 8 * self._component.layout.carry_byte
        self.change = max(self.change, np.abs((old >> cut) - (new >> cut)).max() / 2.0**31)
        super().carry(state, old, new)


@pytest.mark.parametrize(("name", "place"), [("my1016", 0), ("two_mass", 0)])
def test_no_word_on_the_way_to_q_leaves_its_range_whatever_the_pwm_does(name: str, place: int) -> None:
    model = example(name).model
    component = lower_component(model, model.components[place], 1e-5)
    exact = dynamics(model, model.components[place], component.substeps)
    ranges = bounds.inner_ranges(SwitchedRecursion(exact.exact), exact)
    step, lanes, length = WatchedStep(component), 30, 2000
    random = np.random.default_rng(17)
    levels = np.sort(random.choice([0, 1, 50, 120, 180, 254, 255], (2, lanes)), axis=0)
    period = np.exp(random.uniform(0.0, np.log(length), lanes)).astype(int)
    starts = random.choice(component.start_range_mK, lanes)
    state = [np.array(words) for words in zip(*map(step.start, starts.tolist()), strict=True)]
    rates: list[IntArray] = []
    steady = np.zeros(0, dtype=np.int64)
    before = levels[0] - 1
    for sample in range(length):
        pwm = np.where(sample // period % 2 == 0, *levels)
        if np.any(pwm != before):
            old = step.increment(state, rates, steady) if sample else np.zeros(lanes, dtype=np.int64)
            rates, steady = list(component.rates[pwm].T), component.steady[pwm]
            step.carry(state, old, step.increment(state, rates, steady))
            before = pwm
        for _ in range(component.substeps):
            step.advance(state, rates, step.increment(state, rates, steady))
    words = 2.0**31 * np.array(component.layout.high_lsb)
    assert np.all(step.sums * words < ranges.sums)
    assert np.all(step.products * words <= ranges.products)
    assert max(step.sums.max(), step.products.max(), step.change) < 1.0
    assert np.all(step.sums * words > 0.2 * ranges.sums)  # the ranges are not empty words


def test_an_adversary_stays_below_the_bound() -> None:
    """Lanes that switch when the error's own sign says that it would hurt most."""
    program = fixed("my1016")
    model = program.model
    random = np.random.default_rng(11)
    candidates = 24
    length = 12_000
    levels = np.sort(random.integers(0, 256, (candidates, 2)), axis=1)
    period = random.integers(1, 1500, candidates)
    phase = np.arange(length)[None, :] // period[:, None] % 2
    pwm = np.where(phase == 0, levels[:, :1], levels[:, 1:])
    exact = ExactSolution(model).simulate(pwm)
    reference = ReferenceModel(program, [0] * candidates)
    worst = dict.fromkeys(model.component_names, 0.0)
    for step in range(length):
        reference.step(pwm[:, step])
        for index, name in enumerate(model.component_names):
            error = float(np.abs(reference.rises[index] - exact[name][:, step + 1]).max())
            worst[name] = max(worst[name], error)
    for component in program.components:
        assert component.proof is not None
        assert worst[component.name] < component.proof.bound_K


@settings(max_examples=300, deadline=None)
@given(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**32 - 1), st.sampled_from([16, 24, 32]), st.booleans())
def test_the_truncated_product_is_close_below_the_exact_one(d: int, rate: int, shift: int, wide: bool) -> None:
    exact = d * rate / 2**shift
    found = product(d, rate, shift, wide=wide)
    assert exact - 1.0 - dropped_error(shift, wide=wide) <= found <= exact


@pytest.mark.parametrize(
    ("off", "beyond"), [(-3.0, 2.0), (-1.5, 0.5), (-1.0, 0.0), (-0.5, 0.0), (0.0, 0.0), (0.25, 0.25), (2.0, 2.0)]
)
def test_a_steady_word_may_lie_up_to_one_unit_below_its_rise_and_not_above(off: float, beyond: float) -> None:
    """Rounding down leaves it in [-1, 0] of the exact one; what lies further is counted, on either side."""
    layout = Format(fraction_bits=(36,), product_shifts=(24,), rate_fraction_bits=(40,))
    steady = np.array([-700, 0, 4000])
    exact = (steady - off) * 2.0**-20  # of 36 bits after the point 16 lie below the high word
    np.testing.assert_allclose(steady_excess(steady, exact, layout), beyond, rtol=0, atol=1e-9)


@given(st.floats(1e-12, 1e6))
def test_rounded_up_is_never_below(value: float) -> None:
    assert value <= rounded_up(value) * (1.0 + 1e-8) <= value * 1.11


def test_the_bound_is_not_vacuous() -> None:
    """Within a factor of fifty of what is measured: a bound of kelvins would prove nothing."""
    component = fixed("my1016").components[0]
    assert component.proof is not None
    assert component.proof.bound_K < 50.0 * error_course(fixed("my1016"), lanes=6).largest()["brush"]


@settings(max_examples=300, deadline=None)
@given(
    place=st.integers(0, 3),
    before=st.fractions(-1, 1, max_denominator=1 << 40),
    after=st.fractions(-1, 1, max_denominator=1 << 40),
    state=st.integers(-(1 << 40), 1 << 40),
)
def test_a_carry_is_a_twelfth_within_its_bound(place: int, before: Fraction, after: Fraction, state: int) -> None:
    onboard = [*fixed("two_mass").components, *carried_brushes()]
    component = onboard[place]
    assert isinstance(component, FixedComponent)
    assert component.carries
    largest = 1 << (29 + 8 * component.layout.carry_byte)  # the change of a q within it fits 32 bits
    off = carried_wrongly(component, int(before * largest), int(after * largest), state)
    assert off <= Fraction(carry_error(component.layout, 0.0))


@pytest.mark.parametrize("shift", range(8, 16))
def test_a_carry_is_within_its_bound_whatever_the_shift_between_two_words(shift: int) -> None:
    """The examples' shifts lie at 9 to 11 bits, of which the last 1 to 3 cut off little."""
    component = carried_brushes()[0]
    bits = component.layout.fraction_bits
    layout = replace(component.layout, fraction_bits=(*bits[:-1], bits[-2] + shift))
    largest = 1 << (29 + 8 * layout.carry_byte)
    pairs = np.random.default_rng(shift).integers(-largest, largest, (300, 2)).tolist()
    worst = max(carried_wrongly(replace(component, layout=layout), old, new, 0) for old, new in pairs)
    bound = Fraction(carry_error(layout, 0.0))
    assert bound / 4 < worst <= bound


def carried_wrongly(component: FixedComponent, old: int, new: int, state: int) -> Fraction:
    """By how many kelvins what a change of q carries over is no twelfth of it; no other word moves."""
    layout, n = component.layout, component.order
    words = [0] * n
    words[n - 2] = state
    FixedStep(component).carry(words, old, new)
    assert all(word == 0 for i, word in enumerate(words) if i != n - 2)
    moved = Fraction(words[n - 2] - state, 1 << layout.fraction_bits[-2])
    return abs(moved - Fraction(new - old, 1 << layout.fraction_bits[-1]) * Fraction(CARRY_FACTOR, 1 << 16))
