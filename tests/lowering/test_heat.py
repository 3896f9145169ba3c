"""Rules on missing heat: what the board holds of them, turned back into the units of the file by hand."""

from __future__ import annotations

import pytest

from gen.coefficients.alarms import MissingHeat
from gen.lowering.alarms import lower_alarms
from tests.examples import example

WORDS_PER_K = 16_000.0
"""Sixteenths of a thousandth of a kelvin; sums that fade by shares of a block have 8 bits more."""


def test_the_words_of_a_rule_are_its_numbers_in_the_file() -> None:
    coefficients = example("my1016_rig")
    found = [
        (rule, lowered.heat)
        for rule, lowered in zip(coefficients.document.alarms, lower_alarms(coefficients), strict=True)
        if isinstance(rule, MissingHeat)
    ]
    assert found
    for rule, heat in found:
        assert heat is not None
        block_s = heat.block * coefficients.model.sample_time
        per_hour = WORDS_PER_K * block_s / 3600.0  # of 1 K/h in a block
        assert block_s == pytest.approx(20.0)
        assert heat.slack == pytest.approx(rule.slack_K_per_h * per_hour, abs=0.5)
        assert heat.unknown == pytest.approx(rule.unknown_K_per_h * per_hour, abs=0.5)
        assert heat.start / 256.0 == pytest.approx(rule.unsettled.at_start_K_per_h * per_hour, abs=0.5)
        assert heat.change * 255 / 256.0 == pytest.approx(rule.unsettled.per_change_K_per_h * per_hour, abs=0.5)
        assert heat.limit == pytest.approx(rule.threshold_K * WORDS_PER_K, abs=0.5)
        assert heat.change > 0
        assert heat.start > 0
