"""The invariant polytope against closed forms and against adversaries."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.lowering.recursion.dynamics import dynamics
from gen.lowering.recursion.fan import Fan
from gen.lowering.recursion.no_proof import NoProofError
from gen.lowering.recursion.reach import SwitchedRecursion
from tests.examples import example


def test_order_one_has_a_closed_form() -> None:
    rates = np.array([1e-5, 2e-4, 1e-3])
    recursion = SwitchedRecursion((1.0 - rates)[:, None, None])
    found = recursion.bound(rates[:, None, None] * 7.0)
    assert found.extent(np.ones(1)) == pytest.approx(7.0, rel=1e-4)
    assert found.extent(np.ones(1)) >= 7.0
    started = recursion.bound(rates[:, None, None] * 7.0, start=np.array([[20.0]]))
    assert started.extent(np.ones(1)) == pytest.approx(20.0, rel=1e-4)


def test_the_brush_s_gain_encloses_an_adversary_closely() -> None:
    """An adversary that only chooses the sign of the drive, at the PWM that suits it best: a lower bound."""
    model = example("my1016").model
    exact = dynamics(model, model.component("brush"), 1)
    towards = (np.eye(3) - exact.exact)[:, :, 0]
    bound = SwitchedRecursion(exact.exact).bound(towards[:, None, :]).extent(np.eye(3)[0])
    costate = np.tile(np.eye(3)[0], (len(towards), 1))
    total = np.zeros(len(towards))
    for _ in range(40_000):
        total += np.abs((costate * towards).sum(axis=1))
        costate = np.einsum("pij,pi->pj", exact.exact, costate)
    assert 0.99 < total.max() <= bound < 2.0 * total.max()


def test_unstable_switching_has_no_proof() -> None:
    """Each matrix turns and shrinks, but switching in the right moments grows: the textbook example."""
    step = 1e-3
    one = np.array([[-0.1, 1.0], [-9.0, -0.1]])
    other = np.array([[-0.1, 9.0], [-1.0, -0.1]])
    with pytest.raises(NoProofError):
        recursion = SwitchedRecursion(np.array([np.eye(2) + step * one, np.eye(2) + step * other]))
        recursion.bound(np.full((2, 1, 2), step))


def test_an_extent_is_convex_and_symmetric() -> None:
    model = example("my1016").model
    exact = dynamics(model, model.component("brush"), 1)
    found = SwitchedRecursion(exact.exact).bound(np.tile(np.diag([1e-6, 1e-9, 1e-12]), (256, 1, 1)))
    for direction in np.random.default_rng(2).normal(size=(20, 3)):
        scaled = direction / np.array([1.0, 1e-4, 1e-7])
        assert found.extent(scaled) == pytest.approx(found.extent(-scaled))
        assert found.extent(2.0 * scaled) == pytest.approx(2.0 * found.extent(scaled))


@pytest.mark.parametrize("short", [1e-12, 1e-9, 1e-7])
def test_weights_that_leave_something_of_an_image_do_not_make_the_bound_smaller(
    short: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As rounding may; here all of them are too small, in the inequalities and in the extents."""
    usual = Fan.of

    def planted(order: int, shape: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Fan:
        fan = usual(order, shape)
        return replace(fan, inverse=fan.inverse * (1.0 - short))

    monkeypatch.setattr(Fan, "of", planted)
    rates = np.array([1e-5, 2e-4, 1e-3])
    recursion = SwitchedRecursion((1.0 - rates)[:, None, None])
    try:
        found = recursion.bound(rates[:, None, None] * 7.0)
    except NoProofError:
        assert short > 1e-9
        return
    assert found.extent(np.ones(1)) >= 7.0
