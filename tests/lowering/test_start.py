"""Starts: what the proof counts for them is the worst of every one, and no more than half a unit or so."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import example as with_example
from hypothesis import given, settings
from hypothesis import strategies as st

from gen.coefficients import Coefficients, parse
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.fixed.start import start_error, start_scale
from gen.lowering.float32.start import start_accumulator
from gen.lowering.float32.start import start_error as single_start_error
from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.lowering.start import LARGEST_MK
from gen.reference.model import ReferenceModel
from gen.verification.accuracy import error_course
from tests.examples import ROOT


def hot(highest_degC: float) -> Coefficients:
    """One part of order 1 whose declared temperatures go far beyond what drives it."""
    document: dict[str, Any] = json.loads((ROOT / "examples" / "two_mass" / "coeffs.json").read_text())
    document["components"] = [
        {"name": "part", "order": 1, "gain": {"poly": [0.470588]}, "poles": [{"real": {"poly": [-0.3]}}]}
    ]
    document |= {"sample_time_s": 0.25, "ambient": {"fixed_degC": -20}, "alarms": [], "wiring": {}}
    document["domain"] |= {"ambient_degC": [-20, -20], "temperature_degC": [-20, highest_degC]}
    for entry in ("provenance", "accuracy"):
        document.pop(entry, None)
    return parse(json.dumps(document).encode())


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("highest_degC", [940.0, 3970.0])
def test_no_start_of_a_wide_range_is_further_off_than_its_bound(arithmetic: Arithmetic, highest_degC: float) -> None:
    program = lower(hot(highest_degC), arithmetic, "table")
    (component,) = program.components
    assert component.proof is not None
    low, high = component.start_range_mK
    assert high == round(highest_degC + 20) * 1000
    asked = np.unique(np.r_[np.random.default_rng(5).integers(low, high, 3000), low, high, high - 894, high - 1])
    board = ReferenceModel(program, asked.tolist())
    assert np.abs(board.rises[0] - asked / 1000.0).max() < component.proof.bound_K
    assert np.array_equal(board.rises_mK[0], asked)
    assert error_course(program, lanes=6, length=50).largest()["part"] < component.proof.bound_K


@pytest.mark.parametrize("bits", [18, 19, 21, 23, 24, 25, 31])
def test_the_counted_error_is_the_worst_of_every_start_and_about_half_a_unit(bits: int) -> None:
    low, high = (-60_000, 160_000) if bits < 24 else (-15_000, 16_000) if bits < 31 else (0, 990)
    scale = start_scale(bits)
    worst = max(abs(Fraction(scale.word(r), 1 << bits) - Fraction(r, 1000)) for r in range(low, high + 1))
    assert worst <= Fraction(start_error(bits, (low, high))) <= worst * (1 + Fraction(1, 2**50))
    assert start_error(bits, (low, high)) <= 0.52 * 2.0**-bits


@pytest.mark.parametrize(("bits", "high"), [(18, 3_990_000), (23, 160_000)])
def test_the_float_s_counted_error_is_the_worst_of_every_start(bits: int, high: int) -> None:
    rises = np.arange(high - 200_000, high + 1) if high > 200_000 else np.arange(-60_000, high + 1)
    exact = rises.astype(np.longdouble) / 1000
    worst = np.abs(np.ldexp(start_accumulator(bits, rises).astype(np.longdouble), -bits - 8) - exact).max()
    counted = single_start_error(bits, (int(rises[0]), int(rises[-1])))
    assert worst * (1 - 1e-12) <= counted <= worst * (1 + 1e-9)
    assert counted <= 2.0 * high / 1000 * 2.0**-24


@settings(max_examples=500)
@given(bits=st.integers(12, 31), share=st.fractions(-1, 1))
@with_example(bits=18, share=Fraction(1))
@with_example(bits=18, share=Fraction(-1))
def test_the_board_s_steps_fit_32_bits(bits: int, share: Fraction) -> None:
    rise_mK = int(share * min(LARGEST_MK, (1000 << 31 - bits) - 1))
    scale = start_scale(bits)
    assert 0 <= scale.whole < 2**31
    assert max(scale.upper, scale.lower) < 2**16
    steps = [(rise_mK >> 8) * scale.upper, (rise_mK >> 8) * scale.lower, rise_mK * scale.whole, scale.word(rise_mK)]
    steps.append(steps[0] + ((rise_mK & 255) * scale.upper >> 8) + (steps[1] >> 16) + 128)
    assert all(-(2**31) <= step < 2**31 for step in steps)
    if rise_mK % 125 == 0 and bits >= 3:  # a whole number of units
        assert scale.word(rise_mK) * 1000 == rise_mK << bits


def test_the_example_s_starts_are_counted_as_they_are() -> None:
    program = lower(hot(940.0), "fixed", "table")
    (component,) = program.components
    assert isinstance(component, FixedComponent)
    counted = start_error(component.layout.output_bits, component.start_range_mK)
    asked = np.arange(component.start_range_mK[0], component.start_range_mK[1] + 1)
    board = ReferenceModel(program, asked.tolist())
    found = np.abs(board.rises[0] - asked / 1000.0).max()
    assert counted == pytest.approx(found, rel=1e-6)
