"""How far a figure may be off: noise that forgets itself slowly, and what a quantiser leaves in a mean."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gen.arrays import FloatArray
from gen.identification.logs.records import Record
from gen.identification.parts.general import General, Option
from gen.identification.parts.output_error import OutputErrorFit, OutputErrorProblem
from gen.identification.parts.uncertainty import residual_noise, uncertainty

SAMPLE_S, WIDTH_S = 2.0, 40.0


def record(noise_K: float = 0.0, quantum_K: float = 0.0, blocks: int = 200) -> Record:
    """One row a block of 40 s, with 20 samples each."""
    made = SimpleNamespace(
        time=(np.arange(blocks) + 0.5) * WIDTH_S,
        duration=blocks * WIDTH_S,
        count=np.full(blocks, WIDTH_S / SAMPLE_S),
        weight=np.ones(blocks),
        noise_K=noise_K,
        quantum_K=quantum_K,
        sample_s=SAMPLE_S,
    )
    return cast(Record, made)


def test_correlation_counts_to_both_sides() -> None:
    """A square wave of four blocks up and four down: 1/2 with its neighbours, on both sides, then no more.

    Its correlation is 1/2 at a lag of one block, 0 at two, -1/2 at three: the spectral density is the variance times
    1 + 2/2 = 2 block lengths. Of 200 blocks there are 199 and 198 products, which make 101/200 and 2/200 of these.
    """
    residual = np.tile([1.0] * 4 + [-1.0] * 4, 25)
    assert residual_noise(record(), residual, 0.0).density == pytest.approx((1.0 + 2.0 * (101 + 2) / 200) * WIDTH_S)


def test_parameters_that_were_paid_for_are_degrees_of_freedom_lost() -> None:
    residual = np.tile([1.0, -1.0], 100)
    noise = residual_noise(record(), residual, 50.0)
    assert noise.density == pytest.approx(WIDTH_S * 200.0 / 150.0)


def test_a_sensor_s_noise_is_the_least_density() -> None:
    noise = residual_noise(record(noise_K=0.3), np.zeros(200), 0.0)
    assert noise.density == pytest.approx(0.3**2 * SAMPLE_S)


def deviations(offset: bool, *quanta_K: float) -> FloatArray:
    """Standard deviations of a time constant, two steady rises (and an offset), for records of these quanta."""
    size = 4 if offset else 3
    layout = SimpleNamespace(size=size, thetas=1, positive=(100, 200), offset=offset)
    records = [record(quantum_K=quantum) for quantum in quanta_K]
    rows = np.arange(len(records) + 1) * 200
    jacobian = np.random.default_rng(3).normal(size=(int(rows[-1]), size))
    residuals = [0.01 * np.random.default_rng(r).normal(size=200) for r in range(len(records))]
    problem = SimpleNamespace(records=records, rows=rows)
    fit = SimpleNamespace(layout=layout, jacobian=jacobian, residuals=residuals)
    made = uncertainty(cast(OutputErrorProblem, problem), cast(OutputErrorFit, fit))
    return np.asarray(made.deviation)


@pytest.mark.parametrize("offset", [False, True])
def test_steady_rises_are_no_better_known_than_the_quantiser_allows(offset: bool) -> None:
    """Its error is the same in every sample of a steady state: however many there are, it stays (Widrow and Kollar).

    Without noise the error's first harmonic has the amplitude q/pi, a deviation of q/(pi sqrt 2) = 0.0563 K for a
    quarter of a kelvin; where an offset is read off the same sensor, twice that variance.
    """
    without, with_it = deviations(offset, 0.0, 0.0), deviations(offset, 0.0, 0.25)
    added = with_it**2 - without**2
    expected = (2.0 if offset else 1.0) * (0.25 / (np.pi * np.sqrt(2.0))) ** 2
    assert added[1:3] == pytest.approx([expected] * 2, rel=1e-9)
    assert added[[0, *range(3, added.size)]] == pytest.approx(0.0, abs=1e-15)
    assert with_it[1] > 5.0 * without[1], "else the quantiser would not matter here"


def test_the_chosen_option_is_the_first() -> None:
    """`options` hold the best first; what identification writes into the file is that one."""
    best, worse = cast(Option, SimpleNamespace()), cast(Option, SimpleNamespace())
    assert General((best, worse)).chosen is best
