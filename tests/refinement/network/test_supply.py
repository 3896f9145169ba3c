"""A supply that moves: what more of it does is what more PWM does, as a motor's mean voltage is their product."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import gen
from gen.runs import Run
from tests.refinement.network.motor import NOISE_K, ROW_S, profile, tree, wave, write

RATED_V = 24.0


def followed(seed: int) -> Run:
    """The motor of `tree` in small steps, its PWM times the share of the rated voltage in the place of its PWM."""
    pwm = profile(seed)
    time = ROW_S * np.arange(pwm.size, dtype=np.float64)
    supply = wave(40 + seed, 19.0, 27.0)
    mean = np.abs(pwm) * supply / RATED_V
    out = np.where(pwm == 0, 0.18, 0.2 + 0.3 * (mean / 255.0) ** 0.8)
    watts = np.stack([0.00015 * mean**2 + 0.01 * mean, 0.015 * mean])
    room = np.full(pwm.size, 24.0)
    winding = casing = 24.0
    temps = np.empty((2, pwm.size))
    for row in range(pwm.size):
        temps[:, row] = winding, casing
        flow = 0.5 * (winding - casing)
        winding += ROW_S * (watts[0, row] - flow) / 120.0
        casing += ROW_S * (watts[1, row] + flow - out[row] * (casing - room[row])) / 400.0
    noise = np.random.default_rng([seed, 1]).normal(0.0, NOISE_K, temps.shape)
    return Run(time, pwm, dict(zip(("winding", "casing"), temps + noise, strict=True)), room, {"supply_V": supply})


def test_heat_follows_the_supply_at_each_speed_as_it_follows_pwm_there(tmp_path: Path) -> None:
    path = tmp_path / "small.json"
    path.write_text(json.dumps(tree()), encoding="utf-8")
    one, two, three = (write(followed(seed), tmp_path / f"run_{seed}.csv") for seed in (1, 2, 3))
    found = gen.refine(gen.load(path), fit=[one, two], test=[three])
    effects = found.details()["effects"]
    assert [effect["name"] for effect in effects] == ["supply_voltage"]
    told = effects[0]["parameters"]
    assert told["usual_V"] == pytest.approx(RATED_V, abs=0.5)
    assert told["heat_over_that_by_pwm"] == pytest.approx(1.0, abs=0.1)
    details = found.details()
    assert details["before"]["test"]["rmse_K"] > 8.0 * NOISE_K
    assert details["after"]["test"]["rmse_K"] < 1.5 * NOISE_K
