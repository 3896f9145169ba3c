"""The effects as the board runs them, word for word, over L lanes at once.

A sample, after the baseline's own step (its rise goes from B0 to B1 meanwhile):

1. Where a drive depends on rises, every such rise is predicted: the drives at the sample's start are tried for one
   sample, and the mean of start and prediction stands for the rise within the sample (second order, like the
   trapezoidal rule). For a fast component of order 1 a second trial adds a term: with y = rate Ts,
   mean = T0 + dT/2 + (y/6) (dT - dD), dT and dD the change of rise and of drive that the trials gave.
2. With those, every drive and target once more; chains and followers advance by it.
3. Inner states advance (exactly: their target is held), and sensors show what they see.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gen.arrays import IntArray
from gen.lowering.effects.graph import Operand
from gen.lowering.effects.program import (
    FOLLOWER_BITS,
    KELVIN_BITS,
    KELVIN_LIMIT,
    WEIGHT_BITS,
    EffectComponent,
    EffectsProgram,
)
from gen.lowering.fixed.component import FixedComponent
from gen.lowering.float32 import FloatComponent
from gen.reference.effect_chains import FixedChain, FloatChain, Words
from gen.reference.effect_tapes import Counter, Values, evaluate, rounded

Fields = list[tuple[str, str]]
Lowered = FixedComponent | FloatComponent

_COUNT_LIMIT = 0xFFFF
_KELVIN_END = KELVIN_LIMIT << KELVIN_BITS
_START_END = 1 << 30


class _Component:
    """The states of one component's effects."""

    def __init__(self, part: EffectComponent, lowered: Lowered, counter: Counter, lanes: int) -> None:
        self.part, self._counter = part, counter
        self.chain: FixedChain | FloatChain | None = None
        if part.chain is not None:
            kind = FixedChain if isinstance(lowered, FixedComponent) else FloatChain
            self.chain = kind(lowered, counter, lanes)  # type: ignore[arg-type]
        zero = np.zeros(lanes, dtype=np.int64)
        self.followers: list[IntArray] = [zero for _ in part.followers]
        self.inners: list[IntArray] = [zero for _ in part.inners]
        self.lags: list[IntArray] = [zero for _ in part.lags]
        self.shown: IntArray = zero

    def start(self, operands: Values, row: IntArray) -> IntArray:
        """Put the states to their start; the baseline's own start in mK."""
        part, tape = self.part, self.part.start
        values = evaluate(tape, operands, row)
        rise = self._counter.words(tape, 0, values[0], 0, _START_END)
        place = 1
        if self.chain is not None and part.chain is not None:
            words = self._counter.words(tape, place, values[place], part.chain.fraction_bits, part.chain.limit)
            self.chain.start(words)
            place += 1
        for number in range(len(part.followers)):
            words = self._counter.words(tape, place, values[place], KELVIN_BITS, _KELVIN_END)
            self.followers[number] = words << FOLLOWER_BITS
            place += 1
        for number, inner in enumerate(part.inners):
            end = KELVIN_LIMIT << inner.fraction_bits if inner.fraction_bits == KELVIN_BITS else 1 << WEIGHT_BITS
            words = self._counter.words(tape, place, values[place], inner.fraction_bits, end)
            self.inners[number] = words << FOLLOWER_BITS
            place += 1
        return rise

    def inner_operands(self, row: IntArray) -> dict[Operand, IntArray]:
        """What the inner states mean for the heat of this sample."""
        found: dict[Operand, IntArray] = {}
        for number, (inner, state) in enumerate(zip(self.part.inners, self.inners, strict=True)):
            target = np.asarray(inner.targets, dtype=np.int64)[row]
            distance = (state >> FOLLOWER_BITS) - target
            found["inner", number] = target + rounded(distance * inner.weight, WEIGHT_BITS)
        return found

    def drives(self, operands: Values, row: IntArray) -> list[IntArray]:
        """The chain's drive and the followers' targets, as words."""
        part, tape = self.part, self.part.drives
        values = evaluate(tape, operands, row)
        words = []
        for number, value in enumerate(values):
            if part.chain is not None and number == 0:
                words.append(self._counter.words(tape, 0, value, part.chain.fraction_bits, part.chain.limit))
            else:
                words.append(self._counter.words(tape, number, value, KELVIN_BITS, _KELVIN_END))
        return words

    def added(self, row: IntArray | None = None, drives: list[IntArray] | None = None) -> IntArray:
        """What all states add to the rise, in 2^-20 K: now, or after a sample with these drives."""
        total: IntArray = np.zeros_like(self.shown)
        place = 0
        if self.chain is not None and self.part.chain is not None:
            x = None if drives is None or row is None else self.chain.tried(row, drives[0])
            total = total + rounded(self.chain.word(x), self.part.chain.fraction_bits - KELVIN_BITS)
            place = 1
        for number, (follower, state) in enumerate(zip(self.part.followers, self.followers, strict=True)):
            if drives is not None:
                state = followed(state, drives[place + number], follower.factor)
            total = total + (state >> FOLLOWER_BITS)
        return total

    def advance(self, row: IntArray, drives: list[IntArray]) -> None:
        """One sample of all states that heat."""
        place = 0
        if self.chain is not None:
            self.chain.advance(row, drives[0])
            place = 1
        for number, follower in enumerate(self.part.followers):
            self.followers[number] = followed(self.followers[number], drives[place + number], follower.factor)
        for number, inner in enumerate(self.part.inners):
            target = np.asarray(inner.targets, dtype=np.int64)[row]
            self.inners[number] = followed(self.inners[number], target, inner.state.factor)

    def read(self, old: Values, new: Values, row: IntArray, *, first: bool) -> None:
        """What the sensor shows, given operands at the sample's start and end."""
        part, limit = self.part, _KELVIN_END
        for number, lag in enumerate(part.lags):
            tape = part.readings[number]
            x1 = self._counter.words(tape, 0, evaluate(tape, new, row)[0], KELVIN_BITS, limit)
            if first:
                self.lags[number] = x1 << FOLLOWER_BITS
            else:
                x0 = self._counter.words(tape, 0, evaluate(tape, old, row)[0], KELVIN_BITS, limit)
                word = self.lags[number] >> FOLLOWER_BITS
                self.lags[number] = self.lags[number] + (x0 - word) * lag.old + (x1 - word) * lag.new
                old = {**old, ("lagged", number): word}
            new = {**new, ("lagged", number): self.lags[number] >> FOLLOWER_BITS}
        tape = part.readings[-1]
        self.shown = self._counter.words(tape, 0, evaluate(tape, new, row)[0], KELVIN_BITS, limit)

    def words(self) -> Words:
        """In the order of the board's structure."""
        chain = self.chain.words() if self.chain is not None else []
        return [*chain, *self.followers, *self.inners, *self.lags, self.shown]


