"""What all motors show in common, what those of one label do, and what one alone does.

For motor m and hypothesis h with pattern p along its run, the amount is a = <p, r> / <p, p>. Over the fleet the centre
is c_h = median a, the scale s_h a robust one (`findings`), that of motor m alone s_hm (`scales`). In common is what
|c_h| / (1.2533 s_h / sqrt(M)) exceeds a limit for; of those the one that explains most is taken off every residual. The
same holds for motors that share a label (`batches`), before that, lest half a fleet is taken for all of it, and once
more after it. A motor is different where |a - c_h| / s_hm exceeds the limit, and of those hypotheses it is the one that
explains most of its residual.

The limit is at level / (2 H), two-sided, H hypotheses on each of two models. By Bonferroni's inequality a healthy motor
whose amounts are normal as the fleet's is called different in no more than `level` of its runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.fleet.statistics.batches import Batch, Group, batches
from gen.fleet.statistics.findings import MEDIAN_ERROR, Finding, best, limit_of, spread
from gen.fleet.statistics.patterns import Products
from gen.fleet.statistics.scales import scales

FEWEST = 8
"""Motors from which a scale is told."""


@dataclass(frozen=True, eq=False)
class Judged:
    """A fleet's residuals against one kind of model.

    Attributes
    ----------
    common
        What all motors show, or None.
    batches
        What motors of a label show together.
    own
        By motor what it alone shows, or None.
    limit
        In standard deviations.
    """

    common: Finding | None
    batches: tuple[Batch, ...]
    own: tuple[Finding | None, ...]
    limit: float


def judge(products: Sequence[Products], learnt: IntArray, groups: Sequence[Group], level: float) -> Judged:
    """Tell what is common, and what is a label's, from what is one motor's.

    Parameters
    ----------
    products
        Of each motor's newest run, which has readings; at least :data:`FEWEST`.
    learnt
        From how many runs each motor's model was learnt, shape (M,).
    groups
        Motors that share a label.
    level
        Of false alarms, a run of a healthy motor.
    """
    gram = np.array([each.gram for each in products])
    along = np.array([each.along for each in products])
    count = np.array([each.count for each in products])
    limit = limit_of(len(products), along.shape[1], level)
    strength = np.maximum(np.einsum("mhh->mh", gram), 1e-12)
    of_labels = limit_of(len(products) - 1, along.shape[1] * max(len(groups), 1), level)
    before, along = batches(along, gram, count, groups, of_labels, farther=True)
    common = _in_common(along / strength, strength, count, limit)
    if common is not None:
        along = along - common.amount * gram[:, :, common.place]
    left = [group for group in groups if all(group is not batch.group for batch in before)]
    after, along = batches(along, gram, count, left, of_labels, farther=False)
    amount = along / strength
    centre = np.median(amount, axis=0)
    rest = amount - centre
    score = rest / scales(rest, learnt)
    explained = np.sqrt(strength * rest**2 / count[:, None])
    own = tuple(best(score[m], rest[m], explained[m], limit) for m in range(len(products)))
    return Judged(common, (*before, *after), own, limit)


def _in_common(amount: FloatArray, strength: FloatArray, count: FloatArray, limit: float) -> Finding | None:
    centre = np.median(amount, axis=0)
    score = centre / (MEDIAN_ERROR * spread(amount - centre) / np.sqrt(amount.shape[0]))
    explained = np.median(np.sqrt(strength * centre**2 / count[:, None]), axis=0)
    # What a typical motor's square falls by with the centre's amount: an amount that scatters as much explains nothing.
    gain = np.median(strength * (amount**2 - (amount - centre) ** 2) / count[:, None], axis=0)
    return best(score, centre, np.minimum(explained, np.sqrt(np.maximum(gain, 0.0))), limit)
