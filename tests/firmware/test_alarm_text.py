"""A rule in words: every part of it is said once, and none that it does not have."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from gen.coefficients import parse
from gen.firmware.alarm_text import alarm_texts, told_sleeping
from gen.lowering.alarms import lower_alarms
from tests.examples import ROOT

TREE = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
OTHER = {"name": "other", "kind": "over_temperature", "component": "brush", "limit_degC": 90.0}


@pytest.mark.parametrize(
    ("rule", "condition"),
    [
        (
            {"kind": "over_temperature", "limit_degC": 120.0, "speed_percent": [0, 100]},
            "casing over 120 degC, at 0 to 100 % speed, stops the motor",
        ),
        (
            {"kind": "over_temperature", "limit_degC": 120.0, "speed_percent": [0, 100], "stop_motor": False},
            "casing over 120 degC, at 0 to 100 % speed",
        ),
        (
            {"kind": "above_model", "threshold_K": 3.0, "speed_percent": [20, 60], "persistence_s": 30},
            "casing above the model by more than 3 K, at 20 to 60 % speed, for 30 s",
        ),
        (
            {"kind": "below_model", "threshold_K": 3.0, "speed_percent": [20, 60], "settle_s": 600},
            "casing below the model by more than 3 K, at 20 to 60 % speed, from 600 s after PWM came there",
        ),
        (
            {"kind": "above_model", "threshold_K": 3.0, "relative_to": "brush", "speed_percent": [20, 60]},
            "casing farther above the model than brush is by more than 3 K, at 20 to 60 % speed",
        ),
        (
            {"kind": "above_model", "threshold_K": 3.0, "requires": "other", "speed_percent": [20, 60]},
            "casing above the model by more than 3 K, at 20 to 60 % speed, only while other is raised",
        ),
        (
            {"kind": "above_model", "threshold_K": 3.0, "unless": "other", "speed_percent": [20, 60]},
            "casing above the model by more than 3 K, at 20 to 60 % speed, not while other is raised",
        ),
        (
            {"kind": "above_model", "threshold_K": 3.0, "stop_motor": True, "speed_percent": [20, 60]},
            "casing above the model by more than 3 K, at 20 to 60 % speed, stops the motor",
        ),
        (
            {"kind": "cusum", "slack_K": 2.0, "threshold_K_s": 900.0, "speed_percent": [20, 60]},
            "casing above the model by more than 2 K, summed up to 900 K s, at 20 to 60 % speed",
        ),
    ],
)
def test_a_condition_says_what_the_rule_has(rule: dict[str, Any], condition: str) -> None:
    rules = [OTHER, {"name": "rule", "component": "casing", "persistence_s": 0, **rule}]
    if rule["kind"] == "cusum":
        del rules[1]["persistence_s"]
    made = alarm_texts(parse(json.dumps({**TREE, "alarms": rules}).encode()))
    # For how long a warm start puts it to sleep has a test of its own.
    assert re.sub(r", only after .* warm motor", "", made[1].condition) == condition
    assert bool(made[1].thresholds) == (rule["kind"] != "over_temperature")


def test_it_is_told_for_how_long_a_warm_start_puts_rules_to_sleep() -> None:
    # The casing is of order 1: its temperature is its state. The brush has slopes that no thermocouple tells.
    both = [
        {"name": part, "kind": "above_model", "component": part, "threshold_K": 3.0} for part in ("casing", "brush")
    ]
    rules = [{**rule, "speed_percent": [20, 100], "persistence_s": 30} for rule in both]
    coefficients = parse(json.dumps({**TREE, "alarms": rules}).encode())
    casing, brush = alarm_texts(coefficients)
    assert casing.sleeps_s == 0.0
    assert "warm motor" not in casing.condition
    samples = lower_alarms(coefficients)[1].start_wait
    assert brush.sleeps_s == samples * 0.25 > 3600.0
    hours, minutes = re.search(r"only after (\d) h (\d\d) min there", brush.condition).groups()  # type: ignore[union-attr]
    assert brush.sleeps_s <= 60 * (60 * int(hours) + int(minutes)) < brush.sleeps_s + 60.0
    told = told_sleeping([casing, brush])
    assert told.endswith(f"rules sleep, counted at their speeds: brush {hours} h {minutes} min")
    assert told_sleeping([casing]) == ""
