"""What rooms that nobody measured have in common, against the joint Gaussian of rooms and level written out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np

from gen.identification.network.fitting.bins import binned
from gen.identification.network.fitting.inputs import Inputs, inputs_of
from gen.identification.network.fitting.priors import ROOM_STEP_K, prior_of
from gen.identification.network.fitting.rooms import level_of, places_of, share_level, unsure_K
from gen.identification.network.fitting.scale import scale_of
from gen.identification.network.fitting.structure import full
from gen.runs import Run

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


def test_a_room_moves_by_as_much_in_ten_minutes_whatever_other_runs_are_there() -> None:
    """Half a kelvin in an hour, as a random walk: a fifth of one in ten minutes, beside a run of twelve hours, too."""
    runs = []
    for hours in (1.0 / 6.0, 12.0):
        time = np.arange(0.0, 3600.0 * hours, 5.0)
        warm = np.asarray(22.0 + 30.0 * (1.0 - np.exp(-time / 1200.0)))
        run = Run(time, np.where(time < time[-1] / 2.0, 200, 0).astype(np.int64), {"part": warm})
        runs.append(binned(f"{hours:.2f} h", run, ["part"], 22.0, 255, room_K=3.0))
    inputs = inputs_of(runs)
    structure = full(("part",), 0)
    covariance = np.linalg.inv(prior_of(structure, inputs, scale_of(inputs)).precision)
    hats = inputs.room.shape[-1]
    first = structure.size + structure.nodes
    ends = np.array([first, first + hats - 1])
    difference = covariance[ends[0], ends[0]] + covariance[ends[1], ends[1]] - 2.0 * covariance[ends[0], ends[1]]
    assert 0.5 * ROOM_STEP_K / np.sqrt(6.0) < np.sqrt(difference) < 1.01 * ROOM_STEP_K / np.sqrt(6.0)
