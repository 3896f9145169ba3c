"""Bins of a long run."""

from __future__ import annotations

import numpy as np

from gen.refinement.condense import _bins


def test_bins_of_a_long_run_are_minutes_from_its_beginning_on() -> None:
    """What is left at the end is a shorter one."""
    time = 1000.0 + 10.0 * np.arange(2004.0)  # 20 030 s: 333 minutes and 50 s
    index, edges = _bins(time, np.full(2004, 100))
    assert edges[:-1].tolist() == [1000.0 + 60.0 * minute for minute in range(334)]
    assert edges[-1] == time[-1]
    assert np.bincount(index).tolist() == [6] * 333 + [6]


def test_a_last_row_alone_ends_the_bin_before_it() -> None:
    time = 10.0 * np.arange(2401.0)
    index, edges = _bins(time, np.full(2401, 100))
    assert np.bincount(index).tolist() == [6] * 399 + [7]
    assert edges[-2:].tolist() == [23_940.0, 24_000.0]
