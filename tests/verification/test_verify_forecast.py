"""The look ahead: emitted C++ and reference agree on every target, and no planted fault passes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.coefficients import parse
from gen.firmware import render
from gen.firmware.context import project_context
from gen.lowering.forecast import LoweredForecast, lower_forecast
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.reference.forecast import HOLDABLE, KNOWN, RUNNING, SEARCHING
from gen.verification.alarms import compare_forecast, forecast_harness
from gen.verification.compare import first_mismatch
from gen.verification.forecast_campaign import ForecastCampaign, forecast_campaign
from gen.verification.harness import HostHarness
from gen.verification.runners import Library, write_library
from tests.examples import ROOT

LANES, LENGTH = 8, 500
#: So short a horizon that runs, and whole searches, come to their end.
ASKED: dict[str, Any] = {"horizon_s": 20.0, "steps_per_sample": 4, "near_s": 9.0}
MODELS = {
    # Low enough that a motor at full PWM reaches them, and that one at rest does not.
    "parts": (
        "my1016",
        {"limits": [{"component": "brush", "limit_degC": 70}, {"component": "bearing", "limit_degC": 55}]},
    ),
    "network, a hidden node": ("network", {"limits": [{"component": "winding", "limit_degC": 110}]}),
}


def emitted(
    model: str, arithmetic: Arithmetic, folder: Path, fault: tuple[str, str] | None = None
) -> tuple[Library, LoweredForecast]:
    example, own = MODELS[model]
    tree = json.loads((ROOT / "examples" / example / "coeffs.json").read_text(encoding="utf-8"))
    coefficients = parse(json.dumps({**tree, "version": 2, "forecast": ASKED | own}).encode())
    program = lower(coefficients, arithmetic, "table")
    context = project_context(coefficients, program, "coeffs.json")
    files = render.library(context)
    if fault is not None:
        path = f"lib/{context.name}/src/{context.name}_forecast.cpp"
        assert files[path].count(fault[0]) == 1, "the fault has no place to stand"
        files[path] = files[path].replace(*fault)
    forecast = lower_forecast(coefficients, program)
    assert forecast is not None
    return write_library(program, context, files, folder), forecast


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> ForecastCampaign:
    library, forecast = emitted("parts", "fixed", tmp_path_factory.mktemp("campaign"))
    return forecast_campaign(library.program, forecast, LANES, LENGTH)


def test_the_campaign_has_runs_that_end_at_limits_and_at_the_horizon_and_whole_searches(
    campaign: ForecastCampaign, tmp_path: Path
) -> None:
    _, forecast = emitted("parts", "fixed", tmp_path)
    found = campaign.expected
    state = found["state"]
    known = (state & KNOWN) != 0
    assert known.any()
    assert not known.all()
    assert (found["first"][known] == len(forecast.limits)).any(), "no run came to the horizon"
    assert len(np.unique(found["first"][known])) > 2, "always the same limit"
    assert {0, forecast.horizon} < set(found["until"][known].tolist())
    assert set(np.unique(found["near"])) == {0, 1}
    held = found["holdable"][(state & HOLDABLE) != 0]
    assert {0, forecast.most_pwm} < set(held.tolist()), "no search ended between the ends"
    assert ((state & SEARCHING) != 0).any()
    assert ((state & RUNNING) == 0).any()


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("model", MODELS)
def test_no_word_differs_on_any_target(model: str, arithmetic: Arithmetic, tmp_path: Path) -> None:
    library, forecast = emitted(model, arithmetic, tmp_path)
    compared = list(compare_forecast(library, forecast, 3, 200, ("g++ -O2", "clang++ sanitized"), board=True))
    assert len(compared) == 3
    for name, expected, difference in compared:
        assert difference is None, f"{name}: {difference}"
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


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_a_planted_fault_is_caught(fault: tuple[str, str], campaign: ForecastCampaign, tmp_path: Path) -> None:
    planted = (fault[0].replace("{name}", "MY1016"), fault[1].replace("{name}", "MY1016"))
    library, forecast = emitted("parts", "fixed", tmp_path, planted)
    harness = forecast_harness(forecast)
    harness.write(library)
    runner = HostHarness(library, harness, "g++ -O2", campaign.expected.dtype)
    difference = first_mismatch(campaign.expected, runner.run(campaign.inputs))
    assert difference is not None
    assert difference.differing > 0
