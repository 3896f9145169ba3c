"""What the file may ask of running ahead, and what is refused."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest

from gen.coefficients import parse
from gen.coefficients.forecast import limits_ahead
from gen.errors import InputError
from tests.examples import ROOT

PARTS: dict[str, Any] = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
NETWORK: dict[str, Any] = json.loads((ROOT / "examples" / "network" / "coeffs.json").read_text(encoding="utf-8"))


def asked(base: dict[str, Any], forecast: dict[str, Any], **others: object) -> bytes:
    return json.dumps(copy.deepcopy(base) | {"version": 2, "forecast": forecast} | others).encode()


def ahead(raw: bytes) -> dict[str, float]:
    document = parse(raw).document
    assert document.forecast is not None
    return limits_ahead(document.forecast, document.alarms)


def test_the_limits_of_the_rules_are_what_is_looked_at() -> None:
    assert ahead(asked(PARTS, {"horizon_s": 600})) == {"brush": 120, "bearing": 110, "magnet": 110, "casing": 110}


def test_a_limit_of_its_own_takes_a_rules_place_and_may_be_of_a_hidden_node() -> None:
    own = {"horizon_s": 600, "limits": [{"component": "casing", "limit_degC": 70}]}
    assert ahead(asked(PARTS, own)) == {"casing": 70, "brush": 120, "bearing": 110, "magnet": 110}
    hidden = {"horizon_s": 600, "limits": [{"component": "winding", "limit_degC": 130}]}
    assert ahead(asked(NETWORK, hidden)) == {"winding": 130}


def test_of_two_rules_on_a_part_the_lower_limit_holds() -> None:
    rules = [
        {"name": f"r{limit}", "kind": "over_temperature", "component": "brush", "limit_degC": limit}
        for limit in (90, 80)
    ]
    assert ahead(asked(PARTS, {"horizon_s": 600}, alarms=rules)) == {"brush": 80}


def test_one_sample_ahead_is_the_least_that_can_be_asked_for() -> None:
    document = parse(asked(PARTS, {"horizon_s": PARTS["sample_time_s"]})).document
    assert document.forecast is not None
    assert document.forecast.horizon_s == 0.25


@pytest.mark.parametrize(
    ("forecast", "others", "said"),
    [
        (
            {"horizon_s": 600},
            {"alarms": []},
            '$.forecast: no limit to run ahead to; expected "limits", or an over-temperature rule',
        ),
        (
            {"horizon_s": 600, "limits": [{"component": "rotor", "limit_degC": 90}]},
            {},
            '$.forecast.limits[0].component: found "rotor", expected "brush", "bearing", "magnet" or "casing"',
        ),
        (
            {"horizon_s": 600, "limits": [{"component": "brush", "limit_degC": 90}] * 2},
            {},
            '$.forecast.limits[1].component: found "brush" again, expected one limit for each part',
        ),
        ({"horizon_s": 0.1}, {}, "$.forecast.horizon_s: found 0.1, expected the sample time, 0.25, or more"),
        ({"horizon_s": 0}, {}, "$.forecast.horizon_s: found 0"),
        ({"horizon_s": 600, "near_s": 601}, {}, "$.forecast.near_s: found 601, expected at most the horizon, 600"),
        ({"horizon_s": 600, "steps_per_sample": 0}, {}, "$.forecast.steps_per_sample: found 0, expected at least 1"),
        (
            {"horizon_s": 600},
            {"protection": [{"cause": "limit_near", "action": "log"}]},
            '$.protection[0].cause: "limit_near" can never be: $.forecast lacks "near_s"',
        ),
        (
            {"horizon_s": 600, "steps_per_sample": 7},
            {"protection": [{"cause": "late_loop", "action": "derate", "derate_pwm": "holdable"}]},
            '$.forecast.steps_per_sample: found 7, expected at least 8, since a "derate_pwm" is "holdable"',
        ),
    ],
)
def test_what_cannot_be_is_refused_with_its_place(forecast: dict[str, Any], others: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        parse(asked(PARTS, forecast, **others))
    assert said in str(caught.value)
