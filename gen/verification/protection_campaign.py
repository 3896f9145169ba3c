"""What causes and actions are compared on: words in which each cause comes and goes, and the reference's answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import IntArray, RecordArray
from gen.lowering.program import Program
from gen.lowering.protection import MOST_TIMES, LoweredProtection, Word
from gen.reference.protection import ReferenceProtection, protection_fields
from gen.verification.sample import sample_fields

STEP, BEGIN, ASK_AND_STEP = 0, 1, 2
_WORDS: tuple[Word, ...] = ("lost", "alarms", "device")
_ASK_SHARE = 0.04
#: Samples for which a cause stays or stays away at most.
_LONGEST = 60


@dataclass(frozen=True)
class ProtectionCampaign:
    """Inputs of L lanes, shape (L, N + 1), the first of which begins the lane, and what is expected, shape (L, N)."""

    inputs: RecordArray
    expected: RecordArray


def input_type(components: int, entries: Sequence[LoweredProtection]) -> np.dtype[np.void]:
    """The harnesses' input record; the structure at its end is what a lane begins with."""
    words = [("lost", "<u4"), ("alarms", "<u2"), ("device", "<u2")]
    return np.dtype([("op", "u1"), *words, *sample_fields(components), *protection_fields(entries)])


def output_type(entries: Sequence[LoweredProtection]) -> np.dtype[np.void]:
    """The harnesses' output record: the structure, and what follows from it."""
    results = [("lasting", "<u4"), ("most_pwm", "u1"), ("opens_relay", "u1"), ("shows", "u1"), ("waiting", "<u2")]
    held = [("holds", "u1")] if any(entry.holds for entry in entries) else []
    return np.dtype([*protection_fields(entries), *results, *held])


def protection_campaign(
    program: Program, entries: Sequence[LoweredProtection], lanes: int, length: int, seed: int = 60_730
) -> ProtectionCampaign:
    """Causes that come for just as long as their delays, a sample less and more; parts around their restart.

    Parameters
    ----------
    program
        Gives the components and the full scale.
    entries
        The table; at least one.
    lanes, length
        Of the campaign. All lanes but the first begin with delays close to their ends and some entries acting; the
        second goes on with what acted before a reset.
    """
    random = np.random.default_rng(seed)
    components = len(program.parts)
    reference = ReferenceProtection(entries, lanes)
    inputs = np.zeros((lanes, length + 1), dtype=input_type(components, entries))
    expected = np.zeros((lanes, length), dtype=output_type(entries))
    begun = _begun(random, entries, lanes)
    begun[:1] = np.zeros(1, dtype=begun.dtype)
    reference.advance(begun)
    inputs["op"][:, 0] = BEGIN
    inputs["lost"][1, 0] = restored = int(random.integers(0, 1 << 32))
    reference.restore(np.where(np.arange(lanes) == 1, restored, 0))
    for name in begun.dtype.names or ():
        inputs[name][:, 0] = begun[name]
    source = _Conditions(random, entries, lanes, components)
    for step in range(length):
        row = inputs[:, step + 1]
        words, measured, valid = source.next()
        asked = np.asarray(random.random(lanes) < _ASK_SHARE)
        reference.ask(asked)
        reference.step(words, measured, valid)
        row["op"] = np.where(asked, ASK_AND_STEP, STEP)
        for word in _WORDS:
            row[word] = words[word]
        row["measured_mC"], row["valid"] = measured.T, valid
        _keep(expected[:, step], reference, entries, program.model.full_scale)
    return ProtectionCampaign(inputs, expected)


def _keep(
    row: RecordArray, reference: ReferenceProtection, entries: Sequence[LoweredProtection], full_scale: int
) -> None:
    reference.keep(row)
    lasting = sum(1 << number for number, entry in enumerate(entries) if entry.lasts)
    row["lasting"] = reference.acting & lasting
    row["most_pwm"] = reference.most_pwm(full_scale)
    row["opens_relay"] = reference.any_of([entry.opens_relay for entry in entries])
    row["waiting"] = reference.waiting
    row["shows"] = reference.any_of([entry.shows for entry in entries])
    if "holds" in (row.dtype.names or ()):
        row["holds"] = reference.holds


def _begun(random: np.random.Generator, entries: Sequence[LoweredProtection], lanes: int) -> RecordArray:
    record = np.zeros(lanes, dtype=protection_fields(entries))
    for number, entry in enumerate(entries):
        record[f"protection.{number}.held"] = np.maximum(entry.delay + 1 - random.integers(0, 4, lanes), 0)
        if entry.pause:  # pauses and what is forgotten are long: they begin close to their ends
            record[f"protection.{number}.left"] = random.integers(0, 40, lanes)
            record[f"protection.{number}.times"] = random.integers(0, MOST_TIMES + 1, lanes)
    every = (1 << len(entries)) - 1
    record["protection.acting"] = random.integers(0, every + 1, lanes)
    record["protection.holding"] = random.integers(0, every + 1, lanes)
    record["protection.asked"] = random.integers(0, 2, lanes)
    return record


class _Conditions:
    """Each bit of each word comes and goes by itself; temperatures lie at and just beside where parts count as cool."""

    def __init__(
        self, random: np.random.Generator, entries: Sequence[LoweredProtection], lanes: int, components: int
    ) -> None:
        self._random = random
        self._entries = entries
        bits = [(entry.word, bit) for entry in entries for bit in range(32) if entry.mask >> bit & 1]
        self._bits = sorted(set(bits))
        self._left = np.zeros((len(self._bits), lanes), dtype=np.int64)
        self._on = np.zeros((len(self._bits), lanes), dtype=bool)
        # Most lanes have few causes, or something would always act.
        self._used = random.random((len(self._bits), lanes)) < random.choice([0.1, 0.25, 1.0], lanes)
        self._shape = (components, lanes)
        delays = sorted({entry.delay for entry in entries})
        self._delays = np.array([delay for delay in delays if delay <= _LONGEST] or [0])

    def next(self) -> tuple[dict[Word, IntArray], IntArray, IntArray]:
        """The three words, shape (L,) each, measured temperatures (components, L) in mK, and which are valid (L,)."""
        random = self._random
        self._left -= 1
        over = self._left < 0
        near = random.choice(self._delays, over.shape) + random.integers(-1, 3, over.shape)
        anything = random.integers(0, _LONGEST, over.shape)
        self._left = np.where(over, np.where(random.random(over.shape) < 0.5, near, anything), self._left)
        self._on = (self._on ^ over) & self._used
        words: dict[Word, IntArray] = {word: np.zeros(self._shape[1], dtype=np.int64) for word in _WORDS}
        for number, (word, bit) in enumerate(self._bits):
            words[word] |= self._on[number].astype(np.int64) << bit
        measured = np.asarray(random.integers(-20_000, 150_000, self._shape), dtype=np.int64)
        for entry in self._entries:
            beside = entry.restart_mC + random.integers(-2, 3, self._shape[1])
            chosen = random.random(self._shape[1]) < 0.7
            measured[entry.component] = np.where(chosen, beside, measured[entry.component])
        valid = (np.asarray(random.random(self._shape) < 0.8) << np.arange(self._shape[0])[:, None]).sum(axis=0)
        return words, measured, valid
