"""A random walk over blocks, and how likely it makes what is left: as fast a walk as makes the readings likeliest.

Kitagawa and Gersch, Smoothness priors analysis of time series, Springer 1996, ch. 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Inputs
from gen.refinement.network.over_time.courses import Blocks

WALKS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)
"""How far it may walk within `WALKED_S`, as shares of what is typical: standard deviations."""
WALKED_S = 600.0


@dataclass(frozen=True, eq=False)
class Walked:
    """The likeliest walk.

    Attributes
    ----------
    evidence
        Logarithm of the readings' likelihood over that without it.
    value, variance
        Of each block, shape (K,).
    relief
        Decrease of the weighed squares, its own improbability counted.
    """

    evidence: float
    value: FloatArray
    variance: FloatArray
    relief: float


def walked(own: FloatArray, right: FloatArray, inputs: Inputs, blocks: Sequence[Blocks], typical: float) -> Walked:
    """Fit each speed of the walk, and give the likeliest.

    Parameters
    ----------
    own, right
        Normal equations of the blocks, all other numbers at their best, shapes (K, K) and (K,).
    inputs
        The bins.
    blocks
        Of each run.
    typical
        Standard deviation of where it begins, in the unit of the values.
    """
    return max((_at(own, right, inputs, blocks, share * typical, typical) for share in WALKS), key=lambda w: w.evidence)


def _at(
    own: FloatArray, right: FloatArray, inputs: Inputs, blocks: Sequence[Blocks], walks: float, typical: float
) -> Walked:
    """Fit with one speed of the walk."""
    prior = np.zeros_like(own)
    logarithm = 0.0  # of the prior's determinant: that of a walk is the product over its steps
    for one in blocks:
        middle = one.mean(inputs.begins[one.rows], np.ones(one.rows.size))
        precision = WALKED_S / (walks**2 * np.maximum(np.diff(middle), 1.0))
        steps = np.diff(np.eye(one.count), axis=0)
        prior[one.at, one.at] = steps.T @ (precision[:, None] * steps)
        prior[one.first, one.first] += typical**-2
        logarithm += float(np.log(precision).sum()) - 2.0 * np.log(typical)
    lower = np.linalg.cholesky(own + prior)
    half = solve_triangular(lower, right, lower=True, check_finite=False)
    relief = float(half @ half)
    evidence = 0.5 * (relief + logarithm) - float(np.log(np.diag(lower)).sum())
    value = solve_triangular(lower.T, half, lower=False, check_finite=False)
    inverse = solve_triangular(lower, np.eye(right.size), lower=True, check_finite=False)
    return Walked(evidence, value, np.sum(inverse**2, axis=0), relief)
