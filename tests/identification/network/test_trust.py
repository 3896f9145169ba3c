"""Steps within a radius: against what a minimum within it has to be."""

from __future__ import annotations

import numpy as np
import pytest

from gen.identification.network.fitting.fit import Trust


def _drawn(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normal equations with up to a million between the largest and the smallest curvature."""
    rng = np.random.default_rng(seed)
    turned, _ = np.linalg.qr(rng.normal(size=(12, 12)))
    matrix = turned @ np.diag(10.0 ** rng.uniform(-2.0, 4.0, 12)) @ turned.T
    return (
        0.5 * (matrix + matrix.T),
        rng.normal(size=12) * 10.0 ** rng.uniform(-2.0, 4.0),
        10.0 ** rng.uniform(-1, 1, 12),
    )


@pytest.mark.parametrize("seed", range(40))
def test_a_step_is_the_minimum_of_its_length(seed: int) -> None:
    matrix, right, deviation = _drawn(seed)
    whole = np.linalg.solve(matrix, right)
    longest = float(np.max(np.abs(whole / deviation)))
    for share in (1e-4, 0.03, 0.9, 1.1):
        radius = share * longest
        step = Trust(matrix, right, deviation).step(radius)
        if share > 1.0:
            np.testing.assert_allclose(step, whole, rtol=1e-6)
            continue
        assert float(np.max(np.abs(step / deviation))) == pytest.approx(radius, rel=5e-3)
        # Stationary with a multiplier: what is left of the gradient points against the step, in the prior's units.
        left = (right - matrix @ step) * deviation
        damping = left @ (step / deviation) / ((step / deviation) @ (step / deviation))
        assert damping > 0.0
        np.testing.assert_allclose(left, damping * step / deviation, rtol=1e-4, atol=1e-5 * np.abs(left).max())


def test_no_radius_is_no_step() -> None:
    matrix, right, deviation = _drawn(0)
    assert np.max(np.abs(Trust(matrix, right, deviation).step(0.0) / deviation)) < 1e-9
