"""What is drawn of a curve: its extremes, its gaps, and no more points than asked for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gen.arrays import FloatArray
from gen.drawing.thinning import line, lonely, steps
from gen.runs.gaps import gaps

DAY_AT_4_HZ = 24 * 3600 * 4


def curve(rows: int, seed: int, missing: float) -> tuple[FloatArray, FloatArray]:
    """Noise with spikes, of which some stretches and some single values are missing."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.uniform(0.9, 1.1, rows)) * 0.25
    values = np.cumsum(rng.normal(size=rows)) * 0.1 + rng.normal(size=rows)
    values[rng.integers(0, rows, max(1, rows // 200))] += rng.normal(size=max(1, rows // 200)) * 50.0
    values[rng.random(rows) < missing / 2.0] = np.nan
    for begin in rng.integers(0, rows, round(10 * missing)).tolist():
        values[begin : begin + rows // 30] = np.nan
    return time, values


@given(st.integers(2, 30_000), st.integers(0, 2**32), st.sampled_from([0.0, 0.1, 0.6]), st.integers(64, 5_000))
def test_every_stretch_shows_its_extremes(rows: int, seed: int, missing: float, most: int) -> None:
    time, values = curve(rows, seed, missing)
    x, y = line(time, values, most)
    assert x.size == y.size <= most
    assert np.all(np.diff(x) > 0.0)
    known = np.flatnonzero(np.isfinite(values))
    drawn = np.isfinite(y)
    # Nothing is invented: every point that is drawn is a row.
    rows_of = np.searchsorted(time, x[drawn])
    np.testing.assert_array_equal(time[rows_of], x[drawn])
    np.testing.assert_array_equal(values[rows_of], y[drawn])
    if not known.size:
        assert not drawn.any()
        return
    assert (x[drawn][0], x[drawn][-1]) == (time[known[0]], time[known[-1]])
    assert (np.max(y[drawn]), np.min(y[drawn])) == (np.max(values[known]), np.min(values[known]))
    # A window that is wider than two of the stretches shows at least what lies in its middle.
    wide = 2 * -(-known.size // max(1, (most // 2 - most // 8 * 3 // 2 - 2)))
    for begin in np.random.default_rng(seed).integers(0, known.size, 5).tolist():
        inner = values[known[begin : begin + wide]]
        low, high = time[known[max(0, begin - wide)]], time[known[min(known.size - 1, begin + 2 * wide)]]
        seen = y[drawn & (x >= low) & (x <= high)]
        assert seen.max() >= inner.max()
        assert seen.min() <= inner.min()


@pytest.mark.parametrize("rows", [500, DAY_AT_4_HZ])
@pytest.mark.parametrize("length", [1, 400])
def test_a_gap_stays_a_gap(rows: int, length: int) -> None:
    time = np.arange(rows, dtype=np.float64) * 0.25
    values = np.sin(time / 1000.0) + np.random.default_rng(0).normal(size=rows)
    values[40 : 40 + length] = np.nan
    x, y = line(time, values, 2_000)
    breaks = np.flatnonzero(np.isnan(y))
    assert breaks.size == 1
    assert x[breaks[0] - 1] == time[39]
    assert x[breaks[0] + 1] == time[40 + length]


def test_rows_that_are_not_there_are_a_gap_too() -> None:
    time = np.concatenate([np.arange(0.0, 100.0), np.arange(1000.0, 1100.0)])
    x, y = line(time, np.zeros(200), 1_000)
    assert x[np.isnan(y)].tolist() == [(99.0 + 1000.0) / 2.0]


@pytest.mark.parametrize("every", [2, 10, (0, 1, 3)])
def test_a_sensor_that_is_slower_than_the_rows_has_no_gaps(every: int | tuple[int, ...]) -> None:
    rows = np.arange(600)
    there = rows % every == 0 if isinstance(every, int) else np.isin(rows % 4, every)
    assert not gaps(rows.astype(np.float64) * 0.5, np.where(there, 20.0, np.nan)).any()


def test_an_irregular_log_has_no_gap_at_each_long_step() -> None:
    assert not gaps(np.array([0.0, 0.25, 7.3, 900.0, 1200.1]), np.zeros(5)).any()


def test_where_there_are_very_many_gaps_the_longest_are_kept() -> None:
    rows = 100_000
    values = np.where(np.arange(rows) % 20 == 0, np.nan, 1.0)
    values[5_000:6_000] = np.nan
    x, y = line(np.arange(rows, dtype=np.float64), values, 800)
    assert x.size <= 800
    wide = np.flatnonzero(np.isnan(y))
    assert any(x[k - 1] <= 5_000.0 <= 6_000.0 <= x[k + 1] for k in wide)


@given(st.integers(1, 3_000), st.integers(0, 2**32), st.integers(64, 900))
def test_what_is_held_is_drawn_with_upright_flanks(rows: int, seed: int, most: int) -> None:
    rng = np.random.default_rng(seed)
    time = np.arange(rows, dtype=np.float64) * 0.25
    values = np.repeat(rng.integers(-255, 256, rows), rng.integers(1, 9))[:rows].astype(np.float64)
    x, y = steps(time, values, most)
    assert x.size == y.size <= most
    assert (x[0], x[-1]) == (time[0], time[-1])
    assert (y.min(), y.max()) == (values.min(), values.max())
    if np.count_nonzero(np.diff(values)) + 1 <= most // 2:
        # At every moment between two rows the line is where the value is.
        between = (time[:-1] + time[1:]) / 2.0
        np.testing.assert_array_equal(np.interp(between, x, y), values[:-1])


def test_a_value_without_neighbours_is_a_dot() -> None:
    values = np.array([1.0, np.nan, 2.0, 3.0, np.nan, np.nan, 4.0])
    assert lonely(values).tolist() == [True, False, False, False, False, False, True]
