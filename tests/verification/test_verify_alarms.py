"""The emitted alarm rules against their reference, on the host and on the emulated board, and with planted faults."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from gen.lowering.alarms import LoweredRule, lower_alarms
from gen.verification.alarm_campaign import alarm_profile, campaign
from gen.verification.comparisons import ALARMS, compare_alarms
from tests.campaign import share
from tests.examples import ROOT
from tests.verification.planted import Campaign, Emitted, difference, emitted

LANES, LENGTH = 20, 1000


@cache
def library() -> Emitted:
    return emitted((ROOT / "examples" / "two_mass" / "coeffs.json").read_text(encoding="utf-8"), "float")


@cache
def rules() -> tuple[LoweredRule, ...]:
    return lower_alarms(library().coefficients)


@cache
def given() -> Campaign:
    program = library().program
    return campaign(program, rules(), alarm_profile(program, rules(), LANES, LENGTH))


def test_the_campaign_takes_every_rule_through_every_state() -> None:
    expected = given().expected
    for number, rule in enumerate(rules()):
        always_awake = rule.settle == 0 and rule.requires is None and not rule.needs_model
        for mask in ("latched", "active") if always_awake else ("latched", "active", "asleep"):
            bits = (expected[mask] >> number) & 1
            assert bits.any(), f"{rule.name} never {mask}"
            assert not bits.all(), f"{rule.name} always {mask}"
        released = np.diff(((expected["latched"] >> number) & 1).astype(np.int8), axis=1)
        assert (released < 0).any(), f"{rule.name} never reset"


def test_no_word_differs_on_any_target(tmp_path: Path) -> None:
    hosts = ("g++ -O2", "clang++ sanitized")
    for name, expected, found in compare_alarms(library().written(tmp_path), rules(), LANES, LENGTH, hosts, board=True):
        assert found is None, f"{name}: {found}"
        assert expected.size == LANES * LENGTH


FAULTS = {
    "threshold met counts": ("return value > (timers", "return value >= (timers"),
    "no hysteresis": ("timers->held ? segment.clear : segment.trip", "segment.trip"),
    "late by a sample": ("if (timers->held > rule.persistence) {", "if (timers->held > rule.persistence + 1u) {"),
    "limits look no further ahead than they see": ("AHEAD * sample->rising_mK", "0 * sample->rising_mK"),
    "what is far over a limit waits": ("(value - segment.trip) / HASTE_MK", "(value - value) / HASTE_MK"),
    "what is a kelvin over a limit waits": ("1u + (uint32_t)(value", "(uint32_t)(value"),
    "16-bit sum": ("const int32_t sum = timers->sum + (value", "const int32_t sum = (int16_t)timers->sum + (value"),
    "sum below zero": ("sum < 0 ? 0 : ", ""),
    "missing samples are used": (
        "return ((sample->valid >> rule.component) & 1u)",
        "return ((sample->valid >> rule.component) != 0xFFFFu)",
    ),
    "other part's missing samples are used": ("&& (rule.relative_to == NONE ||", "&& (true ||"),
    "limits heed only what is believed": ("(sample->valid | sample->plausible)", "(sample->valid | 0u)"),
    "limits take what is not plausible": ("(sample->valid | sample->plausible)", "(sample->valid | 0xFFFFu)"),
    "limits forget what is believed": ("(sample->valid | sample->plausible)", "(sample->plausible | 0u)"),
    "all rules take what is plausible": (
        "if (rule.quantity == MEASURED) {\n        return (",
        "if (true) {\n        return (",
    ),
    "other part not subtracted": ("if (rule.relative_to != NONE) {\n", "if (false) {\n"),
    "excluding alarm ignored": ("(rule.unless == NONE ||", "(true ||"),
    "reset begins a limit's persistence anew": ("quantity) != MEASURED) {", "quantity) != 255) {"),
    "reset keeps the sum": ("timers[rule].sum = 0", "timers[rule].sum += 0"),
    "range open at its end": ("pwm <= segment->high", "pwm < segment->high"),
    "required alarm ignored": ("return !slept && (rule.requires == NONE ||", "return !slept && (true ||"),
    "settling survives standstill": ("if (!inside) {", "if (false) {"),
}


@pytest.mark.campaign
@pytest.mark.parametrize("fault", share(FAULTS.values()), ids=share(FAULTS))
def test_a_planted_fault_is_caught(fault: tuple[str, str], tmp_path: Path) -> None:
    found = difference(library().written(tmp_path, "_alarms.cpp", fault, most=9), ALARMS, given())
    assert found is not None
    assert found.differing > 0
