"""Each disturbance that the bound counts, alone: played at its full size it stays below the bound, and not by far.

In the whole bound a term that were forgotten would hide behind the others, and what is measured would still be below.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.arrays import FloatArray, IntArray
from gen.lowering.fixed import corrected_format, formats
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.lower import lower_component
from gen.lowering.lower import lower
from gen.lowering.recursion import bounds, increments
from gen.lowering.recursion.dynamics import Dynamics, dynamics
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.reference.fixed import FixedStep
from tests.examples import example

LENGTH = 24_000


@dataclass(frozen=True)
class Played:
    """The increment form in float64 beside the exact recursion, for a disturbance of each kind."""

    q: float = 0.0
    chain: tuple[float, ...] = ()
    start: float = 0.0
    coefficients: float = 0.0  # relative, of C0


@cache
def brush() -> tuple[Dynamics, SwitchedRecursion, bounds.StateRanges]:
    model = example("my1016").model
    exact = dynamics(model, model.components[0], 1)
    recursion = SwitchedRecursion(exact.exact)
    return exact, recursion, bounds.state_ranges(recursion, exact)


def worst(played: Played) -> tuple[float, float]:
    """Over lanes that hold a level, or switch between two, with the disturbance always on one side.

    Returns
    -------
    float, float
        Largest |x1 - T|, and largest |y1 - T| of the disturbed copy y of the true state that the board's state maps.
    """
    exact, _, _ = brush()
    n = exact.order
    levels = np.array([(0, 0), (255, 255), (0, 255), (3, 200), (30, 31), (0, 255), (60, 255), (128, 255)] * 3)
    period = np.array([1, 1, 1, 2, 3, 200, 3000, 6000] * 3)
    c = exact.c.copy()
    c[:, 0] *= 1.0 + played.coefficients
    form = increments.transition(c)
    inject = increments.injection(n) * played.q + np.array(played.chain or (0.0,) * n)
    z = np.zeros((len(levels), n))
    z[:, 0] = np.repeat([0.0, *exact.start], len(levels) // 3)
    x = z.copy()
    x[:, 0] += played.start
    before: IntArray | None = None
    largest = of_copy = 0.0
    copies = np.linalg.inv(exact.state_maps())
    for sample in range(LENGTH):
        pwm = levels[np.arange(len(levels)), sample // period % 2]
        away = np.zeros_like(x)
        away[:, 0] = exact.steady[pwm]
        if before is None or np.any(pwm != before):
            old = np.zeros(len(levels)) if before is None else _q(c, exact, x, before)
            x[:, n - 2] += increments.CARRY * (_q(c, exact, x, pwm) - old)
            before = pwm
        x = np.einsum("lij,lj->li", form[pwm], x - away) + away + inject
        z = np.einsum("lij,lj->li", exact.exact[pwm], z - away) + away
        largest = max(largest, float(np.abs(x[:, 0] - z[:, 0]).max()))
        y = np.einsum("lij,lj->li", copies[pwm], x - away) + away
        of_copy = max(of_copy, float(np.abs(y[:, 0] - z[:, 0]).max()))
    return largest, of_copy


def _q(c: FloatArray, exact: Dynamics, x: FloatArray, pwm: IntArray) -> FloatArray:
    away = x.copy()
    away[:, 0] -= exact.steady[pwm]
    found: FloatArray = -np.einsum("lj,lj->l", c[pwm], away)
    return found


CASES = {
    "nothing: the form's own rest": (Played(), 4.0),
    "rounding of q": (Played(q=2e-13), 3.0),
    "rounding of x1": (Played(chain=(1e-7, 0.0, 0.0)), 3.0),
    "rounding of x2": (Played(chain=(0.0, 1e-10, 0.0)), 3.0),
    "rounding of x3": (Played(chain=(0.0, 0.0, 1e-13)), 3.0),
    "rounding of the start": (Played(start=1e-3), 2.0),
    "roundings of like effect together": (Played(q=1e-13, chain=(5e-7, 1.4e-10, 1e-13)), 3.0),
    "rounded coefficients": (Played(coefficients=1e-5), 6.0),
}


@pytest.mark.parametrize("name", CASES)
def test_a_disturbance_alone_stays_below_what_the_bound_counts_for_it(name: str) -> None:
    played, slack = CASES[name]
    exact, recursion, ranges = brush()
    rows = len(exact.steady)
    changed = np.zeros_like(exact.c)
    changed[:, 0] = exact.c[:, 0] * played.coefficients
    bound = bounds.worst_error(
        recursion,
        exact,
        ranges,
        changed_c=changed,
        q_error=np.full(rows, played.q),
        chain_error=np.tile(played.chain or (0.0,) * exact.order, (rows, 1)),
        start_error=played.start,
    )
    assert bound is not None
    found, _ = worst(played)
    print(f"\n{name}: {found:.3g} K found, {bound.bound_K:.3g} K bound")
    assert found <= bound.bound_K
    assert bound.bound_K < slack * found


def test_of_one_pole_an_error_in_q_adds_up_as_a_geometric_series() -> None:
    """x' = (1 - C0) x + e ends at e / C0, the worst where C0 is least; nothing else hides it."""
    model = example("my1016").model
    exact = dynamics(model, model.component("bearing"), 1)
    recursion = SwitchedRecursion(exact.exact)
    ranges = bounds.state_ranges(recursion, exact)
    none, e = np.zeros_like(exact.c), 1e-8
    with_it, without = (
        bounds.worst_error(
            recursion, exact, ranges, changed_c=none, q_error=none[:, 0] + q, chain_error=none, start_error=0.0
        ).bound_K
        for q in (e, 0.0)
    )
    assert with_it - without == pytest.approx(e / exact.c.min(), rel=0.01)


