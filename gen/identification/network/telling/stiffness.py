"""Paths that are faster than a board's steps, made as fast as it can follow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import FloatArray


def slowed(
    conductance: FloatArray, paths: Sequence[tuple[int, int]], capacity: FloatArray, least_s: float
) -> FloatArray:
    """Limit each path so that the two ends, by themselves, come together with a time constant of `least_s` at least.

    Two capacities C and D with a conductance G between them do so with C D / ((C + D) G). Runs tell nodes that are
    together within seconds from one only by chance, so such a G may have come to anything, and one for speeds that
    were not run to much more.

    Parameters
    ----------
    conductance
        W/K, shape (B, Q).
    paths
        The nodes of each, -1 for the ambient, whose capacity is infinite.
    capacity
        J/K, shape (N,).
    least_s
        Time constant, s.

    Returns
    -------
    FloatArray
        W/K, shape (B, Q).
    """
    inverse = np.append(1.0 / capacity, 0.0)  # the ambient's, at -1
    most = np.array([1.0 / (least_s * (inverse[i] + inverse[j])) for i, j in paths])
    return np.asarray(np.minimum(conductance, most), dtype=np.float64)
