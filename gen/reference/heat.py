"""Missing heat, block by block as the board sums it, for many runs at once (:mod:`gen.lowering.heat`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import BoolArray, IntArray, RecordArray
from gen.lowering import heat
from gen.lowering.heat import LoweredHeat
from gen.model.dynamics import MAX_PWM

_PART = (("sum", "<i4"), ("count", "<u2"), ("mean", "<i4"), ("known", "u1"))
_RULE = (
    ("sum", "<i4"),
    ("usual", "<i4"),
    ("before", "<i4"),
    ("unsettled", "<u4"),
    ("pending", "<i4"),
    ("learnt", "<u2"),
    ("waited", "u1"),
)


class ReferenceHeat:
    """The sums of every rule on missing heat, over L independent lanes.

    Parameters
    ----------
    rules
        What the board evaluates; None for a rule of another kind.
    trusted
        For each lane, whether the model starts with the right slopes, shape (L,).

    Attributes
    ----------
    sums, unsettled
        What was summed, and the slack that changes of PWM and starts have left, in 2^-FINE_BITS of a heat; shape
        (rules, L) each, zero for rules of another kind.
    """

    def __init__(self, rules: Sequence[LoweredHeat | None], trusted: BoolArray) -> None:
        self._rules = [(number, rule) for number, rule in enumerate(rules) if rule is not None]
        self._by_number = dict(self._rules)
        self._watched = watched(rules)
        self._block = self._rules[0][1].block if self._rules else 1
        lanes = len(trusted)
        self.sums = np.zeros((len(rules), lanes), dtype=np.int64)
        self._usual, self._before, self.unsettled, self._pending, self._learnt, self._waited = (
            np.zeros((len(rules), lanes), dtype=np.int64) for _ in range(6)
        )
        for number, rule in self._rules:
            self.unsettled[number] = np.where(trusted, 0, rule.start)
            self._learnt[number] = heat.PRIOR_BLOCKS
        self._sum, self._count, self._mean, self._known = (
            np.zeros((len(self._watched), lanes), dtype=np.int64) for _ in range(4)
        )
        self._samples = np.zeros(lanes, dtype=np.int64)
        self._pwm = np.zeros(lanes, dtype=np.int64)

    def reset(self, lanes: BoolArray) -> None:
        """Begin the sums anew in the lanes that are marked, shape (L,); what is usual stays."""
        self.sums[:, lanes] = 0

    def step(self, pwm: IntArray, deviation_mK: IntArray, valid: IntArray) -> None:
        """Take a sample.

        Parameters
        ----------
        pwm
            What acted over the sample, shape (L,).
        deviation_mK
            Measured minus model, shape (components, L).
        valid
            Bit masks of the components whose measurement passed its checks, shape (L,).
        """
        if not self._rules:
            return
        held = np.clip(pwm, -MAX_PWM, MAX_PWM)
        self.change(np.abs(held - self._pwm))
        self._pwm = held
        for row, component in enumerate(self._watched):
            seen = ((valid >> component) & 1) == 1
            most = heat.MOST_DEVIATION_mK
            self._sum[row] += np.where(seen, np.clip(deviation_mK[component], -most, most), 0)
            self._count[row] += seen
        self._samples += 1
        ended = self._samples == self._block
        if ended.any():
            means = truncated(self._sum * heat.PER_mK, np.maximum(self._count, 1))
            self.end_block(np.abs(held), means, self._count > 0, ended)
            for values in (self._samples, *self._sum, *self._count):
                values[ended] = 0

    def settled(self, number: int) -> BoolArray:
        """Where what a change of PWM or a start has left is too little to hide what a rule would hear, shape (L,)."""
        return is_settled(self.unsettled[number], self.slack(number))

    def slack(self, number: int) -> IntArray:
        """A rule's slack for a settled motor, shape (L,)."""
        rule = self._by_number[number]
        return np.asarray(rule.slack + rule.unknown * heat.PRIOR_BLOCKS // self._learnt[number])

    def change(self, counts: IntArray) -> None:
        """Take changes of PWM, shape (L,)."""
        for number, rule in self._rules:
            self.unsettled[number] = np.minimum(heat.MOST_UNSETTLED, self.unsettled[number] + rule.change * counts)

    def end_block(self, magnitude: IntArray, means: IntArray, present: BoolArray, ended: BoolArray) -> None:
        """End a block.

        Parameters
        ----------
        magnitude
            |PWM| at its end, shape (L,).
        means
            Of measured minus model by watched component (:func:`watched`), shape (watched, L).
        present
            Where a component was measured in it, shape (watched, L).
        ended
            Lanes whose block it is, shape (L,).
        """
        fresh = present & ended
        moved = np.where(fresh & (self._known == 1), means - self._mean, 0)
        self._mean = np.where(fresh, means, self._mean)
        self._known = np.where(fresh, 1, self._known)
        bins = magnitude // heat.BIN_COUNTS
        for number, rule in self._rules:
            self._end_rule(number, rule, bins, magnitude, moved, present, ended)

    def _end_rule(
        self, number: int, rule: LoweredHeat, bins: IntArray, magnitude: IntArray, moved: IntArray, present: BoolArray,
        ended: BoolArray,
    ) -> None:  # fmt: skip
        fading = np.array(rule.fading)[bins]
        unsettled = self.unsettled[number]
        unsettled = np.where(ended, unsettled - (unsettled * fading >> heat.RATE_BITS), unsettled)
        self.unsettled[number] = unsettled
        inside = ended & (magnitude >= rule.low) & (magnitude <= rule.high)
        gained, complete = np.zeros_like(magnitude), inside.copy()
        for term in rule.terms:
            row = self._watched.index(term.component)
            lost = self._mean[row] * np.array(term.forgetting)[bins] >> heat.RATE_BITS
            gained += term.weight * (moved[row] + lost)
            complete &= present[row]
        most = heat.MOST_PENDING
        pending = np.clip(self._pending[number] + (gained >> heat.WEIGHT_BITS), -most, most)
        waited = self._waited[number]
        blocks = waited + 1
        usual, before = self._usual[number], self._before[number]
        slack = self.slack(number)
        counted = pending - blocks * ((before >> heat.FINE_BITS) + slack + (unsettled >> heat.FINE_BITS))
        self.sums[number] = np.where(
            complete, np.clip(self.sums[number] + counted, 0, 2 * rule.limit), self.sums[number]
        )
        most = heat.MOST_RATE << heat.FINE_BITS
        rate = np.clip(truncated(pending << heat.FINE_BITS, blocks), -most, most)
        learns = complete & is_settled(unsettled, slack)
        self._usual[number] = np.where(learns, usual + truncated(rate - usual, self._learnt[number]), usual)
        self._learnt[number] = np.where(learns, np.minimum(self._learnt[number] + 1, rule.memory), self._learnt[number])
        self._remember(number, rule, ended)
        waiting = inside & ~complete
        self._pending[number] = np.where(waiting, pending, np.where(ended, 0, self._pending[number]))
        self._waited[number] = np.where(waiting, np.minimum(blocks, heat.MOST_WAITED), np.where(ended, 0, waited))

    def _remember(self, number: int, rule: LoweredHeat, ended: BoolArray) -> None:
        """What was usual before fades towards what is, and never lies below it."""
        usual, before = self._usual[number], self._before[number]
        faded = np.maximum(usual, before - ((before - usual) * rule.forgetting >> heat.RATE_BITS))
        faded = np.where(self._learnt[number] < rule.told, usual, faded)
        self._before[number] = np.where(ended, faded, before)

    def advance(self, record: RecordArray) -> None:
        """Go on from what a board keeps, shape (L,), see :func:`fields`."""
        for row in range(len(self._watched)):
            for values, (field, _) in zip(self._part_words(), _PART, strict=True):
                values[row] = record[f"heat.part{row}.{field}"]
        for number, _ in self._rules:
            for values, (field, _) in zip(self._rule_words(), _RULE, strict=True):
                values[number] = record[f"heat.{number}.{field}"]
        if self._rules:
            self._samples, self._pwm = record["heat.samples"].astype(np.int64), record["heat.pwm"].astype(np.int64)

    def keep(self, record: RecordArray) -> None:
        """Write what the board keeps into a record, shape (L,)."""
        for row in range(len(self._watched)):
            for values, (field, _) in zip(self._part_words(), _PART, strict=True):
                record[f"heat.part{row}.{field}"] = values[row]
        for number, _ in self._rules:
            for values, (field, _) in zip(self._rule_words(), _RULE, strict=True):
                record[f"heat.{number}.{field}"] = values[number]
        if self._rules:
            record["heat.samples"], record["heat.pwm"] = self._samples, self._pwm

    def _part_words(self) -> tuple[IntArray, ...]:
        return self._sum, self._count, self._mean, self._known

    def _rule_words(self) -> tuple[IntArray, ...]:
        return self.sums, self._usual, self._before, self.unsettled, self._pending, self._learnt, self._waited


def watched(rules: Sequence[LoweredHeat | None]) -> tuple[int, ...]:
    """Indices of the components that any rule weighs, in their order."""
    return tuple(sorted({term.component for rule in rules if rule is not None for term in rule.terms}))


def fields(rules: Sequence[LoweredHeat | None]) -> list[tuple[str, str]]:
    """Names and kinds of the board's words, in their order; without such a rule none."""
    if not any(rules):
        return []
    parts = [(f"heat.part{row}.{field}", kind) for row in range(len(watched(rules))) for field, kind in _PART]
    sums = [
        (f"heat.{number}.{field}", kind)
        for number, rule in enumerate(rules)
        if rule is not None
        for field, kind in _RULE
    ]
    return [*parts, *sums, ("heat.samples", "<u2"), ("heat.pwm", "<i2")]


def is_settled(unsettled: IntArray, slack: IntArray) -> BoolArray:
    """Whether an unsettled slack, in 2^-FINE_BITS of a heat, is small beside a settled one, in heats."""
    small: BoolArray = 2 * (unsettled >> heat.FINE_BITS) < slack
    return small


def truncated(values: IntArray, by: IntArray) -> IntArray:
    """Divide as C++ does, towards zero; `by` is positive."""
    quotient: IntArray = np.sign(values) * (np.abs(values) // by)
    return quotient
