"""How much each reading counts: by the spectral density of what is left, not by a single reading's noise.

Errors that last for minutes tell less than independent ones, and such that last for hours (the sun, a neighbour, a load
that nobody logged) less again; their density at low frequency says how much less. A bin counts by the time that its
readings cover.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.bins import Binned
from gen.identification.network.fitting.inputs import Inputs

WINDOW_S = 600.0
"""Errors are averaged over this time (or an eighth of the run) or longer; the scatter of the means is the density."""
LEAST_K, LEAST_S = 0.05, 600.0
"""No residual is taken for better than errors of this size that last for this long."""


def independent(run: Binned) -> FloatArray:
    """Give the density of errors that no fit undercuts: the sensors' noise, and `LEAST_K`; shape (S,), K^2 s."""
    return np.asarray(np.nan_to_num(run.noise_K) ** 2 * np.nan_to_num(run.sample_s) + LEAST_K**2 * LEAST_S)


def slow_density(inputs: Inputs, residual: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Give the density where it is largest: over `WINDOW_S`, or windows twice as long, up to an eighth of a run.

    Longer ones leave too few means in a run: with a quarter some motors' weights and misfit drove each other up.

    Parameters
    ----------
    residual
        Shape (N, S), K.

    Returns
    -------
    density, window_s
        Shapes (S,), K^2 s, and the length at which it is, s.
    """
    longest = max(window_s(run.duration, np.inf) for run in inputs.runs)
    lengths = WINDOW_S * 2.0 ** np.arange(1 + max(0, int(np.log2(longest / WINDOW_S))))
    each = np.array([density(inputs, residual, length) for length in lengths])
    return each.max(axis=0), lengths[each.argmax(axis=0)]


def density(inputs: Inputs, residual: FloatArray, length_s: float = WINDOW_S) -> FloatArray:
    """Give the density of what a fit leaves, shape (S,), K^2 s, not below that of independent noise.

    Parameters
    ----------
    residual
        Shape (N, S), K.
    length_s
        Over which errors are averaged.
    """
    sensors = inputs.target.shape[1]
    found = np.empty(sensors)
    least = [independent(run) for run in inputs.runs]
    for s in range(sensors):
        total = time = floor = 0.0
        for run, row, lowest in zip(inputs.runs, inputs.rows, least, strict=True):
            window = window_s(run.duration, length_s)
            index = (inputs.begins[row] // window).astype(np.int64)
            cover = inputs.covered[row, s]
            sums = np.bincount(index, residual[row, s] * cover)
            total += float(np.sum(sums**2))
            time += float(cover.sum())
            floor += float(cover.sum()) * float(lowest[s])
        found[s] = max(total, floor) / time if time > 0.0 else 1.0
    return found


def window_s(duration: float, length_s: float) -> float:
    """Give the time over which the errors of a run so long are averaged, s."""
    return min(length_s, max(duration / 8.0, 1.0))


def windows(inputs: Inputs, lengths_s: FloatArray) -> FloatArray:
    """Give how many windows of some lengths, shape (S,), each sensor's readings cover, shape (S,)."""
    made = np.zeros(inputs.target.shape[1])
    for run, row in zip(inputs.runs, inputs.rows, strict=True):
        made += inputs.covered[row].sum(axis=0) / [window_s(run.duration, length) for length in lengths_s]
    return made


def weights(inputs: Inputs, of: FloatArray) -> FloatArray:
    """Give the readings' weights, shape (N, S), 1/K^2.

    Parameters
    ----------
    of
        Density, shape (S,), K^2 s.
    """
    return inputs.covered / of
