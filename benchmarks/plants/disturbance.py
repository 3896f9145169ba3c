"""What moves a machine's temperatures for hours and stands in no log: the sun, a door, a neighbour."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
LASTS_S = 3600.0
"""Time constant of its correlation."""
COMMON, OWN = 0.8, 0.6
"""What all sensors have of it together, and each for itself."""


def disturbance(time_s: FloatArray, sensors: int, rng: np.random.Generator) -> FloatArray:
    """Draw Ornstein-Uhlenbeck processes of a standard deviation of 1.

    Parameters
    ----------
    time_s
        Ascending, shape (N,), s.
    sensors
        How many, S.
    rng
        Its chance.

    Returns
    -------
    FloatArray
        Shape (N, S).
    """
    kept = np.exp(-np.diff(time_s) / LASTS_S)
    drawn = rng.normal(size=(time_s.size, 1 + sensors))
    drawn[1:] *= np.sqrt(1.0 - kept**2)[:, None]
    for row in range(1, time_s.size):
        drawn[row] += kept[row - 1] * drawn[row - 1]
    return np.asarray(COMMON * drawn[:, :1] + OWN * drawn[:, 1:])
