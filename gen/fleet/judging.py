"""What all motors show in common, and what one alone does.

For motor m and hypothesis h with pattern p along its run, the amount is a = <p, r> / <p, p>. Over the fleet the centre
is c_h = median a, the scale s_h = 1.4826 MAD (of normal amounts the standard deviation; Rousseeuw and Croux, JASA 88,
1993). In common is what |c_h| / (1.2533 s_h / sqrt(M)) exceeds a limit for, 1.2533 = sqrt(pi / 2) for a median's
standard error; of those the one that explains most is taken off every residual. A motor is different where
|a - c_h| / s_h exceeds the limit, and of those hypotheses it is the one that explains most of its residual.

The limit is Student's t at level / (2 H), two-sided, H hypotheses on each of two models, with 0.37 (M - 1) degrees of
freedom: a MAD tells a normal scale as well as a standard deviation of 0.37 times as many would (ibid.). By Bonferroni's
inequality a healthy motor whose amounts are normal as the fleet's is called different in no more than
`level` of its runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.fleet.patterns import Products
from gen.fleet.pooling import FloatArray

EFFICIENCY = 0.37
"""Of the MAD as a normal scale."""
FEWEST = 8
"""Motors from which a scale is told."""
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


@dataclass(frozen=True, eq=False)
class Judged:
    """A fleet's residuals against one kind of model.

    Attributes
    ----------
    common
        What all motors show, or None.
    own
        By motor what it alone shows, or None.
    limit
        In standard deviations.
    """

    common: Finding | None
    own: tuple[Finding | None, ...]
    limit: float


def limit_of(motors: int, hypotheses: int, level: float) -> float:
    """Give the limit, in standard deviations."""
    from scipy.stats import t

    return float(t.isf(level / (4.0 * hypotheses), EFFICIENCY * (motors - 1)))


def judge(products: Sequence[Products], level: float) -> Judged:
    """Tell what is common from what is one motor's.

    Parameters
    ----------
    products
        Of each motor's newest run; at least :data:`FEWEST`.
    level
        Of false alarms, a run of a healthy motor.
    """
    gram = np.array([each.gram for each in products])
    along = np.array([each.along for each in products])
    count = np.array([each.count for each in products])
    limit = limit_of(len(products), along.shape[1], level)
    strength = np.maximum(np.einsum("mhh->mh", gram), 1e-12)
    common = _in_common(along / strength, strength, count, limit)
    if common is not None:
        along = along - common.amount * gram[:, :, common.place]
    amount = along / strength
    centre, scale = _robust(amount)
    score = (amount - centre) / scale
    rest = amount - centre
    explained = np.sqrt(strength * rest**2 / count[:, None])
    return Judged(common, tuple(_best(score[m], rest[m], explained[m], limit) for m in range(len(products))), limit)


def _in_common(amount: FloatArray, strength: FloatArray, count: FloatArray, limit: float) -> Finding | None:
    centre, scale = _robust(amount)
    score = centre / (np.sqrt(np.pi / 2.0) * scale / np.sqrt(amount.shape[0]))
    explained = np.median(np.sqrt(strength * centre**2 / count[:, None]), axis=0)
    # What a typical motor's square falls by with the centre's amount: an amount that scatters as much explains nothing.
    gain = np.median(strength * (amount**2 - (amount - centre) ** 2) / count[:, None], axis=0)
    return _best(score, centre, np.minimum(explained, np.sqrt(np.maximum(gain, 0.0))), limit)


def _best(score: FloatArray, amount: FloatArray, explained: FloatArray, limit: float) -> Finding | None:
    good = (np.abs(score) > limit) & (explained > LEAST_K)
    if not good.any():
        return None
    place = int(np.argmax(np.where(good, explained, -1.0)))
    return Finding(place, float(amount[place]), float(score[place]), float(explained[place]))


def _robust(amount: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre and scale over the motors, shape (H,) each."""
    centre = np.median(amount, axis=0)
    scale = 1.4826 * np.median(np.abs(amount - centre), axis=0)
    return centre, np.maximum(scale, 1e-9)
