"""What the tools cost on this computer: what is counted, not how much it is."""

from __future__ import annotations

import sys

import pytest

from benchmarks.rivals.host import Rate, Start, process, rates_table, starts_table
from gen.errors import CheckFailed


def test_a_process_is_told_with_its_own_memory() -> None:
    seconds, small = process([sys.executable, "-c", "pass"], 1)
    _, large = process([sys.executable, "-c", "held = bytearray(100 * 2**20)"], 1)
    assert seconds > 0.0
    assert 95.0 < large - small < 110.0


def test_a_process_that_fails_is_no_figure() -> None:
    with pytest.raises(CheckFailed, match="ends with 3"):
        process([sys.executable, "-c", "raise SystemExit(3)"], 1)


def test_tables_have_multiples_and_memory() -> None:
    (cells,) = zip(*(column.cells for column in rates_table([Rate("reference", 15.31)]).columns), strict=True)
    assert cells == ("reference", "x 15.3")
    (cells,) = zip(*(column.cells for column in starts_table([Start("gen build", 12.4, 99.6)]).columns), strict=True)
    assert cells == ("`gen build`", "x 12", "100 MB")
