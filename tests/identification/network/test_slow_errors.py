"""Errors that last for hours tell less than ones of minutes: what fits leave is weighed by its slowest part."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.plants.disturbance import LASTS_S, disturbance
from gen.arrays import FloatArray
from gen.identification.network.fitting.bins import binned
from gen.identification.network.fitting.inputs import Inputs, inputs_of
from gen.identification.network.fitting.weights import WINDOW_S, density, independent, slow_density
from gen.runs import Run

HOURS, ROW_S = 12.0, 5.0
TIME_S: FloatArray = ROW_S * np.arange(int(HOURS * 3600.0 / ROW_S) + 1, dtype=np.float64)
SIGMA = 0.8


def inputs(runs: int) -> Inputs:
    pwm = np.full(TIME_S.size, 100, dtype=np.int64)
    temps = {"a": np.full(TIME_S.size, 40.0)}
    return inputs_of([binned(f"run {k}", Run(TIME_S, pwm, temps), ("a",), 25.0, 255) for k in range(runs)])


def in_bins(made: Inputs, courses: list[FloatArray]) -> FloatArray:
    """Means of each run's course over its bins, shape (N, 1)."""
    found = np.zeros((made.begins.size, 1))
    for row, run, course in zip(made.rows, made.runs, courses, strict=True):
        owner = np.clip(np.searchsorted(run.edges, TIME_S, side="right") - 1, 0, run.edges.size - 2)
        found[row, 0] = np.bincount(owner, course) / np.bincount(owner)
    return found


def of_means(window_s: float) -> float:
    """Density of means over a window of an Ornstein-Uhlenbeck process, by its integrated covariance, K^2 s."""
    share = window_s / LASTS_S
    return float(2.0 * SIGMA**2 * LASTS_S * (1.0 - (1.0 - np.exp(-share)) / share))


def test_what_lasts_for_an_hour_counts_by_its_density_over_longer_windows() -> None:
    made = inputs(24)
    residual = in_bins(made, [SIGMA * disturbance(TIME_S, 1, np.random.default_rng(k))[:, 0] for k in range(24)])
    assert density(made, residual)[0] == pytest.approx(of_means(WINDOW_S), rel=0.15)
    slow, window_s = slow_density(made, residual)
    assert window_s[0] == 8.0 * WINDOW_S  # the longest of which eight are in a run
    assert slow[0] == pytest.approx(of_means(8.0 * WINDOW_S), rel=0.2)
    assert slow[0] > 4.0 * density(made, residual)[0]


def test_of_noise_all_windows_say_the_same() -> None:
    made = inputs(4)
    size = 6.0 * np.sqrt(independent(made.runs[0])[0] / ROW_S)  # well above what is taken for the least
    residual = in_bins(made, [np.random.default_rng(k).normal(0.0, size, TIME_S.size) for k in range(4)])
    slow, _ = slow_density(made, residual)
    assert slow[0] == pytest.approx(size**2 * ROW_S, rel=0.4)


def test_the_disturbance_is_what_it_says() -> None:
    drawn = disturbance(10.0 * np.arange(200_000, dtype=np.float64), 2, np.random.default_rng(1))
    assert drawn.std(axis=0) == pytest.approx(1.0, rel=0.1)
    lag = round(LASTS_S / 10.0)
    assert np.mean(drawn[lag:, 0] * drawn[:-lag, 0]) == pytest.approx(np.exp(-1.0), abs=0.1)
    assert np.mean(drawn[:, 0] * drawn[:, 1]) == pytest.approx(0.64, abs=0.1)
