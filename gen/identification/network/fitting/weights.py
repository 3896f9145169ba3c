"""How much each reading counts: by the spectral density of what is left, not by a single reading's noise.

Errors that last for minutes tell less than independent ones; their density at low frequency says how much less. A bin
counts by the time that its readings cover.
"""

from __future__ import annotations

import numpy as np

from gen.identification.network.fitting.bins import Binned, FloatArray
from gen.identification.network.fitting.inputs import Inputs

WINDOW_S = 600.0
"""Errors are averaged over this time (or an eighth of the run); the scatter of the means is the density."""
LEAST_K, LEAST_S = 0.05, 600.0
"""No residual is taken for better than errors of this size that last for this long."""


def independent(run: Binned) -> FloatArray:
    """Give the density of errors that no fit undercuts: the sensors' noise, and `LEAST_K`; shape (S,), K^2 s."""
    return np.asarray(np.nan_to_num(run.noise_K) ** 2 * np.nan_to_num(run.sample_s) + LEAST_K**2 * LEAST_S)


def density(inputs: Inputs, residual: FloatArray) -> FloatArray:
    """Give the density of what a fit leaves, shape (S,), K^2 s, not below that of independent noise.

    Parameters
    ----------
    residual
        Shape (N, S), K.
    """
    sensors = inputs.target.shape[1]
    found = np.empty(sensors)
    least = [independent(run) for run in inputs.runs]
    for s in range(sensors):
        total = time = floor = 0.0
        for run, row, lowest in zip(inputs.runs, inputs.rows, least, strict=True):
            window = window_s(run.duration)
            index = (inputs.begins[row] // window).astype(np.int64)
            cover = inputs.covered[row, s]
            sums = np.bincount(index, residual[row, s] * cover)
            total += float(np.sum(sums**2))
            time += float(cover.sum())
            floor += float(cover.sum()) * float(lowest[s])
        found[s] = max(total, floor) / time if time > 0.0 else 1.0
    return found


def window_s(duration: float) -> float:
    """Give the time over which the errors of a run so long are averaged, s."""
    return min(WINDOW_S, max(duration / 8.0, 1.0))


def windows(inputs: Inputs) -> FloatArray:
    """Give how many such windows each sensor's readings cover, shape (S,)."""
    made = np.zeros(inputs.target.shape[1])
    for run, row in zip(inputs.runs, inputs.rows, strict=True):
        made += inputs.covered[row].sum(axis=0) / window_s(run.duration)
    return made


def weights(inputs: Inputs, of: FloatArray) -> FloatArray:
    """Give the readings' weights, shape (N, S), 1/K^2.

    Parameters
    ----------
    of
        Density, shape (S,), K^2 s.
    """
    return inputs.covered / of
