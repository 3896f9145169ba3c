"""A rule in words: every part of it is said once, and none that it does not have."""

from __future__ import annotations

import json
from typing import Any

import pytest

from gen.coefficients import parse
from gen.firmware.alarm_text import alarm_texts
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
    assert made[1].condition == condition
    assert bool(made[1].thresholds) == (rule["kind"] != "over_temperature")
