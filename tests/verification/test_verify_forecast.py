"""The look ahead: emitted C++ and reference agree on every target, and no planted fault passes."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.lowering.forecast import LoweredForecast, lower_forecast
from gen.lowering.kinds import Arithmetic
from gen.reference.forecast import HOLDABLE, KNOWN, RUNNING, SEARCHING
from gen.verification.comparisons import compare_forecast, forecast_harness
from gen.verification.forecast_campaign import ForecastCampaign, forecast_campaign
from tests.campaign import share
from tests.examples import ROOT
from tests.verification.planted import Emitted, difference, emitted

LANES, LENGTH = 8, 500
#: So short a horizon that runs, and whole searches, come to their end.
ASKED: dict[str, Any] = {"horizon_s": 20.0, "steps_per_sample": 4, "near_s": 9.0}


def parts() -> str:
    """With limits low enough that a motor at full PWM reaches them, and that one at rest does not."""
    tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    limits = [{"component": "brush", "limit_degC": 70}, {"component": "bearing", "limit_degC": 55}]
    return json.dumps(tree | {"version": 2, "forecast": ASKED | {"limits": limits}})


def network() -> str:
    """With a limit of a hidden node, a heat that knows the direction, and parts called as the library calls its own."""
    tree = json.loads((ROOT / "examples" / "network" / "coeffs.json").read_text(encoding="utf-8"))
    tree["network"]["channels"].append({"column": "pwm", "range": [-255, 255], "neutral": 0})
    tree["network"]["heats"][0]["factors"] = [{"channel": "pwm", "table": {"at": [-1, 0], "value": [1.5, 1.0]}}]
    limits = [{"component": name, "limit_degC": 110} for name in ("winding", "brush", "bearing", "magnet")]
    text = json.dumps(tree | {"forecast": ASKED | {"limits": limits}})
    for node, name in {"brush": "near", "bearing": "limits", "magnet": "at_once", "winding": "steps"}.items():
        text = text.replace(f'"{node}"', f'"{name}"')
    return text


def gains() -> str:
    """With sensors whose gains are wrong: one has come half off, another one's amplifier shows too much."""
    tree = json.loads(network())
    gains = {"near": {"gain_error": -0.45}, "limits": {"gain_error": 0.2, "gain_about": "zero_degC", "offset_K": -1.5}}
    for node in tree["network"]["nodes"]:
        if node["name"] in gains:
            node["sensor"] |= gains[node["name"]]
    return json.dumps(tree)


def held() -> str:
    """A motor that is derated to what can be held."""
    tree = json.loads(parts())
    tree["forecast"]["steps_per_sample"] = 16
    return json.dumps(tree | {"protection": [{"cause": "limit_near", "action": "derate", "derate_pwm": "holdable"}]})


MODELS: dict[str, Callable[[], str]] = {"parts": parts, "network": network, "gains": gains, "held": held}


@cache
def library(model: str, arithmetic: Arithmetic = "fixed") -> Emitted:
    return emitted(MODELS[model](), arithmetic)


@cache
def forecast(model: str, arithmetic: Arithmetic = "fixed") -> LoweredForecast:
    made = library(model, arithmetic)
    found = lower_forecast(made.coefficients, made.program)
    assert found is not None
    return found


@cache
def given(model: str) -> ForecastCampaign:
    return forecast_campaign(library(model).program, forecast(model), LANES, LENGTH)


def test_the_campaign_has_runs_that_end_at_limits_and_at_the_horizon_and_whole_searches() -> None:
    ahead, found = forecast("parts"), given("parts").expected
    state = found["state"]
    known = (state & KNOWN) != 0
    assert known.any()
    assert not known.all()
    assert (found["first"][known] == len(ahead.limits)).any(), "no run came to the horizon"
    assert len(np.unique(found["first"][known])) > 2, "always the same limit"
    assert {0, ahead.horizon} < set(found["until"][known].tolist())
    assert set(np.unique(found["near"])) == {0, 1}
    assert ahead.near is not None
    still = (found["near"][:, :-1] == 1) & (found["near"][:, 1:] == 1)
    assert (still & (found["samples"][:, :-1] > ahead.near + 1)).any(), "nothing stays near on its way further off"
    held = found["holdable"][(state & HOLDABLE) != 0]
    assert {0, ahead.most_pwm} < set(held.tolist()), "no search ended between the ends"
    assert ((state & SEARCHING) != 0).any()
    assert ((state & RUNNING) == 0).any()


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("model", MODELS)
def test_no_word_differs_on_any_target(model: str, arithmetic: Arithmetic, tmp_path: Path) -> None:
    made, ahead = library(model, arithmetic).written(tmp_path), forecast(model, arithmetic)
    compared = list(compare_forecast(made, ahead, 3, 200, ("g++ -O2", "clang++ sanitized"), board=True))
    assert len(compared) == 3
    for name, expected, found in compared:
        assert found is None, f"{name}: {found}"
        assert expected.size == 3 * 200


