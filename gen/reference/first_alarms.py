"""When each alarm rule is first raised along a whole record, if nobody resets it: all samples of a rule at once.

:class:`gen.reference.alarms.ReferenceAlarms` defines the rules sample by sample, for boards that may be reset; day-long
records would take it minutes. The tests hold both to the same samples.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gen.arrays import BoolArray, IntArray
from gen.lowering.alarms import LoweredRule
from gen.lowering.heat import MOST_UNSETTLED, LoweredHeat
from gen.model.dynamics import MAX_PWM
from gen.reference.alarms import compared, counted, thresholds
from gen.reference.heat import is_settled, watched
from gen.reference.heat_blocks import Course, blocks_of, course_of


def first_raised(
    rules: Sequence[LoweredRule],
    pwm: IntArray,
    measured_mC: IntArray,
    model_mC: IntArray,
    valid: IntArray,
    *,
    trusted: bool,
) -> list[int | None]:
    """Give the sample at which each rule's alarm is first raised.

    Parameters
    ----------
    rules
        What the board evaluates.
    pwm
        What acted over each sample, shape (K,).
    measured_mC, model_mC
        Measured and modelled temperatures after each sample, shape (components, K), in thousandths of a degree Celsius.
    valid
        Bit masks of the components whose measurement passed its checks, shape (K,). A run file holds no others: what
        a board took as plausible only is missing, and so is how fast it rose from one reading to the next.
    trusted
        Whether the model starts with the right slopes.

    Returns
    -------
    list
        By rule: an index of the samples, None for a rule that is not raised.
    """
    magnitude = np.minimum(np.abs(pwm), MAX_PWM)
    full, settled = _heat(rules, pwm, measured_mC - model_mC, valid, trusted=trusted)
    first: list[int | None] = []
    for number, rule in enumerate(rules):
        inside, trip, clear = thresholds(rule, magnitude)
        awake = inside & _awake(rule, inside, 0 if trusted else rule.start_wait, first)
        if rule.unless is not None and rules[rule.unless].heat is not None:
            awake &= _denied(rule, inside, settled[rule.unless], first)
        seen = awake & ((valid >> rule.component & 1) == 1)
        if rule.relative_to is not None:
            seen &= (valid >> rule.relative_to & 1) == 1
        value = compared(rule, measured_mC, model_mC)
        if rule.heat is not None:
            holds = seen & full[number]
        elif rule.sum_limit is not None:
            holds = _sum_is_full(rule, seen, value - trip)
        else:
            begins, ends = seen & (value > trip), ~awake | (seen & (value <= clear))
            holds = seen & (_latest(begins) > _latest(ends))
        held = np.cumsum(np.where(holds, counted(rule, value, trip), 0))
        released = _latest(~awake | (seen & ~holds))
        held -= np.where(released >= 0, held[released], 0)
        raised = holds & (held > rule.persistence)
        first.append(int(np.argmax(raised)) if raised.any() else None)
    return first


def _heat(
    rules: Sequence[LoweredRule], pwm: IntArray, deviation_mK: IntArray, valid: IntArray, *, trusted: bool
) -> tuple[BoolArray, BoolArray]:
    """Where the sum of a rule on missing heat has reached its limit, and where such a rule is settled.

    Shape (rules, K) each; False and True for other rules.
    """
    reached = np.zeros((len(rules), len(pwm)), dtype=np.bool_)
    settled = ~reached
    lowered = [rule.heat for rule in rules]
    block = next((rule.block for rule in lowered if rule is not None), 0)
    if not block:
        return reached, settled
    record = blocks_of(block, watched(lowered), pwm, deviation_mK, valid)
    course = course_of(lowered, [record], np.array([trusted]))
    after = (np.arange(len(pwm)) + 1) // block  # blocks that have ended, a sample that ends one included
    for number, rule in enumerate(lowered):
        if rule is not None:
            reached[number] = (course.sums[number, 0] >= rule.limit)[after]
            settled[number] = _settled(rule, course, number, pwm, after)
    return reached, settled


def _settled(rule: LoweredHeat, course: Course, number: int, pwm: IntArray, after: IntArray) -> BoolArray:
    """Where a rule is settled: PWM may change within a block, and unsettles it at once."""
    changed = np.cumsum(np.abs(np.diff(np.clip(pwm, -MAX_PWM, MAX_PWM), prepend=0)))
    ends = np.arange(1, after[-1] + 1) * rule.block - 1
    until = np.concatenate([[0], changed[ends]])  # counts of change that each block's end has seen
    unsettled = course.unsettled[number, 0][after] + rule.change * (changed - until[after])
    return is_settled(np.minimum(MOST_UNSETTLED, unsettled), course.slack[number, 0][after])


def _awake(rule: LoweredRule, inside: BoolArray, wait: int, first: Sequence[int | None]) -> BoolArray:
    """Where a rule does not wait, neither after the start, nor for its speed to settle, nor for another rule."""
    sample = np.arange(inside.size)
    awake: BoolArray = (np.cumsum(inside) > wait) & (sample - _latest(~inside) > rule.settle)
    if rule.requires is not None:
        since = first[rule.requires]
        awake &= sample >= (inside.size if since is None else since)
    if rule.unless is not None:
        until = first[rule.unless]
        awake &= sample < (inside.size if until is None else until)
    return awake


def _denied(rule: LoweredRule, inside: BoolArray, settled: BoolArray, first: Sequence[int | None]) -> BoolArray:
    """Where the silence of a rule on missing heat says no: it is settled, and was when the required alarm came."""
    if rule.requires is None:
        return settled
    since = first[rule.requires]
    before = np.flatnonzero(inside[:since])
    return settled & bool(before.size and settled[before[-1]])


def _sum_is_full(rule: LoweredRule, seen: BoolArray, beyond: IntArray) -> BoolArray:
    limit = rule.sum_limit
    assert limit is not None
    total, full = 0, np.zeros(seen.size, dtype=np.bool_)
    for sample in np.flatnonzero(seen).tolist():
        total = min(max(total + int(beyond[sample]), 0), limit)
        full[sample] = total == limit
    return full


def _latest(present: BoolArray) -> IntArray:
    """Of each sample the latest one up to it that is marked, -1 without any."""
    latest: IntArray = np.maximum.accumulate(np.where(present, np.arange(present.size), -1))
    return latest
