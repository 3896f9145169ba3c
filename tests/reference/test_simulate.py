"""`gen simulate` on run files as they are: gaps, clocks that start anywhere, measurements that come later."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from gen.arrays import FloatArray, IntArray
from gen.reference.simulate import simulate_run
from gen.runs import Run
from gen.runs.gaps import held_over_gaps
from tests.examples import example

NAN = float("nan")


def run(time_s: FloatArray, pwm: IntArray, ambient: FloatArray | None = None, **temps: FloatArray) -> Run:
    return Run(time_s, pwm, dict(temps), ambient)


@pytest.mark.parametrize(
    ("given", "held"),
    [
        ([1.0, NAN, NAN, 2.0, NAN], [1.0, 1.0, 1.0, 2.0, 2.0]),  # the board knows no later sample either
        ([NAN, NAN, 3.0, 4.0], [3.0, 3.0, 3.0, 4.0]),
        ([5.0], [5.0]),
    ],
)
def test_a_gap_keeps_the_latest_value_before_it(given: list[float], held: list[float]) -> None:
    assert held_over_gaps(np.array(given)).tolist() == held


@pytest.mark.parametrize("arithmetic", ["exact", "fixed"])
def test_a_run_starts_from_its_first_measured_temperature(arithmetic: Literal["exact", "fixed"]) -> None:
    time = np.arange(0.0, 5.0, 0.25)
    brush = np.where(time < 1.0, NAN, 40.0 + 2.0 * time)
    made = run(time, np.zeros(time.size, dtype=np.int64), np.full(time.size, 25.0), brush=brush)
    shown = simulate_run(example("my1016"), made, arithmetic, "auto", "run.csv")
    assert shown["brush_degC"][0] == pytest.approx(42.0, abs=1e-5)
    assert shown["casing_degC"][0] == pytest.approx(25.0, abs=1e-5)


@pytest.mark.parametrize("first", [0.1, 2.6, 5.7])
def test_the_board_s_samples_are_counted_from_the_run_s_first_row(first: float) -> None:
    """Decimal times are not exact in binary: a row on the grid must not be taken for one just before it."""
    time = np.arange(400, dtype=np.float64) * 0.25
    pwm = np.where(np.arange(400) % 7 < 3, 255, 0).astype(np.int64)
    plain = simulate_run(example("my1016"), run(time, pwm), "fixed", "ambient", "run.csv")
    moved = simulate_run(example("my1016"), run(np.round(first + time, 6), pwm), "fixed", "ambient", "run.csv")
    assert np.any(np.floor((np.round(first + time, 6) - first) / 0.25) != np.arange(400))  # else it would show nothing
    for name in plain:
        if name != "time_s":
            np.testing.assert_array_equal(plain[name], moved[name])
