"""When each alarm rule is first raised along a whole record, if nobody resets it: all samples of a rule at once.

:class:`gen.reference.alarms.ReferenceAlarms` defines the rules sample by sample, for boards that may be reset; day-long
records would take it minutes. The tests hold both to the same samples.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gen.lowering.alarms import LoweredRule
from gen.model.dynamics import MAX_PWM
from gen.reference.alarms import thresholds

Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]


def first_raised(
    rules: Sequence[LoweredRule],
    pwm: Integers,
    measured_mC: Integers,
    model_mC: Integers,
    valid: Integers,
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
        Bit masks of the components whose measurement passed its checks, shape (K,).
    trusted
        Whether the model starts with the right slopes.

    Returns
    -------
    list
        By rule: an index of the samples, None for a rule that is not raised.
    """
    magnitude = np.minimum(np.abs(pwm), MAX_PWM)
    deviation = measured_mC - model_mC
    first: list[int | None] = []
    for rule in rules:
        inside, trip, clear = thresholds(rule, magnitude)
        awake = inside & _awake(rule, inside, 0 if trusted else rule.start_wait, first)
        seen = awake & ((valid >> rule.component & 1) == 1)
        value = deviation[rule.component] if rule.needs_model else measured_mC[rule.component]
        if rule.relative_to is not None:
            seen &= (valid >> rule.relative_to & 1) == 1
            value = value - deviation[rule.relative_to]
        value = -value if rule.quantity == "below" else value
        holds = _sum_is_full(rule, seen, value - trip) if rule.sum_limit is not None else None
        if holds is None:
            begins, ends = seen & (value > trip), ~awake | (seen & (value <= clear))
            holds = seen & (_latest(begins) > _latest(ends))
        held = np.cumsum(holds)
        released = _latest(~awake | (seen & ~holds))
        held -= np.where(released >= 0, held[released], 0)
        raised = holds & (held > rule.persistence)
        first.append(int(np.argmax(raised)) if raised.any() else None)
    return first


def _awake(rule: LoweredRule, inside: Flags, wait: int, first: Sequence[int | None]) -> Flags:
    """Where a rule does not wait, neither after the start, nor for its speed to settle, nor for another rule."""
    sample = np.arange(inside.size)
    awake: Flags = (np.cumsum(inside) > wait) & (sample - _latest(~inside) > rule.settle)
    if rule.requires is not None:
        since = first[rule.requires]
        awake &= sample >= (inside.size if since is None else since)
    if rule.unless is not None:
        until = first[rule.unless]
        awake &= sample < (inside.size if until is None else until)
    return awake


def _sum_is_full(rule: LoweredRule, seen: Flags, beyond: Integers) -> Flags:
    limit = rule.sum_limit
    assert limit is not None
    total, full = 0, np.zeros(seen.size, dtype=np.bool_)
    for sample in np.flatnonzero(seen).tolist():
        total = min(max(total + int(beyond[sample]), 0), limit)
        full[sample] = total == limit
    return full


def _latest(present: Flags) -> NDArray[np.int64]:
    """Of each sample the latest one up to it that is marked, -1 without any."""
    latest: NDArray[np.int64] = np.maximum.accumulate(np.where(present, np.arange(present.size), -1))
    return latest
