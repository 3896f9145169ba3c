"""Causes and actions: emitted C++ and reference agree on every target, and no planted fault passes."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gen.lowering.protection import MOST_TIMES, LoweredProtection, lower_protection
from gen.verification.comparisons import PROTECTION, compare_protection
from gen.verification.protection_campaign import ProtectionCampaign, protection_campaign
from tests.campaign import share
from tests.examples import ROOT
from tests.verification.planted import Emitted, difference, emitted

LANES, LENGTH = 32, 400
LIMITS: list[dict[str, Any]] = [
    {"name": f"{part}_limit", "kind": "over_temperature", "component": part, "limit_degC": limit}
    for part, limit in (("brush", 120.0), ("casing", 90.0))
]
TABLE: list[dict[str, Any]] = [
    {"cause": "alarm", "rule": "casing_limit", "action": "derate", "derate_pwm": 90},
    {"cause": "alarm", "rule": "casing_limit", "name": "casing_too_long", "action": "stop", "delay_s": 3.0},
    {"cause": "too_few_sensors", "least": 3, "action": "open_relay", "until": "command", "delay_s": 0.5},
    {"cause": "sensor_lost", "channel": "bearing", "action": "led"},
    {"cause": "late_loop", "action": "log", "delay_s": 1.0},
    {"cause": "overspeed", "action": "derate", "derate_pwm": "holdable", "delay_s": 1.0},
    {
        "cause": "eeprom_check",
        "action": "stop",
        "until": "cool",
        "component": "bearing",
        "restart_below_degC": 40.0,
        "pause_s": 1.0,
    },
]


@cache
def library() -> Emitted:
    tree = json.loads((ROOT / "examples" / "my1016" / "coeffs.json").read_text(encoding="utf-8"))
    tree["wiring"] |= {"relay_pin": 30, "command_timeout_s": 5.0}
    tree |= {"version": 2, "forecast": {"horizon_s": 600}, "alarms": LIMITS, "protection": TABLE}
    return emitted(json.dumps(tree), "fixed")


@cache
def entries() -> tuple[LoweredProtection, ...]:
    return lower_protection(library().coefficients)


@cache
def given() -> ProtectionCampaign:
    return protection_campaign(library().program, entries(), LANES, LENGTH)


def test_every_entry_begins_ends_and_is_waited_for() -> None:
    expected = given().expected
    for number, entry in enumerate(entries()):
        acting = (expected["protection.acting"] >> number & 1).astype(np.int8)
        holding = (expected["protection.holding"] >> number & 1).astype(np.int8)
        assert (np.diff(acting, axis=1) > 0).any(), f"{entry.label} never begins"
        assert (np.diff(acting, axis=1) < 0).any(), f"{entry.label} never ends"
        assert (acting > holding).any() == entry.lasts, f"{entry.label}: only a command ends what lasts"
        if entry.delay:
            assert (holding > acting).any(), f"{entry.label} does not wait"
        if entry.pause:
            times = expected[f"protection.{number}.times"].astype(np.int8)
            assert set(np.unique(times)) == set(range(MOST_TIMES + 1))
            assert (np.diff(times, axis=1) < 0).any(), f"{entry.label} never forgets"
    assert set(np.unique(expected["most_pwm"])) == {0, 90, 255}
    assert set(np.unique(expected["opens_relay"])) == {0, 1}
    assert set(np.unique(expected["holds"])) == {0, 1}


def test_no_word_differs_on_any_target(tmp_path: Path) -> None:
    hosts = ("g++ -O2", "clang++ sanitized")
    made = library().written(tmp_path)
    compared = list(compare_protection(made, entries(), LANES, LENGTH, hosts, board=True))
    assert len(compared) == 3
    for name, expected, found in compared:
        assert found is None, f"{name}: {found}"
        assert expected.size == LANES * LENGTH


FAULTS = {
    "early by a sample": ("if (state->held[number] > entry.delay)", "if (state->held[number] >= entry.delay)"),
    "waits too long": ("if (state->held[number] <= entry.delay)", "if (state->held[number] < entry.delay)"),
    "a gap does not matter": ("            state->held[number] = 0;\n", ""),
    "any bit is enough": ("return set >= entry.least;", "return set > 0;"),
    "other causes count": ("for (bits &= entry.mask; bits;", "for (; bits;"),
    "16-bit sensors": ("entry.word == LOST ? conditions->lost", "entry.word == LOST ? conditions->lost & 0x3"),
    "ends unasked": ("if (!my1016_protection_state.asked ||", "if (false ||"),
    "asked once for ever": ("    state->asked = 0;\n", ""),
    "the first time waits": ("? (uint32_t)pause << (*times - 1) : 0;", "? (uint32_t)pause << (*times - 1) : pause;"),
    "a pause does not grow": ("(uint32_t)pause << (*times - 1)", "(uint32_t)pause"),
    "a pause is not kept": ("_state.left[slot])", "_state.left[slot] > 60000u)"),
    "times are not forgotten": ("        --*times;\n", ""),
    "times grow for ever": ("(*times < MOST_TIMES)", "(*times < 255)"),
    "what goes on is forgotten": ("} else if (!acts && *times > 0) {", "} else if (*times > 0) {"),
    "what has ended is forgotten at once": (
        "*left = FORGOTTEN;\n    } else if (*left > 0) {",
        "*left = 0;\n    } else if (*left > 0) {",
    ),
    "one pause for all": ("            ++slot;\n", ""),
    "what stands is not waited for": ("acts && left > waiting", "!acts && left > waiting"),
    "ends hot": ("entry.until == BY_COMMAND ||", "true ||"),
    "cool at the limit": (
        "sample->measured_mC[entry.component] < entry",
        "sample->measured_mC[entry.component] <= entry",
    ),
    "cool unseen": ("((sample->valid >> entry.component) & 1u)", "true"),
    "ends while its cause holds": (
        "        state->holding |= bit;\n",
        "        state->holding |= bit;\n        if (state->asked) { state->acting &= ~bit; }\n",
    ),
    "everything outlives a reset": ("_state.acting |= acting & LASTING;", "_state.acting |= acting;"),
    "the last limit counts": ("most = pwm < most ? pwm : most;", "most = pwm;"),
    "the LED tells of all": ("& SHOWING) != 0", ") != 0"),
    "every stop opens the relay": ("& OPENING) != 0", ") != 0"),
}


@pytest.mark.campaign
@pytest.mark.parametrize("fault", share(FAULTS.values()), ids=share(FAULTS))
def test_a_planted_fault_is_caught(fault: tuple[str, str], tmp_path: Path) -> None:
    found = difference(library().written(tmp_path, "_protection.cpp", fault), PROTECTION, given())
    assert found is not None
    assert found.differing > 0
