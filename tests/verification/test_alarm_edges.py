"""The emitted alarm rules at the ends of their ranges, by hand: where a random campaign seldom comes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.arrays import IntArray
from gen.coefficients import parse
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.alarms import lower_alarms
from gen.lowering.lower import lower
from gen.verification.alarm_campaign import BEGIN, RESET_AND_STEP, input_type, output_type
from gen.verification.comparisons import ALARMS
from gen.verification.harness import HostHarness
from gen.verification.runners import write_library
from tests.examples import ROOT

SUM, RANGE = 1, 2  # bits of the two rules
SLACK_MK, LIMIT = 2000, 40_000  # 10 K s at four samples a second, in thousandths of a kelvin times samples
RULES: list[dict[str, Any]] = [
    {"name": "drifts", "kind": "cusum", "component": "winding", "slack_K": 2.0, "threshold_K_s": 10.0},
    {
        "name": "slow",
        "kind": "above_model",
        "component": "winding",
        "threshold_K": 5.0,
        "speed_percent": [10, 40],  # 25.5..102 counts; 300 and -300 are 44 in a byte
        "persistence_s": 0,
    },
]


class Bench:
    """The two masses' firmware with these rules, on this computer; all parts begin at ambient, known to be at rest."""

    def __init__(self, folder: Path) -> None:
        tree = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text(encoding="utf-8"))
        coefficients = parse(json.dumps({**tree, "alarms": RULES}).encode())
        program = lower(coefficients, "fixed", "table")
        context = project_context(coefficients, program, "coeffs.json")
        library = write_library(program, context, render.library(context), folder)
        ALARMS.write(library)
        rules = lower_alarms(coefficients)
        self._input = input_type(len(program.components), rules)
        self._host = HostHarness(library, ALARMS, "clang++ sanitized", output_type(program, rules))

    def active(
        self, pwm: list[int], deviation_mK: list[int], reset_before: int | None = None
    ) -> tuple[list[int], list[int]]:
        """Masks of the active and the sleeping rules after each sample, the winding so far above its model."""
        inputs = np.zeros((1, len(pwm) + 1), dtype=self._input)
        inputs["op"][:, 0] = BEGIN
        if reset_before is not None:
            inputs["op"][:, 1 + reset_before] = RESET_AND_STEP
        inputs["valid"] = 0b11
        inputs["valid"][:, 0] = 1
        inputs["pwm"][:, 1:] = pwm
        model = self._host.run(inputs)["winding.mC"][0]  # it knows nothing of what is measured
        inputs["measured_mC"][0, 1:, 0] = model + np.array(deviation_mK)
        out = self._host.run(inputs)[0]
        return out["active"].tolist(), out["asleep"].tolist()


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Bench:
    return Bench(tmp_path_factory.mktemp("alarms"))


def sums(bench: Bench, deviations_mK: list[int]) -> list[int]:
    active, _ = bench.active([0] * len(deviations_mK), deviations_mK)
    return [mask & SUM for mask in active]


def test_a_sum_raises_its_alarm_at_its_limit_and_not_one_below(bench: Bench) -> None:
    one_below = SLACK_MK + LIMIT - 1
    assert sums(bench, [one_below, SLACK_MK, SLACK_MK + 1, SLACK_MK - 1, SLACK_MK + 1]) == [0, 0, 1, 0, 1]


def test_a_sum_stays_within_its_ends(bench: Bench) -> None:
    """What lies beyond the limit is forgotten at once, what lies below zero too."""
    assert sums(bench, [SLACK_MK + 3 * LIMIT, SLACK_MK - 1]) == [1, 0]
    assert sums(bench, [-90_000, SLACK_MK + LIMIT]) == [0, 1]


def test_a_reset_begins_the_sum_anew_and_touches_nothing_beyond_the_rules(bench: Bench) -> None:
    """Out of bounds, a sanitized build would end there."""
    half = SLACK_MK + LIMIT // 2
    for reset_before, expected in ((None, [0, 1, 1]), (1, [0, 0, 1]), (2, [0, 1, 0])):
        active, _ = bench.active([0] * 3, [half] * 3, reset_before)
        assert [mask & SUM for mask in active] == expected


def test_a_pwm_that_fits_no_byte_is_in_no_range_but_the_last(bench: Bench) -> None:
    inside = [26, 102, -26, -102]
    outside = [25, 103, 255, 256, 300, -300, 256 + 44, -(256 + 44), 32767, -32767, -32768]
    pwm: IntArray = np.array([*inside, *outside])
    active, asleep = bench.active(pwm.tolist(), [6000] * pwm.size)
    assert [bool(mask & RANGE) for mask in active] == [True] * len(inside) + [False] * len(outside)
    assert [bool(mask & RANGE) for mask in asleep] == [False] * len(inside) + [True] * len(outside)
