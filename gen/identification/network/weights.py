"""How much each reading counts: by the spectral density of what is left, not by a single reading's noise.

Errors that last for minutes tell less than independent ones; their density at low frequency says how much less. A bin
counts by the time that its readings cover.
"""

from __future__ import annotations

import numpy as np

from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Inputs

WINDOW_S = 600.0
"""Errors are averaged over this time (or an eighth of the run); the scatter of the means is the density."""
FIRST_S = 60.0
"""Before any fit, errors are taken to last for this long."""


def first_density(inputs: Inputs) -> FloatArray:
    """Give the density that noise and quantisation alone would have, shape (S,), K^2 s."""
    noise = np.array([run.noise_K for run in inputs.runs])
    sample = np.array([run.sample_s for run in inputs.runs])
    return np.asarray(np.mean((noise**2 + 0.05**2) * np.maximum(sample, FIRST_S), axis=0))


def density(inputs: Inputs, residual: FloatArray) -> FloatArray:
    """Give the density of what a fit leaves, shape (S,), K^2 s, not below that of independent noise.

    Parameters
    ----------
    residual
        Shape (R, T, S), K.
    """
    sensors = inputs.target.shape[2]
    found = np.empty(sensors)
    for s in range(sensors):
        total = time = floor = 0.0
        for r, run in enumerate(inputs.runs):
            k = run.width.size
            window = min(WINDOW_S, max(run.duration / 8.0, 1.0))
            index = (run.edges[:-1] // window).astype(np.int64)
            cover = run.covered[:, s]
            sums = np.bincount(index, residual[r, :k, s] * cover)
            total += float(np.sum(sums**2))
            time += float(cover.sum())
            floor += float(cover.sum()) * (run.noise_K[s] ** 2 * run.sample_s[s] + 0.02**2 * FIRST_S)
        found[s] = max(total, floor) / time if time > 0.0 else 1.0
    return found


def weights(inputs: Inputs, of: FloatArray) -> FloatArray:
    """Give the readings' weights, shape (R, T, S), 1/K^2.

    Parameters
    ----------
    of
        Density, shape (S,), K^2 s.
    """
    made = np.zeros_like(inputs.target)
    for r, run in enumerate(inputs.runs):
        made[r, : run.width.size] = run.covered / of
    return made
