"""Runs that each say their own room in a comment: the model counts from it, and what follows takes it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gen
from gen.coefficients import load
from gen.identification.logs.data import make_data
from gen.identification.logs.sources import Source
from gen.identification.network.data import make_network_data
from gen.reference.simulate import simulate_run
from gen.replay.inputs import read_for
from gen.runs import Run, write_run
from tests.identification.network.plant import TWO, holds

PROFILES = (holds((200, 60), (0, 60)), holds((120, 60), (200, 60)), holds((250, 60), (120, 60)))


def noted(pwm: np.ndarray, room: float, seed: int) -> Run:
    """A cold run in a room that a comment says."""
    run = TWO.run(pwm, np.random.default_rng(seed), room, measured=False)
    return replace(run, comments={"ambient_degC": f"{room:g}"})


def sources(*rooms: float) -> list[Source]:
    return [Source(f"run_{k}.csv", noted(PROFILES[k], room, k)) for k, room in enumerate(rooms)]


def test_a_run_in_yet_another_room_is_followed_from_the_room_that_it_notes(tmp_path: Path) -> None:
    paths = []
    for source in sources(9.0, 17.0, 25.0):
        paths.append(tmp_path / source.path)
        write_run(paths[-1], source.run)
    found = gen.identify(paths, name="motor", model="network")
    assert "Good" in found.verdict
    found.model.save(tmp_path / "motor.json")
    model = load(tmp_path / "motor.json")
    assert (model.model.ambient_fixed, model.model.ambient_channel) == (None, "ambient_degC")
    write_run(tmp_path / "fresh.csv", noted(PROFILES[1][::-1].copy(), 32.0, 9))
    run = read_for(model, tmp_path / "fresh.csv")
    shown = simulate_run(model, run, "exact", "auto", "fresh.csv")
    for name in TWO.sensed:
        assert np.sqrt(np.mean((np.asarray(shown[f"{name}_degC"]) - run.temps[name]) ** 2)) < 0.5
    # A comment stands for the column wherever a run is taken: of what is refined from, and of what is kept for a test.
    refined = gen.refine(gen.load(tmp_path / "motor.json"), fit=paths, test=[tmp_path / "fresh.csv"])
    assert refined.verdict == "nothing missing"


@pytest.mark.parametrize("make", [make_data, make_network_data])
def test_rooms_that_differ_are_none_for_all_and_that_is_said(make: type) -> None:
    apart = make(sources(9.0, 17.0, 25.0), None)
    assert apart.ambient_fixed is None
    assert sum("the runs say ambients from 9 to 25 degC" in said for said in apart.warnings) == 1
    alike = make(sources(20.0, 20.5, 20.2), None)
    assert alike.ambient_fixed == 20.2
    given = make(sources(9.0, 17.0, 25.0), 18.0)
    assert given.ambient_fixed == 18.0
    unsaid = [*sources(9.0, 17.0), Source("run_2.csv", replace(noted(PROFILES[2], 25.0, 2), comments={}))]
    assert make(unsaid, None).ambient_fixed is not None
