"""Motors of one label that differ together from the others: a supplier's, a batch of sensors.

For a label's n motors and the k others, c and c' are the medians of their amounts of a hypothesis (`judging`), and s is
1.4826 times the median of all distances to the own side's median: two halves of a fleet that differ do not widen it.
They differ where |c - c'| / (1.2533 s sqrt(1/n + 1/k)) exceeds the limit, Student's t at level / (2 H) over the number
of labels: as for what all motors have in common, no more than `level` of fleets without a batch have one called.

Of all labels the surest is taken, c - c' of its pattern is taken off its motors' residuals, and the others are looked
at again: a supplier of whose motors half have the batch of sensors that differs is not called beside it. Of two labels
that part the fleet in the same two sides it is the one whose motors are farther from their models. Where no label has
those, the others are what all motors have in common, but for one label: that is for after what is in common.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.fleet.statistics.findings import MEDIAN_ERROR, Finding, best, spread

FEWEST_ALIKE = 4
"""Motors on either side from which a label is looked at: fewer have no median that one fault does not move."""


@dataclass(frozen=True, eq=False)
class Group:
    """Motors that share a label.

    Attributes
    ----------
    labels
        `KEY=VALUE`; several where they name the same motors.
    motors
        Which, shape (M,).
    """

    labels: tuple[str, ...]
    motors: BoolArray


@dataclass(frozen=True, eq=False)
class Batch:
    """A group that differs, and by what."""

    group: Group
    finding: Finding


def groups_of(labels: Sequence[Mapping[str, str]]) -> tuple[Group, ...]:
    """Give the labels that part the motors in two sides of :data:`FEWEST_ALIKE` at least.

    Parameters
    ----------
    labels
        Of each motor, values by keys.
    """
    names = sorted({(key, value) for own in labels for key, value in own.items()})
    found: dict[bytes, Group] = {}
    for key, value in names:
        motors = np.array([own.get(key) == value for own in labels], dtype=np.bool_)
        if min(motors.sum(), (~motors).sum()) < FEWEST_ALIKE:
            continue
        same = found.get(motors.tobytes())
        found[motors.tobytes()] = Group((*(same.labels if same else ()), f"{key}={value}"), motors)
    return tuple(found.values())


def batches(
    along: FloatArray, gram: FloatArray, count: FloatArray, groups: Sequence[Group], limit: float, *, farther: bool
) -> tuple[tuple[Batch, ...], FloatArray]:
    """Find the groups that differ, each once.

    Parameters
    ----------
    along, gram, count
        Of each motor, as of :class:`gen.fleet.statistics.patterns.Products`, shapes (M, H), (M, H, H) and (M,).
    groups
        Of :func:`groups_of`.
    limit
        In standard deviations.
    farther
        Whether to stop at a label whose motors are nearer to their models than the others.

    Returns
    -------
    batches
        The surest first.
    along
        The same without them, shape (M, H).
    """
    strength = np.maximum(np.einsum("mhh->mh", gram), 1e-12)
    left, found = list(groups), []
    while left:
        ways = [(group, _differing(along / strength, strength, count, group.motors, limit)) for group in left]
        sure = [(Batch(group, way[0]), way[1]) for group, way in ways if way is not None]
        if not sure:
            break
        # Both sides of the same two differ as surely, but for rounding.
        batch, away = max(sure, key=lambda each: (round(abs(each[0].finding.score), 6), each[1]))
        if farther and not away:
            break
        taken = batch.finding.amount * gram[:, :, batch.finding.place]
        along = along - np.where(batch.group.motors[:, None], taken, 0.0)
        left = [group for group in left if group is not batch.group]
        found.append(batch)
    return tuple(found), along


def _differing(
    amount: FloatArray, strength: FloatArray, count: FloatArray, inside: BoolArray, limit: float
) -> tuple[Finding, bool] | None:
    """Give by what a label's motors differ, and whether they are farther from their models than the others."""
    centre, others = np.median(amount[inside], axis=0), np.median(amount[~inside], axis=0)
    scale = spread(np.where(inside[:, None], amount - centre, amount - others))
    error = MEDIAN_ERROR * scale * np.sqrt(1.0 / inside.sum() + 1.0 / (~inside).sum())
    away = centre - others
    weight = strength[inside] / count[inside, None]
    explained = np.median(np.sqrt(weight * away**2), axis=0)
    # As for what is in common: what a typical motor's square falls by.
    gain = np.median(weight * ((amount[inside] - others) ** 2 - (amount[inside] - centre) ** 2), axis=0)
    found = best(away / error, away, np.minimum(explained, np.sqrt(np.maximum(gain, 0.0))), limit)
    return None if found is None else (found, bool(abs(centre[found.place]) >= abs(others[found.place])))