def followed(state: IntArray, target: IntArray, factor: int) -> IntArray:
    """A follower's state after a sample."""
    advanced: IntArray = state + (target - (state >> FOLLOWER_BITS)) * factor
    return advanced


class ReferenceEffects:
    """All effects of a program.

    Parameters
    ----------
    program
        What the board holds.
    components
        The baseline's components.
    channels
        Values at the start in thousandths, shape (channels, L); None: the neutral ones.
    lanes
        L.
    """

    def __init__(
        self, program: EffectsProgram, components: Sequence[Lowered], lanes: int, channels: IntArray | None = None
    ) -> None:
        self._program = program
        self._counter = Counter(lanes)
        self._channels = np.array([np.full(lanes, c.neutral) for c in program.channels], dtype=np.int64)
        self._elapsed: IntArray = np.zeros(lanes, dtype=np.int64)
        self._components = {
            part.index: _Component(part, components[part.index], self._counter, lanes) for part in program.components
        }
        zero = np.zeros(lanes, dtype=np.int64)
        self._rise = dict.fromkeys(program.tracked, zero)
        self._row = zero
        if channels is not None:
            self.set_channels(channels)

    def set_channels(self, values: IntArray) -> None:
        """Values of all channels in thousandths, shape (channels, L)."""
        for number, channel in enumerate(self._program.channels):
            self._channels[number] = self._counter.held(values[number], channel.low, channel.high)

    def starts(self, index: int) -> bool:
        """Whether effects decide where a component's baseline starts."""
        return index in self._components

    def start(self, index: int, rise_mK: IntArray) -> IntArray:
        """Put a component's states to their start; the rise in mK from which its baseline starts."""
        part = self._components.get(index)
        if part is None:
            return rise_mK
        end = KELVIN_LIMIT * 1000
        shown = self._counter.held(rise_mK, -end, end)
        return part.start({**self._common(), ("shown", 0): shown}, self._row)

    def started(self, index: int, word: IntArray, bits: int) -> None:
        """The component's baseline has started; `word` is its rise in 2^-bits K."""
        if index not in self._rise:
            return
        self._rise[index] = self._total(index, rounded(word, bits - KELVIN_BITS), self._added(index))
        part = self._components.get(index)
        if part is not None:
            operands = {**self._common(), ("rise", index): self._rise[index]}
            part.read(operands, operands, self._row, first=True)

    def step(self, pwm: IntArray, row: IntArray, words: Mapping[int, tuple[IntArray, int]]) -> None:
        """One sample, after the baseline's.

        Parameters
        ----------
        pwm, row
            Command, and its row of the domain.
        words
            By tracked component: its baseline's rise as a word, and that word's fraction bits.
        """
        base = {index: rounded(word, bits - KELVIN_BITS) for index, (word, bits) in words.items()}
        before = dict(self._rise)
        common = self._common() | {("reverse", 0): (pwm < 0).astype(np.int64)}
        inner = {index: part.inner_operands(row) for index, part in self._components.items()}
        rises: dict[Operand, IntArray] = {("rise", index): self._rise[index] for index in self._program.felt}
        middle: dict[Operand, IntArray] = {}
        first: dict[int, IntArray] = {}
        for index in self._program.felt:
            part = self._components.get(index)
            added = self._added(index)
            if part is not None and part.part.heats:
                drives = part.drives(common | rises | inner[index], row)
                added, first[index] = part.added(row, drives), drives[0]
            middle["rise", index] = (before[index] + self._total(index, base[index], added)) >> 1
        finer: dict[Operand, IntArray] = {}
        for index in self._program.felt:
            part = self._components.get(index)
            if part is None or not part.part.sixth or part.part.chain is None:
                continue
            drives = part.drives(common | middle | inner[index], row)
            change = self._total(index, base[index], part.added(row, drives)) - before[index]
            driven = rounded(drives[0] - first[index], part.part.chain.fraction_bits - KELVIN_BITS)
            share = np.asarray(part.part.sixth, dtype=np.int64)[row]
            mean = before[index] + (change >> 1) + rounded((change - driven) * share, WEIGHT_BITS)
            finer["rise", index] = self._held(index, mean)
        middle |= finer
        for index, part in self._components.items():
            part.advance(row, part.drives(common | middle | inner[index], row) if part.part.heats else [])
        elapsed = self._elapsed
        if self._program.elapsed_limit:
            self._elapsed = self._counter.held(elapsed + 1, 0, self._program.elapsed_limit)
        for index in self._program.tracked:
            self._rise[index] = self._total(index, base[index], self._added(index))
            if index in self._components:
                old = common | {("rise", index): before[index], ("elapsed", 0): elapsed}
                new = common | {("rise", index): self._rise[index], ("elapsed", 0): self._elapsed}
                self._components[index].read(old, new, row, first=False)

    @property
    def limited(self) -> IntArray:
        """How often a value was held to its limits, as the board counts."""
        chains = (part.chain for part in self._components.values())
        own = sum((c.saturations() for c in chains if isinstance(c, FloatChain)), np.zeros_like(self._row))
        return np.asarray(np.minimum(self._counter.count + own, _COUNT_LIMIT))

    def shown(self, index: int) -> IntArray | None:
        """What the sensor shows over the ambient, in 2^-20 K; None for a component without effects."""
        part = self._components.get(index)
        return None if part is None else part.shown

    def words(self) -> Words:
        """All states, in the order of :func:`effect_fields`."""
        found: Words = []
        for index in self._program.tracked:
            if index in self._components:
                found += self._components[index].words()
            found.append(self._rise[index])
        found += list(self._channels)
        if self._program.elapsed_limit:
            found.append(self._elapsed)
        return [*found, self.limited]

    def _common(self) -> dict[Operand, IntArray]:
        common: dict[Operand, IntArray] = {("channel", i): values for i, values in enumerate(self._channels)}
        return common | {("elapsed", 0): self._elapsed}

    def _added(self, index: int) -> IntArray:
        part = self._components.get(index)
        nothing: IntArray = np.zeros_like(self._row)
        return nothing if part is None else part.added()

    def _total(self, index: int, base: IntArray, added: IntArray) -> IntArray:
        return self._held(index, base + added)

    def _held(self, index: int, rise: IntArray) -> IntArray:
        low, high = self._program.rise_limits[self._program.tracked.index(index)]
        return self._counter.held(rise, low, high)