def test_the_form_s_own_rest_is_counted_beside_how_x1_differs_from_the_rise() -> None:
    """The second is much the larger: alone it would cover both here, but not for every model."""
    exact, recursion, ranges = brush()
    zero = np.zeros_like(exact.c)
    bound = bounds.worst_error(
        recursion, exact, ranges, changed_c=zero, q_error=zero[:, 0], chain_error=zero, start_error=0.0
    )
    differs = np.abs(exact.state_maps()[:, 0, :] - np.eye(exact.order)[0])
    of_x1 = float(np.einsum("pj,pj->p", differs, ranges.true_distance).max())
    _, of_copy = worst(Played())
    assert bound is not None
    assert 1e-10 < of_copy < bound.bound_K - of_x1


@cache
def in_words() -> tuple[FixedComponent, ...]:
    """Orders 1 to 4 in the carried form, and order 3 in the corrected one."""
    my1016, two_mass = example("my1016"), example("two_mass")
    carried = lower_component(my1016.model, my1016.model.components[0], 1e-5)
    found = [carried, *lower(my1016, "fixed", "table").components[:2], *lower(two_mass, "fixed", "table").components]
    return tuple(component for component in found if isinstance(component, FixedComponent))


SHARE = st.fractions(-1, 1, max_denominator=1 << 44)


@settings(max_examples=400, deadline=None)
@given(place=st.integers(0, 4), row=st.integers(0, 255), shares=st.tuples(*[SHARE] * 4), between=st.fractions(0, 1))
def test_q_in_words_is_as_close_to_the_exact_one_as_the_bound_counts(
    place: int, row: int, shares: tuple[Fraction, ...], between: Fraction
) -> None:
    """Against rational arithmetic, wherever the true steady rise lies within the last bit of S."""
    component = in_words()[place]
    layout, proof = component.layout, component.proof
    assert proof is not None
    largest = [max(map(abs, proof.rise_range_K)), *proof.increment_range_K]
    state = [int(s * Fraction(m) * 2**f) for s, m, f in zip(shares, largest, layout.fraction_bits, strict=False)]
    integers = [int(rate) for rate in component.rates[row]]
    rates = [Fraction(rate, 1 << bits) for rate, bits in zip(integers, layout.rate_fraction_bits, strict=True)]
    board_rates = component.rates * 2.0 ** -np.array(layout.rate_fraction_bits)
    unit, steady = Fraction(layout.high_lsb[0]), int(component.steady[row])
    if layout.corrected:  # S to nearest, with the middle of what is lost taken off
        rounding = corrected_format.rounding(layout, board_rates, component.rates)
        true, counted = (steady + between - Fraction(1, 2)) * unit + Fraction(rounding.steady[row]), rounding.q[row]
    else:  # S rounded down
        true, counted = (steady + between) * unit, formats.rounding(layout, board_rates)[0][row]
    value = Fraction(0)
    for i, (word, bits) in enumerate(zip(state, layout.fraction_bits, strict=True)):
        x = Fraction(word, 1 << bits)
        value = x - true if i == 0 else x + rates[i - 1] * value
    wanted = -rates[-1] * value
    found = Fraction(FixedStep(component).increment(state, integers, steady), 1 << layout.fraction_bits[-1])
    assert abs(found - wanted) <= Fraction(float(counted) * (1.0 + 1e-9))


@pytest.mark.parametrize(("name", "place"), [("my1016", 0), ("my1016", 1), ("two_mass", 0), ("two_mass", 1)])
def test_what_a_sum_grows_by_at_a_change_of_pwm_goes_on_times_its_rate(
    name: str, place: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """x[n-1] takes over its share of q late: the sum there is off by that, and the next one by R[n-2] times that."""
    model = example(name).model
    component = model.components[place]
    exact = dynamics(model, component, 1)
    recursion, n = SwitchedRecursion(exact.exact), exact.order
    with_carry = bounds.inner_ranges(recursion, exact)
    monkeypatch.setattr(increments, "CARRY", 0.0)
    without = bounds.inner_ranges(recursion, exact)
    sums, products = with_carry.sums - without.sums, with_carry.products - without.products
    if n == 1:
        assert not sums.any()
        assert not products.any()
        return
    assert sums[n - 2] > 0.0
    onward = float(exact.rates[:, n - 2].max()) * sums[n - 2]
    assert [sums[n - 1], products[n - 1]] == pytest.approx([onward, onward], rel=1e-6)
    assert not products[: n - 1].any()
