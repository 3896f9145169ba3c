"""Proven ranges and bounds against what happens."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.lowering.fixed import lower_component
from gen.lowering.formats import CARRY_FACTOR, START_UNITS, carry_error, dropped_error
from gen.lowering.lower import Program, lower
from gen.lowering.program import FixedComponent, rounded_up
from gen.model.exact import ExactSolution
from gen.reference.fixed import FixedStep, product
from gen.reference.model import ReferenceModel
from gen.verify.accuracy import error_course
from gen.verify.profiles import campaign
from tests.verify_helpers import EXAMPLES, example


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
def test_three_hours_of_any_profile_stay_within_1e_5_K_and_within_the_proof(name: str) -> None:
    program = fixed(name)
    worst = error_course(program, lanes=6).largest()
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


@given(st.floats(1e-12, 1e6))
def test_rounded_up_is_never_below(value: float) -> None:
    assert value <= rounded_up(value) * (1.0 + 1e-8) <= value * 1.11


def test_the_bound_is_not_vacuous() -> None:
    """Within a factor of fifty of what is measured: a bound of kelvins would prove nothing."""
    component = fixed("my1016").components[0]
    assert component.proof is not None
    assert component.proof.bound_K < 50.0 * error_course(fixed("my1016"), lanes=6).largest()["brush"]


@settings(max_examples=200, deadline=None)
@given(place=st.integers(0, 3), rise_mK=st.integers(-60_000, 160_000))
def test_a_start_value_is_as_close_as_the_proof_assumes(place: int, rise_mK: int) -> None:
    component = fixed("my1016").components[place]
    assert isinstance(component, FixedComponent)
    layout = component.layout
    word = FixedStep(component).start(rise_mK)[0]
    difference = Fraction(word, 1 << layout.fraction_bits[0]) - Fraction(rise_mK, 1000)
    assert abs(difference) <= START_UNITS * Fraction(layout.high_lsb[0])
    if rise_mK >= 0 and rise_mK % 125 == 0:
        assert difference == 0


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
    layout, n = component.layout, component.order
    largest = 1 << (29 + 8 * layout.carry_byte)  # the change of a q within it fits 32 bits
    old, new = int(before * largest), int(after * largest)
    words = [0] * n
    words[n - 2] = state
    FixedStep(component).carry(words, old, new)
    moved = Fraction(words[n - 2] - state, 1 << layout.fraction_bits[-2])
    wanted = Fraction(new - old, 1 << layout.fraction_bits[-1]) * Fraction(CARRY_FACTOR, 1 << 16)
    assert abs(moved - wanted) <= Fraction(carry_error(layout, 0.0))
    assert all(word == 0 for i, word in enumerate(words) if i != n - 2)
