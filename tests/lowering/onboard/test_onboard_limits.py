"""Schedules at the edge of what the board's words hold: built with room, or refused with component and schedule."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from gen.coefficients import Coefficients, parse
from gen.errors import CheckFailed
from gen.firmware.onboard_cpp import five_bytes
from gen.lowering.lower import lower
from gen.lowering.onboard.evaluate import RangeError, evaluate
from gen.lowering.onboard.evaluate import power_series as horner
from gen.model.exact import ExactSolution
from gen.reference.lanes import lanes_of
from tests.examples import ROOT, example
from tests.work import lines


def coefficients(component: dict[str, Any], **changed: object) -> Coefficients:
    tree: dict[str, Any] = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text(encoding="utf-8"))
    tree |= {"components": [component], "alarms": [], "wiring": {}, **changed}
    tree.pop("provenance", None)
    return parse(json.dumps(tree).encode())


def narrow() -> Coefficients:
    """Over 45 commands far from 0 a polynomial's coefficients are larger than any sum on Horner's way."""
    first = {"exp2": [-0.0005382305714275119, 0.025222771156306965, -0.0003698722192246024, 0.017655939809414874]}
    return coefficients(
        {
            "name": "part",
            "order": 2,
            "gain": {"exp1": [1.57439544247162, -0.023109660876704564]},
            "poles": [{"real": first}, {"real": {"poly": [-0.28930753781804097]}}],
        },
        sample_time_s=0.295,
        ambient={"fixed_degC": -14.0},
        validity={"pwm": [178, 222], "outside": "extrapolate"},
        domain={"pwm": [178, 222], "ambient_degC": [-14.0, 37.0], "temperature_degC": [-14.0, 37.0]},
        accuracy={"fixed_limit_K": 1.0},
    )


def test_coefficients_larger_than_every_sum_have_room_in_their_five_bytes() -> None:
    program = lower(narrow(), "fixed", "onboard")
    series = [s for s in program.onboard[0].steps if s.op == "power_series"]
    assert series  # what the test is about
    for value in (v for step in series for v in step.table):
        assert len(five_bytes(value).split(",")) == 5


def test_and_keep_their_bound() -> None:
    program = lower(narrow(), "fixed", "onboard")
    proof = program.components[0].proof
    assert proof is not None
    pwm = np.repeat(np.random.default_rng(5).integers(178, 223, (4, 60)), 20, axis=1)
    exact = ExactSolution(program.model).simulate(pwm, {"part": np.zeros(4)})["part"]
    board, before, worst = lanes_of(program.components[0], [0] * 4), None, 0.0
    for sample in range(pwm.shape[1]):
        row = pwm[:, sample] - 178
        board.sample(row, before)
        before = row
        worst = max(worst, float(np.abs(board.rise() - exact[:, sample + 1]).max()))
    assert 0.0 < worst <= proof.bound_K


def test_a_schedule_no_polynomial_follows_is_refused_by_name() -> None:
    steep = {"exp2": [-0.0005, 0.0001, -0.02, -9.0]}
    part = {"name": "part", "order": 1, "gain": {"poly": [1e-4]}, "poles": [{"real": steep}]}
    given = coefficients(part, validity={"pwm": [0, 255], "outside": "hold"}, accuracy={"fixed_limit_K": 1.0})
    lower(given, "fixed", "table")
    with pytest.raises(CheckFailed, match=r"^component part: --schedule onboard cannot compute it: no polynomial"):
        lower(given, "fixed", "onboard")


def test_a_coefficient_beyond_40_bits_is_noticed() -> None:
    horner((-(2**39), 2**39 - 1), np.array([255]))
    for beyond in (2**39, -(2**39) - 1):
        with pytest.raises(RangeError, match="40 bits"):
            horner((beyond, 0), np.array([1]))


def test_tables_by_lane_give_what_each_of_them_gives() -> None:
    component = lower(narrow(), "fixed", "onboard").onboard[0]
    number = next(i for i, s in enumerate(component.steps) if s.op == "power_series")
    pwm = np.array([178, 200, 222])
    own = np.array(component.steps[number].table)
    changed = own + np.eye(len(own), dtype=np.int64)[-1] * 4096
    tables = np.stack([own, changed, own], axis=1)
    mixed, _ = evaluate(component, pwm, {number: tables})
    plain, _ = evaluate(component, pwm)
    other, _ = evaluate(component, pwm, {number: np.stack([changed] * 3, axis=1)})
    np.testing.assert_array_equal(mixed, np.stack([plain[0], other[1], plain[2]]))
    assert np.any(other[1] != plain[1])


def test_a_model_whose_constants_are_tuned_takes_no_longer_for_it() -> None:
    """The simulated motor has parts of order 2, 1, 2 and 1 to tune; of three of them it took 77 million lines once."""
    given = example("my1016_rig")
    assert lines(lambda: lower(given, "fixed", "onboard")) < 4_000_000
