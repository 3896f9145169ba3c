"""Missing heat along whole records: what a block says is taken from all of its samples at once.

:class:`gen.reference.heat.ReferenceHeat` defines the sums sample by sample; day-long records would take it minutes.
The tests hold both to the same words.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.arrays import BoolArray, IntArray
from gen.lowering import heat
from gen.lowering.heat import LoweredHeat
from gen.model.dynamics import MAX_PWM
from gen.reference.heat import ReferenceHeat, truncated


@dataclass(frozen=True, eq=False)
class Blocks:
    """What the sums are made of, for one record.

    Attributes
    ----------
    magnitude
        |PWM| at each block's end, shape (B,).
    changes
        By how many counts PWM has changed in each, shape (B,); the first from standstill.
    means
        Of measured minus model by watched component, shape (watched, B).
    present
        Where a component was measured, shape (watched, B).
    """

    magnitude: IntArray
    changes: IntArray
    means: IntArray
    present: BoolArray

    def of(self, components: Sequence[int]) -> Blocks:
        """Some of the components only."""
        rows = list(components)
        return Blocks(self.magnitude, self.changes, self.means[rows], self.present[rows])


def blocks_of(block: int, components: Sequence[int], pwm: IntArray, deviation_mK: IntArray, valid: IntArray) -> Blocks:
    """Take a record's samples together.

    Parameters
    ----------
    block
        Samples in a block.
    components
        Which are watched.
    pwm
        What acted over each sample, shape (K,).
    deviation_mK
        Measured minus model after each sample, shape (components, K).
    valid
        Bit masks of the components whose measurement passed its checks, shape (K,).
    """
    count = len(pwm) // block
    held = np.clip(pwm[: count * block], -MAX_PWM, MAX_PWM)
    changes = np.abs(np.diff(held, prepend=0)).reshape(count, block).sum(axis=1)
    most = heat.MOST_DEVIATION_mK
    means, present = [], []
    for component in components:
        seen = (valid[: count * block] >> component & 1 == 1).reshape(count, block)
        values = np.clip(deviation_mK[component, : count * block], -most, most).reshape(count, block)
        samples = seen.sum(axis=1)
        means.append(truncated(np.where(seen, values, 0).sum(axis=1) * heat.PER_mK, np.maximum(samples, 1)))
        present.append(samples > 0)
    magnitude = np.abs(held).reshape(count, block)[:, -1]
    return Blocks(magnitude, changes, np.array(means), np.array(present))


@dataclass(frozen=True, eq=False)
class Course:
    """What every rule has come to before the first block and after each, shape (rules, L, B + 1) each.

    Attributes
    ----------
    sums, unsettled
        As :class:`gen.reference.heat.ReferenceHeat` has them.
    slack
        A settled motor's.
    """

    sums: IntArray
    unsettled: IntArray
    slack: IntArray


def sums_after(rules: Sequence[LoweredHeat | None], records: Sequence[Blocks], trusted: BoolArray) -> IntArray:
    """Sums of every rule after each block, shape (rules, L, B), see :func:`course_of`."""
    return course_of(rules, records, trusted).sums[:, :, 1:]


def course_of(rules: Sequence[LoweredHeat | None], records: Sequence[Blocks], trusted: BoolArray) -> Course:
    """Follow every rule over all blocks, if nobody resets them.

    Parameters
    ----------
    rules
        Of a model; None for a rule of another kind.
    records
        Of L boards.
    trusted
        Whether each one's model starts with the right slopes, shape (L,).

    Returns
    -------
    Course
        B is the blocks of the longest record; what a shorter one has come to stays.
    """
    longest = max((len(record.magnitude) for record in records), default=0)
    reference = ReferenceHeat(rules, trusted)
    sums, unsettled, slack = np.zeros((3, len(rules), len(records), longest + 1), dtype=np.int64)
    present_rules = [number for number, rule in enumerate(rules) if rule is not None]

    def note(after: int) -> None:
        sums[:, :, after], unsettled[:, :, after] = reference.sums, reference.unsettled
        for number in present_rules:
            slack[number, :, after] = reference.slack(number)

    note(0)
    lengths = np.array([len(record.magnitude) for record in records])
    magnitude, changes = (
        _padded([getattr(item, key) for item in records], longest) for key in ("magnitude", "changes")
    )
    means = np.moveaxis(np.array([_padded(list(item.means), longest) for item in records]), 0, 1)
    present = np.moveaxis(np.array([_padded(list(item.present), longest) for item in records]), 0, 1)
    for block in range(longest):
        reference.change(changes[:, block])
        reference.end_block(magnitude[:, block], means[..., block], present[..., block] == 1, lengths > block)
        note(block + 1)
    return Course(sums, unsettled, slack)


def _padded(rows: Sequence[NDArray[np.generic]], length: int) -> IntArray:
    padded = np.zeros((len(rows), length), dtype=np.int64)
    for row, values in zip(padded, rows, strict=True):
        row[: len(values)] = values
    return padded
