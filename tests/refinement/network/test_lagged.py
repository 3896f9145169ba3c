"""A sensor that lags: against the solution of lag y' = T - y on a ramp by hand, and its derivative by the lag."""

from __future__ import annotations

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.identification.network.fitting.bins import binned
from gen.identification.network.fitting.inputs import Inputs, inputs_of
from gen.refinement.network.changing.lagged import Lagged
from gen.runs import Run

LAG_S = 40.0


def two_runs() -> Inputs:
    """Of different lengths, whose PWM changes so that bins are of several widths."""
    made = []
    for rows in (300, 170):
        time = np.arange(0.0, 2.0 * rows, 2.0, dtype=np.float64)
        run = Run(
            time, np.where(time % 130.0 < 50.0, 200, 0).astype(np.int64), {"part": np.asarray(25.0 + 0.01 * time)}
        )
        made.append(binned(f"run {rows}", run, ["part"], 25.0, 255))
    return inputs_of(made)


def behind(inputs: Inputs, lag_s: float, change: FloatArray) -> FloatArray:
    return Lagged(inputs, 0, np.full(change.shape[0], lag_s)).behind(change)


def test_on_a_ramp_it_falls_behind_by_lag_times_slope_as_an_exponential() -> None:
    inputs = two_runs()
    slope = np.full(inputs.width.size, 0.05)
    read_at = inputs.begins + inputs.share[:, 0] * inputs.width
    expected = -LAG_S * 0.05 * (1.0 - np.exp(-read_at / LAG_S))
    assert behind(inputs, LAG_S, slope) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_its_derivative_by_the_lag_is_what_differences_give() -> None:
    inputs = two_runs()
    change = np.random.default_rng(3).normal(0.0, 0.05, inputs.width.size)
    h = 1e-3
    expected = (behind(inputs, LAG_S + h, change) - behind(inputs, LAG_S - h, change)) / (2.0 * h)
    found = Lagged(inputs, 0, np.full(change.size, LAG_S)).by_lag(change)
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-9)