def effect_fields(program: EffectsProgram, components: Sequence[Lowered]) -> Fields:
    """Names and types of the states, in the order of the board's structure."""
    fields: Fields = []
    for index in program.tracked:
        lowered, part = components[index], program.component(index)
        name = lowered.name
        if part is not None:
            if part.chain is not None:
                fields += _chain_fields(f"{name}.E", lowered)
            fields += [(f"{name}.follower{i}", "<i8") for i in range(len(part.followers))]
            fields += [(f"{name}.inner{i}", "<i8") for i in range(len(part.inners))]
            fields += [(f"{name}.lag{i}", "<i8") for i in range(len(part.lags))]
            fields.append((f"{name}.shown", "<i4"))
        fields.append((f"{name}.rise", "<i4"))
    fields += [(f"channel.{channel.column}", "<i4") for channel in program.channels]
    if program.elapsed_limit:
        fields.append(("elapsed", "<u4"))
    return [*fields, ("limited", "<u2")]


def _chain_fields(name: str, lowered: Lowered) -> Fields:
    numbers = range(1, lowered.order + 1)
    fixed = isinstance(lowered, FixedComponent)
    if fixed:
        words = [(f"{name}{i}", "<i8") for i in numbers]
    else:
        words = [(f"{name}{i}.{half}", kind) for i in numbers for half, kind in (("lo", "u1"), ("hi", "<i4"))]
    kept = [*((f"{name}.R{i - 1}", "<u4") for i in numbers), (f"{name}.drive", "<i8" if fixed else "<i4")]
    return words + (kept if lowered.order > 1 else [])
