"""How far amounts of healthy motors scatter: the more, the fewer runs a motor's model was learnt from.

A motor that ran once is judged by a model that rests on one run: its residuals are those of the model, too. With one
scale for all of a fleet such motors are called too often, and the others too rarely. So motors are put in classes by
how many runs their models were learnt from (1, 2 to 3, 4 to 7, ..), and each class has a scale of its own. Few motors
tell it badly: then a class's ratio to the whole fleet is taken from all hypotheses together. With n motors the
logarithm of a ratio of one hypothesis has a standard deviation of 1.16 / sqrt(n) (`findings`), and over hypotheses
ratios are taken to differ by 0.13: they count as n against (1.16 / 0.13)^2 = 80.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.fleet.statistics.findings import spread

ALIKE = 80.0
"""Motors as which the ratio of all hypotheses together counts."""
FEWEST = 8
"""Motors of a class that has a scale of its own; of smaller ones those of the class with fewer runs next to it hold."""


def scales(away: FloatArray, learnt: IntArray) -> FloatArray:
    """Give the scale of each motor's amounts.

    Parameters
    ----------
    away
        From the fleet's centre, shape (M, H).
    learnt
        From how many runs each motor's model was learnt, shape (M,).

    Returns
    -------
    ndarray
        Shape (M, H), in the amounts' unit.
    """
    whole = spread(away)
    factor = np.ones_like(away)
    of = _classes(learnt)
    for own in np.unique(of):
        inside = of == own
        ratio = np.log(spread(away[inside]) / whole)
        count = int(inside.sum())
        factor[inside] = np.exp((count * ratio + ALIKE * np.median(ratio)) / (count + ALIKE))
    return np.asarray(factor * spread(away / factor))


def _classes(learnt: IntArray) -> IntArray:
    """Powers of two of the runs, small classes joined with their neighbour, shape (M,)."""
    of = np.floor(np.log2(np.maximum(learnt, 1))).astype(np.int64)
    for own in sorted(set(of.tolist()), reverse=True):
        fewer, more = of[of < own], of[of > own]
        if np.sum(of == own) < FEWEST and (fewer.size or more.size):
            of[of == own] = fewer.max() if fewer.size else more.min()
    return of
