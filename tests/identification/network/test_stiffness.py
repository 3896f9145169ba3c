"""Paths faster than the board: as fast as it follows, and no slower."""

from __future__ import annotations

import numpy as np
import pytest

from gen.identification.network.telling.stiffness import slowed


@pytest.mark.parametrize("given", [1e12, 300.0, 0.2])
def test_two_nodes_come_together_no_faster_than_asked(given: float) -> None:
    """The rate is the eigenvalue of the two by themselves that is not 0."""
    capacity, least_s = np.array([40.0, 900.0]), 5.0
    ((found,),) = slowed(np.array([[given]]), [(0, 1)], capacity, least_s)
    flow = found * np.array([[-1.0, 1.0], [1.0, -1.0]])
    rate = -np.linalg.eigvals(flow / capacity[:, None]).real.min()
    assert rate == pytest.approx(min(1.0 / least_s, given * (1.0 / 40.0 + 1.0 / 900.0)))


def test_a_node_follows_the_ambient_no_faster_and_each_speed_has_its_own() -> None:
    found = slowed(np.array([[1.0, 1e12], [1e9, 3.0]]), [(0, -1), (1, -1)], np.array([50.0, 200.0]), 5.0)
    np.testing.assert_allclose(found, [[1.0, 40.0], [10.0, 3.0]])