FAULTS = {
    "late by a sample": ("state->gone == HORIZON", "state->gone > HORIZON"),
    "a limit is missed by a thousandth": (">= limit.mC)", "> limit.mC)"),
    "never warmer than the model": ("warmer > 0 ? warmer : 0", "0 * warmer"),
    "colder than the model": ("warmer > 0 ? warmer : 0", "warmer"),
    "the board's own model moves on": ("    change_places();\n    for", "    for"),
    "another PWM changes nothing": ("if (pwm != state->pwm)", "if (false)"),
    "the search goes on from before": (
        "&= {name}_FORECAST_HOLDABLE;\n        begin_search();",
        "&= {name}_FORECAST_HOLDABLE;",
    ),
    "a try that fails is held": ("            state->high = size;", "            state->low = size;"),
    "the answer does not age": ("    ++state->age;\n", ""),
    "a run is as old as the answer": ("state->age = state->begun;", "state->age = 0;"),
    "backwards is forwards": ("state->pwm < 0 ? (int16_t)-size : size", "size"),
    "none is near": (" && state->first < LIMITS;", ";"),
    "near flickers": ("!foreseen || samples > 54UL", "true"),
    "near for ever": ("!foreseen || samples > 54UL", "false"),
}


HELD_FAULTS = {
    "noise counts on the way": ("above > NOISE_MK ? above - NOISE_MK : 0", "above"),
    "noise never counts": (" || {name}_forecast.gone == HORIZON", ""),
    "one reading is all": ("(warmer - warmer_mK[i]) / 16", "warmer - warmer_mK[i]"),
    "near ends with its time": ("    if (!(state->state & MY1016_FORECAST_KNOWN)) {", "    if (false) {"),
    "the search begins at the full PWM again": ("    if (!known) {", "    if (true) {"),
    "down one by one": ("2 * state->high - state->holdable - 1", "state->high - 1"),
    "up one by one": ("2 * state->low - state->holdable + 1", "state->low + 1"),
    "an answer never grows old": ("state->since > HORIZON", "false"),
    "an answer is as old as its end": ("state->since = state->begun", "state->since = 0"),
    "what failed is still held": ("held < state->high ? held : state->high - 1", "held"),
    "only the last answer is held": ("state->holdable > state->low ? state->holdable : state->low", "state->holdable"),
    "another PWM begins the search anew": ("if (turned)", "if (turned || true)"),
    "a motor that turns round goes on with its search": ("if (turned)", "if (turned && false)"),
}


def test_a_held_motors_campaign_has_answers_in_between_searches_and_answers_that_are_too_old() -> None:
    found = given("held").expected
    known = (found["state"] & HOLDABLE) != 0
    limited = found["most_pwm"] != found["holdable"]
    assert (limited & known).any(), "no search has found anything before its end"
    assert (limited & ~known).any(), "nothing was held before the first search had ended"
    assert len(np.unique(found["most_pwm"])) > 5
    assert set(np.unique(found["near"])) == {0, 1}


@pytest.mark.campaign
@pytest.mark.parametrize("fault", share(HELD_FAULTS.values()), ids=share(HELD_FAULTS))
def test_a_planted_fault_of_holding_is_caught(fault: tuple[str, str], tmp_path: Path) -> None:
    caught("held", (fault[0].replace("{name}", "my1016"), fault[1].replace("{name}", "my1016")), tmp_path)


@pytest.mark.campaign
@pytest.mark.parametrize("fault", share(FAULTS.values()), ids=share(FAULTS))
def test_a_planted_fault_is_caught(fault: tuple[str, str], tmp_path: Path) -> None:
    caught("parts", (fault[0].replace("{name}", "MY1016"), fault[1].replace("{name}", "MY1016")), tmp_path)


def caught(model: str, fault: tuple[str, str], folder: Path) -> None:
    planted = library(model).written(folder, "_forecast.cpp", fault)
    found = difference(planted, forecast_harness(forecast(model)), given(model))
    assert found is not None
    assert found.differing > 0


def test_a_run_that_keeps_the_direction_of_before_is_caught(tmp_path: Path) -> None:
    planted = library("network").written(tmp_path, "_forecast.cpp", ("1000L * state->tried", "0L * state->tried"))
    ((_, _, found),) = compare_forecast(planted, forecast("network"), LANES, 200, ("g++ -O2",), board=False)
    assert found is not None
