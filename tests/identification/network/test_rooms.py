"""What rooms that nobody measured have in common, against the joint Gaussian of rooms and level written out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np

from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.fitting.rooms import level_of, places_of, share_level, unsure_K

DEVIATION_K = 4.0
PLACES = np.array([1, 2, 4])


def spread(seed: int, size: int) -> np.ndarray:
    """A covariance."""
    root = np.random.default_rng(seed).normal(0.0, 1.0, (size, size))
    return np.asarray(root @ root.T + np.eye(size))


def test_rooms_of_one_level_vary_together() -> None:
    own = np.linalg.inv(spread(1, 3))
    precision = np.diag([7.0, 0.0, 0.0, 9.0, 0.0])
    precision[np.ix_(PLACES, PLACES)] = own
    share_level(precision, PLACES, DEVIATION_K)
    expected = np.linalg.inv(own) + DEVIATION_K**2
    np.testing.assert_allclose(np.linalg.inv(precision)[np.ix_(PLACES, PLACES)], expected, rtol=1e-9)
    assert (precision[0, 0], precision[3, 3]) == (7.0, 9.0)


def test_the_level_is_what_the_rooms_say_of_it_by_bayes_rule() -> None:
    rooms = spread(2, 3) + DEVIATION_K**2
    precision = np.zeros((5, 5))
    precision[np.ix_(PLACES, PLACES)] = np.linalg.inv(rooms)
    vector, known = np.array([5.0, 2.0, 3.5, 5.0, 2.5]), 0.1 * spread(3, 5)
    told = DEVIATION_K**2 * np.ones(3) @ np.linalg.inv(rooms)  # of the level, for each kelvin of a room
    level, deviation = level_of(precision, PLACES, DEVIATION_K, vector, known)
    assert np.isclose(level, told @ vector[PLACES])
    left = DEVIATION_K**2 * (1.0 - told.sum()) + told @ known[np.ix_(PLACES, PLACES)] @ told
    assert np.isclose(deviation, np.sqrt(left))


def test_only_rooms_that_nobody_noted_are_unsure() -> None:
    runs = [SimpleNamespace(room_K=0.0), SimpleNamespace(room_K=3.0), SimpleNamespace(room_K=2.0)]
    inputs = cast(Inputs, SimpleNamespace(room=np.zeros((10, 2)), runs=runs))
    assert unsure_K(inputs) == 3.0
    # Ten parameters for all runs; then of each run three starts and two hats.
    assert places_of(inputs, 10, 3).tolist() == [18, 19, 23, 24]
