"""A temperature that is not the motor's is told before anything is made of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gen.identification.logs.data import make_data
from gen.identification.logs.room_followers import followers
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.runs import Run
from tests.identification.network.plant import TWO, holds

NAMES = ["winding", "casing", "stand"]


def source(stand: str, measured: bool = True) -> Source:
    """A run in a room that warms by 5 K, with one temperature more."""
    rng = np.random.default_rng(1)
    pwm = holds((200, 60), (0, 30))
    room = 22.0 + 5.0 * np.linspace(0.0, 1.0, pwm.size)
    run = TWO.run(pwm, rng, room, measured=measured)
    noise = rng.normal(0.0, 0.15, pwm.size)
    course = {"room": room, "still": np.full(pwm.size, 22.0), "warm": room + 0.2 * (run.temps["winding"] - room)}
    run.temps["stand"] = course[stand] + noise
    return Source("run.csv", run)


@pytest.mark.parametrize("stand", ["room", "still"])
def test_a_part_that_follows_the_room_or_stays_as_it_is_is_named(stand: str) -> None:
    (said,) = followers([source(stand)], NAMES)
    assert said.startswith("stand: never rises, or follows the room only: it moves by ")
    assert "where winding moves by" in said


def test_one_that_warms_a_little_with_the_motor_is_not() -> None:
    assert followers([source("warm")], NAMES) == []


def test_nor_is_one_that_rises_in_any_other_run_or_where_nothing_is_warm() -> None:
    assert followers([source("room"), source("warm")], NAMES) == []
    cool = Run(np.arange(50.0), np.full(50, 9), {name: np.full(50, 20.0) for name in NAMES}, np.full(50, 20.0))
    assert followers([Source("cool.csv", cool)], NAMES) == []


def test_a_room_and_a_part_under_each_others_names_are_told() -> None:
    run = source("still").run
    swapped = replace(run, ambient=run.temps["winding"], temps={"stand": run.temps["stand"]})
    (said,) = followers([Source("run.csv", swapped)], ["stand"])
    assert "where ambient moves by" in said


def test_both_kinds_of_model_warn_of_it() -> None:
    for made in (make_data([source("room")], None), make_network_data([source("room")], None)):
        assert sum(warning.startswith("stand: never rises") for warning in made.warnings) == 1


def unsaid(moves: float) -> Source:
    """A run of which nothing says the room, and a temperature more that drifts by so much."""
    run = source("room", measured=False).run
    course = 22.0 + moves * np.linspace(0.0, 1.0, run.time_s.size)
    return Source("run.csv", replace(run, ambient=None, temps={**run.temps, "stand": course}))


def test_where_nothing_says_the_room_the_one_that_moves_least_by_far_is_asked_for() -> None:
    (said,) = followers([unsaid(4.0)], NAMES)
    assert said.startswith("stand moves by 3.9 K where winding moves by ")
    assert "if stand is the room's, name it ambient_degC" in said
    assert followers([unsaid(30.0)], NAMES) == []
    noted = replace(unsaid(4.0).run, comments={"ambient_degC": "22"})
    assert followers([Source("run.csv", noted)], NAMES) == []
