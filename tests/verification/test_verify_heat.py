"""The emitted sums of missing heat against their reference, on the host and on the emulated board, faults planted."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from gen.lowering.alarms import LoweredRule, lower_alarms
from gen.verification.alarm_campaign import alarm_profile, campaign
from gen.verification.comparisons import ALARMS, compare_alarms
from tests.campaign import share
from tests.examples import ROOT
from tests.verification.planted import Campaign, Emitted, difference, emitted

NAME, LANES, LENGTH = "two_mass", 40, 1000
UNSETTLED = {"per_change_K_per_h": 300.0, "at_start_K_per_h": 200.0, "decay_s": [500, 90]}
RULES: list[dict[str, Any]] = [
    {
        "name": "both",
        "kind": "missing_heat",
        "component": "housing",
        "weights": {"housing": 0.6, "winding": -1.4},
        "slack_K_per_h": 3.0,
        "unknown_K_per_h": 5.0,
        "threshold_K": 0.4,
        "remembered_s": 900.0,
        "unsettled": UNSETTLED,
        "persistence_s": 1.0,
    },
    {
        "name": "winding_heat",
        "kind": "missing_heat",
        "component": "winding",
        "speed_percent": [30, 80],
        "slack_K_per_h": 1.0,
        "threshold_K": 0.1,
        "usual_s": 300.0,
        "unsettled": {**UNSETTLED, "per_change_K_per_h": 30.0, "decay_s": [20, 10]},
        "requires": "both",
    },
    {
        "name": "housing_heat",
        "kind": "missing_heat",
        "component": "housing",
        "slack_K_per_h": 1.0,
        "unknown_K_per_h": 5.0,
        "threshold_K": 0.1,
        "unsettled": UNSETTLED,
        "requires": "both",
        "unless": "winding_heat",
    },
    {
        "name": "housing_alone",
        "kind": "above_model",
        "component": "housing",
        "threshold_K": 0.2,
        "unless": "winding_heat",
    },
]


@cache
def rules() -> tuple[LoweredRule, ...]:
    return lower_alarms(library().coefficients)


@cache
def library() -> Emitted:
    tree = json.loads((ROOT / "examples" / NAME / "coeffs.json").read_text())
    return emitted(json.dumps({**tree, "alarms": [*RULES, tree["alarms"][0]]}), "fixed")


@cache
def given() -> Campaign:
    program = library().program
    return campaign(program, rules(), alarm_profile(program, rules(), LANES, LENGTH))


def test_no_word_differs_on_any_target_and_every_sum_is_full_now_and_then(tmp_path: Path) -> None:
    expected = given().expected
    for number in (0, 1):
        full = (expected["active"] >> number) & 1
        assert full.any(), rules()[number].name
        assert not full.all(), rules()[number].name
        assert (expected[f"heat.{number}.waited"] > 0).any()
    hosts = ("g++ -O2", "clang++ sanitized")
    for name, expected, found in compare_alarms(library().written(tmp_path), rules(), LANES, LENGTH, hosts, board=True):
        assert found is None, f"{name}: {found}"
        assert expected.size == LANES * LENGTH


FAULTS = {
    "16-bit mean": ("(int64_t)part.sum * PER_mK", "(int64_t)(int16_t)part.sum * PER_mK"),
    "first block is a rise": ("part.known ? mean - part.mean : 0", "mean - part.mean"),
    "nothing is lost": ("(moved[term.part] + lost)", "(moved[term.part] + 0 * lost)"),
    "weights have no sign": ("term.weight * (", "(uint8_t)term.weight * ("),
    "rounded towards zero": ("return value >> bits;", "return value / ((int64_t)1 << bits);"),
    "a missing part counts": ("state.parts[term.part].count > 0", "state.parts[0].count > 0"),
    "the usual is learnt twice": ("sums.usual += (rate", "sums.usual += 2 * (rate"),
    "learns while unsettled": ("if (is_settled(unsettled, slack))", "if (true)"),
    "memory too long": ("sums.learnt < rule.memory", "sums.learnt <= rule.memory"),
    "unknown stays": ("(int32_t)PRIOR / (int32_t)sums.learnt", "(int32_t)PRIOR / (int32_t)(sums.learnt ? PRIOR : 1u)"),
    "speeds open at their end": ("magnitude <= rule.high", "magnitude < rule.high"),
    "pending is dropped": ("sums.pending = waiting ? pending : 0;", "sums.pending = 0;"),
    "what was usual before is forgotten at once": ("? sums.usual : faded;", "? sums.usual : sums.usual;"),
    "and may lie below what is": (" || faded < sums.usual", ""),
    "remembers a block late": ("sums.learnt < rule.told", "sums.learnt <= rule.told"),
    "forgets nothing": ("sums.before - shifted(above", "sums.before - shifted(0 * above"),
    "slowing down is no change": ("state.pwm - now : now - state.pwm", "0 : now - state.pwm"),
    "sum without an end": ("0, 2 * rule.limit)", "0, INT32_MAX)"),
    "block too long": ("if (++state.samples < BLOCK)", "if (++state.samples <= BLOCK)"),
    "reset forgets nothing": ("        rule.sum = 0;\n", "        rule.sum += 0;\n"),
    "unsettled without an end": ("unsettled > MOST_UNSETTLED ? MOST_UNSETTLED : unsettled", "unsettled"),
}


SILENCE = {
    "silence says no at once": ("settled ? others : (uint16_t)(others | bit)", "others"),
    "and never": ("settled ? others : (uint16_t)(others | bit)", "(uint16_t)(others | bit)"),
    "it says no while unsettled": ("return settled && !(", "return !("),
    "and if it was unsettled": ("!(two_mass_alarm_state.deaf & bit)", "true"),
    "and if it spoke": (" && !raised(rule.unless);\n}", ";\n}"),
    "it is noted after the alarm, too": ("if (rule.requires == NONE || !raised(rule.requires)) {", "if (true) {"),
    "it is never noted without one": ("if (rule.requires == NONE || !raised", "if (rule.requires != NONE && !raised"),
    "it says no right after a start": (".deaf = two_mass_alarm_state.asleep;", ".deaf = 0;"),
}
"""Of what a silent sum says about another fault."""


@pytest.mark.campaign
@pytest.mark.parametrize("fault", share([*FAULTS.values(), *SILENCE.values()]), ids=share([*FAULTS, *SILENCE]))
def test_a_planted_fault_is_caught(fault: tuple[str, str], tmp_path: Path) -> None:
    planted = library().written(tmp_path, "_alarms.cpp" if fault in SILENCE.values() else "_heat.cpp", fault)
    found = difference(planted, ALARMS, given())
    assert found is not None
    assert found.differing > 0
