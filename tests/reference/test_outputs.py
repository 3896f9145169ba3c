"""What is given out in thousandths of a kelvin is the word's value to nearest."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example as with_example
from hypothesis import given
from hypothesis import strategies as st

from gen.lowering.kinds import Arithmetic
from gen.lowering.lower import lower
from gen.reference.model import ReferenceModel
from gen.reference.thousandths import thousandths
from tests.examples import example


@given(word=st.integers(-(2**31), 2**31 - 1), bits=st.integers(10, 31))
@with_example(word=(1 << 23) - 1, bits=23)
@with_example(word=-1, bits=31)
def test_it_is_within_half_a_thousandth(word: int, bits: int) -> None:
    (found,) = thousandths(np.array([word]), bits)
    off = abs(int(found) - Fraction(word * 1000, 1 << bits))
    cut = Fraction(1000, 1 << 25) if bits > 25 else 0  # the board multiplies in 32 bits
    assert off <= Fraction(1, 2) + cut


@given(rise_mK=st.integers(-60_000, 160_000))
@with_example(rise_mK=57_123)
def test_a_start_is_read_back_as_it_was_told(rise_mK: int) -> None:
    for bits in (20, 23, 24):
        word = round(Fraction(rise_mK << bits, 1000))
        assert thousandths(np.array([word]), bits).tolist() == [rise_mK]


@pytest.mark.parametrize("arithmetic", ["fixed", "float"])
@pytest.mark.parametrize("name", ["my1016", "two_mass"])
def test_the_model_s_outputs_are_its_words_to_nearest(name: str, arithmetic: Arithmetic) -> None:
    program = lower(example(name), arithmetic, "table")
    random = np.random.default_rng(3)
    starts = random.integers(-9_000, 60_000, 40)
    board = ReferenceModel(program, starts.tolist())
    assert np.array_equal(board.rises_mK, np.tile(starts, (len(program.components), 1)))
    for _ in range(60):
        board.step(random.integers(-255, 256, 40))
        assert np.abs(board.rises * 1000.0 - board.rises_mK).max() <= 0.5001
    assert np.ptp(board.rises * 1000.0 - board.rises_mK) > 0.9  # both sides
