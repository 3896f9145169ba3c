"""Byte products, words of degrees and factors against exact arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.arrays import IntArray
from gen.errors import CheckFailed
from gen.lowering.network.factors import WORD_BITS, lower_factor, scaled
from gen.lowering.network.series import CHOICES, FIRST, WHOLE, Product
from gen.lowering.network.start import degrees, scale_of
from gen.model.network_parts import Channel, Factor

PRODUCTS = sorted(
    {WHOLE, FIRST, *(p for choice in CHOICES.values() for p in choice)}, key=lambda p: p.name + str(p.cut)
)


def one(value: int) -> IntArray:
    return np.array([value], dtype=np.int64)


@pytest.mark.parametrize("product", PRODUCTS, ids=lambda p: f"{p.name}{'cut' if p.cut else ''}")
@given(data=st.data())
def test_a_product_leaves_out_no_more_than_is_said(product: Product, data: st.DataObject) -> None:
    half = 2 ** (8 * product.width - 1)
    d = data.draw(st.one_of(st.integers(-half, half - 1), st.sampled_from([-half, -1, 0, half - 1])))
    a = data.draw(st.one_of(st.integers(0, 2 * half - 1), st.sampled_from([0, 0xFF, 2 * half - 1])))
    left_out = Fraction(d * a, 2 ** (8 * product.unit)) - int(product.of(one(d), one(a))[0])
    assert 0 <= left_out <= product.dropped


@given(st.integers(10, 24), st.integers(-100_000, 120_000))
def test_a_word_of_degrees_is_the_nearest_but_for_a_hair(bits: int, thousandths: int) -> None:
    exact = Fraction(thousandths * 2**bits, 1000)
    if abs(exact) < 2**31:
        assert abs(int(degrees(one(thousandths), scale_of(bits))[0]) - exact) <= 0.8


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**WORD_BITS))
def test_a_scaled_word_is_short_of_the_exact_one_by_little_more_than_a_unit(word: int, factor: int) -> None:
    short = Fraction(word * factor, 2**WORD_BITS) - int(scaled(one(word), one(factor))[0])
    assert 0 <= short <= 1.1


@pytest.mark.parametrize(
    "factor",
    [
        Factor("told", polynomial=(0.003, -0.4, 2.0), at=(), value=()),
        Factor("told", polynomial=(), at=(-5.0, 0.25, 3.0, 80.0), value=(0.1, 1.7, 0.4, 12.5)),
        Factor("told", polynomial=(), at=(-9.0, 0.25, 79.99, 1e6), value=(9.0, 1.7, 0.4, 1e9)),
        Factor("told", polynomial=(), at=(90.0, 91.0), value=(3.0, 1e6)),
    ],
    ids=["polynomial", "table", "a table that is steep where the channel is not", "a table beyond the channel"],
)
def test_a_factor_is_within_its_error_of_the_exact_one_everywhere(factor: Factor) -> None:
    channel = Channel("told", -5.0, 80.0, 0.0)
    told = np.arange(-5000, 80_001, 5, dtype=np.int64)
    exact = np.maximum(np.asarray(factor(told / 1000.0)), 0.0)
    program = lower_factor(factor, (channel,), float(exact.max()), 0)
    off = np.abs(program.word(told) * 2.0**-program.bits - exact)
    assert off.max() <= program.error
    assert program.error < 1e-6 * exact.max()


def test_a_channel_of_more_thousandths_than_a_board_counts_is_refused_in_one_line() -> None:
    channel = Channel("pressure_Pa", -1.5e6, 1.5e6, 0.0)
    for factor in (
        Factor("pressure_Pa", at=(0.0, 1e6), value=(1.0, 2.0)),
        Factor("pressure_Pa", polynomial=(1e-6, 1.0)),
    ):
        with pytest.raises(CheckFailed, match=r"range: 3000000000 thousandths .* write pressure_Pa in a larger unit"):
            lower_factor(factor, (channel,), 3.0, 0)
