"""A room whose walls lag behind its air: motors are followed in small steps here, with no network of the project."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import gen
from gen.refinement.network import refine
from gen.refinement.network.kept import WALLS_ALONE
from gen.runs import Run
from tests.refinement.network.motor import NOISE_K, ROW_S, Tree, profile, tree, write

SHARE, LAG_S = 0.6, 5000.0


def followed(seed: int, share: float = SHARE, past_K: float = 0.0) -> Run:
    """The motor of `tree` with a share of what its casing gives off going to walls that follow the room.

    Before the run the room was warmer by `past_K` in runs of odd seeds, colder in others.
    """
    pwm = profile(seed)
    time = ROW_S * np.arange(pwm.size, dtype=np.float64)
    room = 24.0 + 4.0 * np.sin(time / 2000.0 + seed)
    speed = np.abs(pwm) / 255.0
    out = np.where(pwm == 0, 0.18, 0.2 + 0.3 * speed**0.8)
    watts = np.stack([0.00015 * pwm**2 + 0.01 * np.abs(pwm), 0.015 * np.abs(pwm)])
    walls = room[0] + past_K * (1.0 if seed % 2 else -1.0)
    winding = casing = share * walls + (1.0 - share) * room[0]
    temps = np.empty((2, pwm.size))
    for row in range(pwm.size):
        temps[:, row] = winding, casing
        flow = 0.5 * (winding - casing)
        felt = share * walls + (1.0 - share) * room[row]
        winding += ROW_S * (watts[0, row] - flow) / 120.0
        casing += ROW_S * (watts[1, row] + flow - out[row] * (casing - felt)) / 400.0
        walls += ROW_S * (room[row] - walls) / LAG_S
    noise = np.random.default_rng([seed, 1]).normal(0.0, NOISE_K, temps.shape)
    return Run(time, pwm, dict(zip(("winding", "casing"), temps + noise, strict=True)), room, {})


def refined(motor: Tree, folder: Path, share: float = SHARE, past_K: float = 0.0) -> gen.Refinement:
    path = folder / "small.json"
    path.write_text(json.dumps(motor), encoding="utf-8")
    one, two, three = (write(followed(seed, share, past_K), folder / f"run_{seed}.csv") for seed in (1, 2, 3))
    return gen.refine(gen.load(path), fit=[one, two], test=[three])


@pytest.mark.parametrize("fixed", [False, True])
def test_walls_are_found_and_written_as_a_node_between_the_motor_and_the_room(tmp_path: Path, fixed: bool) -> None:
    motor = tree()
    if fixed:
        motor["ambient"] = {"fixed_degC": 24}
    found = refined(motor, tmp_path)
    effects = found.details()["effects"]
    assert {effect["name"] for effect in effects} == {"ambient"}
    walls = effects[-1]["parameters"]
    assert walls["through"] == "walls"
    assert walls["lag_s"] == pytest.approx(LAG_S, rel=0.1)
    assert walls["to_walls_over_to_air"] == pytest.approx(SHARE / (1.0 - SHARE), rel=0.15)
    details = found.details()
    assert details["before"]["test"]["rmse_K"] > 5.0 * NOISE_K
    assert details["after"]["test"]["rmse_K"] < 1.2 * NOISE_K
    coefficients = found.model.coefficients
    assert coefficients.model.ambient_channel == "ambient_degC"
    assert coefficients.model.network is not None
    assert [node.name for node in coefficients.model.network.hidden] == ["hidden1"]
    assert found.verdict == "explained"
    assert not any("walls begin as warm as the air" in warning for warning in found.warnings)


def test_walls_of_which_nobody_knows_how_they_begin_explain_a_part(tmp_path: Path) -> None:
    """The fit finds how warm they were from the whole run; who uses the file cannot."""
    found = refined(tree(), tmp_path, past_K=4.0)
    assert found.details()["effects"][-1]["parameters"]["through"] == "walls"
    assert found.details()["after"]["test"]["rmse_K"] > 3.0 * NOISE_K
    assert found.verdict == "partly explained"
    assert any("walls begin as warm as the air" in warning for warning in found.warnings)


def test_a_room_without_such_walls_gets_none(tmp_path: Path) -> None:
    found = refined(tree(), tmp_path, share=0.0)
    assert (found.verdict, len(found.effects())) == ("nothing missing", 0)


def test_walls_are_not_written_about_an_ambient_that_stays_fixed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where the measured air says no more than a fixed value does."""
    monkeypatch.setattr(refine, "moving_ambient", lambda *_: None)
    motor = tree()
    motor["ambient"] = {"fixed_degC": 24}
    found = refined(motor, tmp_path)
    assert found.model.text == found.baseline.text
    assert WALLS_ALONE in found.warnings
    assert found.verdict == "partly explained"
