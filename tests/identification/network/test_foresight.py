"""The error of a forecast in a range of PWM is that of the bins at that PWM, and of no other."""

from __future__ import annotations

import numpy as np
import pytest

from gen.identification.network.telling.foresight import Foresight

ALONG = Foresight(
    pwm=np.array([0.0, 100.0, 100.0, 200.0]),
    rest=np.array([1.0, 0.0, 0.2, 0.0]),
    deviation=np.array([[7.0], [3.0], [4.0], [1.0]]),
)
"""At rest 7 K, at PWM 100 3 K and 4 K, at 200 1 K."""


@pytest.mark.parametrize(
    ("low", "high", "expected_K"),
    [(0, 0, 7.0), (1, 120, np.sqrt(12.5)), (200, 255, 1.0), (100, 200, np.sqrt(26 / 3))],
)
def test_a_range_has_the_root_mean_square_of_its_own_bins(low: int, high: int, expected_K: float) -> None:
    assert ALONG.within(low, high) == pytest.approx([expected_K])


def test_a_range_that_the_profile_leaves_out_has_all_of_it() -> None:
    assert ALONG.within(210, 255) == pytest.approx([np.sqrt(75 / 4)])
