"""Compare what a runner computed with the reference, word by word; shrink a profile that fails."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import IntArray, RecordArray
from gen.lowering.program import Program
from gen.reference.board import record_type, reference_of
from gen.verification.profiles import Profile

Runner = Callable[[Profile], RecordArray]

#: What a state is moved by, as a record names it.
_COEFFICIENT = re.compile(r"\.(?:R\d+|S|A|B)$")
#: Runs that shrinking may spend.
_SHRINKING_RUNS = 120


@dataclass(frozen=True)
class Mismatch:
    """The first word that differs.

    Attributes
    ----------
    lane, step
        Where, both from 0.
    field
        ``component.word``: x1.hi and x1.lo are a state's high and low word, R0.. and S coefficients.
    expected, found
        The reference's and the runner's value.
    differing
        How many words differ in the whole run.
    """

    lane: int
    step: int
    field: str
    expected: int
    found: int
    differing: int

    def __str__(self) -> str:
        return (
            f"step {self.step}, {self.field}: reference {self.expected} (0x{self.expected & 0xFFFFFFFF:X}), "
            f"found {self.found} (0x{self.found & 0xFFFFFFFF:X})"
        )


def reference_run(program: Program, profile: Profile) -> RecordArray:
    """The reference's records for a profile, shape (L, N)."""
    told = None if profile.channels is None else np.moveaxis(profile.channels, (1, 2), (0, 1))  # (N + 1, channels, L)
    model = reference_of(program, [int(rise) for rise in profile.start_mK], None if told is None else told[0])
    records = np.zeros(profile.pwm.shape, dtype=record_type(program))
    for step in range(profile.pwm.shape[1]):
        if told is not None:
            model.set_channels(told[step + 1])
        model.step(profile.pwm[:, step])
        records[:, step] = model.record()
    return records


def words_per_sample(program: Program) -> int:
    """How many words each sample compares."""
    return len(record_type(program).names or ())


def first_mismatch(expected: RecordArray, found: RecordArray) -> Mismatch | None:
    """The earliest differing word, or None."""
    names = list(expected.dtype.names or ())
    differs = {name: expected[name] != found[name] for name in names}
    total = int(sum(int(mask.sum()) for mask in differs.values()))
    if not total:
        return None
    any_word = np.zeros(expected.shape, dtype=bool)
    for mask in differs.values():
        any_word |= mask
    step = int(np.argmax(any_word.any(axis=0)))
    lane = int(np.argmax(any_word[:, step]))
    wrong = [name for name in names if differs[name][lane, step]]
    # A coefficient that differs is the cause, a state its consequence in the same sample.
    name = next((name for name in wrong if _COEFFICIENT.search(name)), wrong[0])
    return Mismatch(lane, step, name, int(expected[name][lane, step]), int(found[name][lane, step]), total)


def shrink(program: Program, run: Runner, profile: Profile, mismatch: Mismatch) -> tuple[Profile, Mismatch]:
    """A shorter profile of one lane that still fails, and its mismatch.

    Cuts after the failing step, then leaves out ever smaller pieces, with what the channels say before each sample, as
    long as the runner still differs from the reference.
    """
    lane = _lane(profile, mismatch.lane)
    budget = _SHRINKING_RUNS

    def attempt(tried: Profile) -> tuple[Profile, Mismatch] | None:
        nonlocal budget
        if budget <= 0 or not tried.samples:
            return None
        budget -= 1
        found = first_mismatch(reference_run(program, tried), run(tried))
        return (tried, found) if found is not None else None

    best = attempt(_samples(lane, np.arange(mismatch.step + 1)))
    if best is None:  # it depends on the lanes before it: keep the whole profile
        return profile, mismatch
    cold = replace(best[0], start_mK=np.zeros(1, dtype=np.int64))
    best = attempt(_samples(cold, np.arange(best[1].step + 1))) or best
    piece = best[0].samples // 2
    while piece >= 1 and budget > 0:
        position = 0
        while position < best[0].samples and budget > 0:
            every = np.arange(best[0].samples)
            smaller = attempt(_samples(best[0], np.concatenate([every[:position], every[position + piece :]])))
            if smaller is not None:
                best = attempt(_samples(smaller[0], np.arange(smaller[1].step + 1))) or smaller
            else:
                position += piece
        piece //= 2
    return best


def _lane(profile: Profile, lane: int) -> Profile:
    """One lane alone."""
    told = None if profile.channels is None else profile.channels[lane : lane + 1]
    return Profile(profile.pwm[lane : lane + 1], profile.start_mK[lane : lane + 1], told)


def _samples(lane: Profile, kept: IntArray) -> Profile:
    """Some samples of one lane; before the first one stands what it is told at the start."""
    told = None if lane.channels is None else lane.channels[:, np.concatenate([[0], kept + 1])]
    return Profile(lane.pwm[:, kept], lane.start_mK, told)
