"""The polytopes that a proof hands on: each inequality again, from the directions and heights alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from gen.lowering import float32
from gen.lowering.fixed.lower import lower_component
from gen.lowering.recursion import bounds
from gen.lowering.recursion.dynamics import dynamics
from gen.lowering.recursion.reach import SwitchedRecursion
from tests.examples import example


@pytest.mark.parametrize(("name", "place"), [("my1016", 1), ("two_mass", 0)])
@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
def test_the_state_s_polytope_is_mapped_into_itself(name: str, place: int, arithmetic: str) -> None:
    """By a linear program for every direction and some PWM, whose optimum is the true extent."""
    model = example(name).model
    component = model.components[place]
    fixed = lower_component(model, component, 1e-5)
    lowered = fixed if arithmetic == "fixed" else float32.lower_component(model, component, 1e-3)
    assert lowered.proof is not None
    found = lowered.proof.invariant
    exact = dynamics(model, component, lowered.substeps)
    n = exact.order
    assert found.directions.shape == (len(found.reach), n)
    scale = np.abs(found.directions).max(
        axis=0
    )  # the increments are small: as they are, a solver's tolerance is coarse
    rows = np.vstack([found.directions, -found.directions]) / scale
    for row in (0, 50, 128, 255):
        matrix = exact.exact[row]
        towards = (np.eye(n) - matrix)[:, 0] * (exact.steady[row] - found.centre)
        for j in range(0, len(found.directions), 7):
            image = (found.directions[j] @ matrix) / scale
            best = linprog(-image, A_ub=rows, b_ub=np.tile(found.reach, 2), bounds=(None, None))
            assert best.fun is not None
            moved = -best.fun + abs(found.directions[j] @ towards)
            assert moved <= found.reach[j] * (1.0 + 1e-9)
    for start in exact.start:
        assert np.all(np.abs(found.directions[:, 0] * (start - found.centre)) <= found.reach * (1.0 + 1e-12))
    first = [found.error[j] / abs(c[0]) for j, c in enumerate(found.directions) if not c[1:].any()]
    assert min(first) <= lowered.proof.bound_K


def test_a_carry_s_rounding_before_the_sample_stays_in_the_polytope() -> None:
    """The sample moves it on: added behind the sample it left the polytope by 1e-7 of its size."""
    model = example("two_mass").model
    exact = dynamics(model, model.components[0], 1)
    rounding = np.zeros((len(exact.steady), 2))
    rounding[:, 0] = 1e-7
    from_board = np.asarray(np.linalg.inv(exact.state_maps()), dtype=np.float64)
    found = SwitchedRecursion(exact.exact).bound(bounds.carried_over(exact, from_board, rounding)[:, None, :])
    scale, unit = np.abs(found.directions).max(axis=0), found.height.max() / 1000.0
    rows = np.vstack([found.directions, -found.directions]) / scale
    for row in (0, 128, 255):
        for j in range(0, len(found.height), 2):
            image = found.directions[j] @ exact.exact[row]
            best = linprog(-image / scale, A_ub=rows, b_ub=np.tile(found.height / unit, 2), bounds=(None, None))
            assert best.fun is not None
            moved = -best.fun * unit + abs(image @ from_board[row] @ rounding[row])
            assert moved <= found.height[j] + 1e-9 * found.height.max()
