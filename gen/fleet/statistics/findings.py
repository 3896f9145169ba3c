"""A hypothesis that is sure, and the robust statistics by which it is.

The scale s is 1.4826 MAD (of normal amounts the standard deviation; Rousseeuw and Croux, JASA 88, 1993); a median's
standard error is 1.2533 s / sqrt(M), 1.2533 = sqrt(pi / 2). The limit is Student's t with 0.37 (M - 1) degrees of
freedom: a MAD tells a normal scale as well as a standard deviation of 0.37 times as many would (ibid.).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray

EFFICIENCY = 0.37
"""Of the MAD as a normal scale."""
MEDIAN_ERROR = float(np.sqrt(np.pi / 2.0))
"""Of a median, in standard errors of a mean."""
LEAST_K = 0.25
"""What explains less of a residual (root mean square) is no finding, however sure: a step of the converter."""


@dataclass(frozen=True)
class Finding:
    """A hypothesis with its amount.

    Attributes
    ----------
    place
        Of the hypothesis.
    amount
        Of it: a share of the motor's heat, K, or a share of the rise.
    score
        In standard deviations.
    explained_K
        Root mean square of what it explains, K.
    """

    place: int
    amount: float
    score: float
    explained_K: float


def limit_of(motors: int, hypotheses: int, level: float) -> float:
    """Give the limit, in standard deviations."""
    from scipy.stats import t

    return float(t.isf(level / (4.0 * hypotheses), EFFICIENCY * (motors - 1)))


def spread(away: FloatArray) -> FloatArray:
    """Give the scale over the motors of what is away from their centre, shape (M, H) to (H,)."""
    return np.asarray(np.maximum(1.4826 * np.median(np.abs(away), axis=0), 1e-9))


def best(score: FloatArray, amount: FloatArray, explained: FloatArray, limit: float) -> Finding | None:
    """Of all hypotheses that are sure, shape (H,) each, give the one that explains most; None where none is."""
    good = (np.abs(score) > limit) & (explained > LEAST_K)
    if not good.any():
        return None
    place = int(np.argmax(np.where(good, explained, -1.0)))
    return Finding(place, float(amount[place]), float(score[place]), float(explained[place]))
