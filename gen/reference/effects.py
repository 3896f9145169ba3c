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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.lowering.effects.graph import Operand
from gen.lowering.effects.program import (
    FOLLOWER_BITS,
    GUARD_BITS,
    KELVIN_BITS,
    KELVIN_LIMIT,
    WEIGHT_BITS,
    EffectComponent,
    EffectsProgram,
)
from gen.lowering.effects.tape import Tape
from gen.lowering.float32 import LOW_BITS, FloatComponent
from gen.lowering.formats import CARRY_FACTOR, RESIDUE_BITS, WORD_BITS
from gen.lowering.program import FixedComponent
from gen.reference.float32 import FloatStep

Integers = NDArray[np.int64]
Values = Mapping[Operand, Integers]
Fields = list[tuple[str, str]]
Words = list[NDArray[Any]]
Lowered = FixedComponent | FloatComponent
AnyLowered = Sequence[object]
"""A program's components; those with effects are of the kinds above."""

_COUNT_LIMIT = 0xFFFF
_CHAIN_BITS = WORD_BITS + GUARD_BITS
_KELVIN_END = KELVIN_LIMIT << KELVIN_BITS
_START_END = 1 << 30


def rounded(value: Integers, shift: int) -> Integers:
    """value 2^-shift, to nearest; halves upwards. A negative shift is exact."""
    if shift <= 0:
        return value << -shift
    return (value + (1 << (shift - 1))) >> shift


def evaluate(tape: Tape, operands: Values, row: Integers) -> list[NDArray[Any]]:
    """Outputs of a tape: int64 with the outputs' formats, or float32.

    Parameters
    ----------
    tape
        What to execute.
    operands
        The board's whole numbers, shape (L,).
    row
        Row of the domain, shape (L,).
    """
    run = _fixed if tape.arithmetic == "fixed" else _single
    values = run(tape, operands, row)
    return [values[number] for number in tape.outputs]


def _fixed(tape: Tape, operands: Values, row: Integers) -> list[Integers]:
    values: list[Integers] = []
    for step in tape.steps:
        a = [values[n] for n in step.args]
        match step.op:
            case "operand":
                assert step.operand is not None
                value = operands[step.operand]
            case "constant":
                value = np.full(row.shape, step.table[0], dtype=np.int64)
            case "row":
                value = np.asarray(step.table, dtype=np.int64)[row]
            case "mul":
                value = rounded(a[0] * a[1], step.shifts[0])
            case "neg":
                value = -a[0]
            case _:
                left, right = (rounded(x, s) for x, s in zip(a, step.shifts, strict=True))
                value = left + right if step.op == "add" else left - right
        values.append(value)
    return values


def _single(tape: Tape, operands: Values, row: Integers) -> list[NDArray[np.float32]]:
    values: list[NDArray[np.float32]] = []
    for step in tape.steps:
        a = [values[n] for n in step.args]
        match step.op:
            case "operand":
                assert step.operand is not None
                value = operands[step.operand].astype(np.float32) * np.float32(2.0**-step.q)
            case "constant":
                value = np.full(row.shape, step.table[0], dtype=np.float32)
            case "row":
                value = np.asarray(step.table, dtype=np.float32)[row]
            case "mul":
                value = a[0] * a[1]
            case "neg":
                value = -a[0]
            case "add":
                value = a[0] + a[1]
            case _:
                value = a[0] - a[1]
        values.append(value)
    return values


class Counter:
    """How often each lane's values were held to their limits."""

    def __init__(self, lanes: int) -> None:
        self.count: Integers = np.zeros(lanes, dtype=np.int64)

    def held(self, value: Integers, low: int, high: int) -> Integers:
        """The value within its limits, both included."""
        within = np.clip(value, low, high)
        self.count = self.count + (within != value)
        return np.asarray(within)

    def words(self, tape: Tape, number: int, value: NDArray[Any], bits: int, end: int) -> Integers:
        """An output of a tape as words of 2^-bits, within +/- end."""
        if tape.arithmetic == "fixed":
            return self.held(rounded(value, tape.output_bits(number) - bits), -end, end)
        words, limit = value * np.float32(2.0**bits), np.float32(end)
        high, low = ~(words < limit), ~(words > -limit)
        self.count = self.count + (high | low)
        return np.where(high, end, np.where(low, -end, np.trunc(np.where(high | low, 0.0, words)))).astype(np.int64)


def product(difference: Integers, rate: Integers, shift: int) -> Integers:
    """difference rate 2^-shift, rounded down; 40 by 32 bits, in two parts that fit 64."""
    return ((difference >> 16) * rate + ((difference & 0xFFFF) * rate >> 16)) >> (shift - 16)


class FixedChain:
    """A component's recursion in fixed point, with whole products and every word held to its bits."""

    def __init__(self, component: FixedComponent, counter: Counter, lanes: int) -> None:
        self._component, self._layout = component, component.layout
        self._counter = counter
        self.x = [np.zeros(lanes, dtype=np.int64) for _ in range(component.order)]
        self.rates = [np.zeros(lanes, dtype=np.int64) for _ in range(component.order)]
        self.drive: Integers = np.zeros(lanes, dtype=np.int64)

    def start(self, words: Integers) -> None:
        """Rest at a rise in words that are read."""
        self.x = [words << RESIDUE_BITS, *(np.zeros_like(words) for _ in self.x[1:])]
        self.rates = [np.zeros_like(words) for _ in self.rates]
        self.drive = np.zeros_like(words)

    def word(self, x: list[Integers] | None = None) -> Integers:
        """What is read of the rise."""
        return (self.x if x is None else x)[0] >> RESIDUE_BITS

    def tried(self, row: Integers, drive: Integers) -> list[Integers]:
        """The state after a sample with this drive."""
        rates = self._at(row)
        x = list(self.x)
        if self._component.order > 1:
            shift = self._layout.chain_shifts[-1]
            old = self._increment(x, self.rates, self.drive)
            change = (self._increment(x, rates, drive) - old >> 8) * CARRY_FACTOR >> (8 + shift)
            place = self._component.order - 2
            x[place] = self._limited(x[place] + change, _CHAIN_BITS)
        for _ in range(self._component.substeps):
            self._advance(x, self._increment(x, rates, drive))
        return x

    def advance(self, row: Integers, drive: Integers) -> None:
        """Take that sample."""
        self.x = self.tried(row, drive)
        self.rates, self.drive = self._at(row), drive

    def words(self) -> Words:
        """In the order of the board's structure."""
        return [*self.x, *([*self.rates, self.drive] if self._component.order > 1 else [])]

    def _at(self, row: Integers) -> list[Integers]:
        return [self._component.rates[row, i] for i in range(self._component.order)]

    def _increment(self, x: list[Integers], rates: list[Integers], drive: Integers) -> Integers:
        shifts = self._layout.product_shifts
        inner = self._limited((x[0] >> RESIDUE_BITS) - drive, _CHAIN_BITS - RESIDUE_BITS)
        for i in range(self._component.order - 1):
            inner = (x[i + 1] >> RESIDUE_BITS) + product(inner, rates[i], shifts[i]) + 1
            inner = self._limited(inner, _CHAIN_BITS - RESIDUE_BITS)
        return -product(inner, rates[-1], shifts[-1])

    def _advance(self, x: list[Integers], q: Integers) -> None:
        shift = self._layout.chain_shifts

        def add(place: int, term: Integers) -> None:
            x[place] = self._limited(x[place] + term, _CHAIN_BITS)

        match self._component.order:
            case 1:
                add(0, q)
            case 2:
                add(0, (x[1] >> shift[0]) + (q >> (shift[0] + 1)))
                add(1, q)
            case 3:
                add(0, x[1] >> shift[0])
                add(2, q)
                add(1, x[2] >> shift[1])
            case _:
                add(0, (x[1] >> shift[0]) + (x[2] >> (shift[0] + shift[1] + 1)))
                add(1, x[2] >> shift[1])
                add(3, q)
                add(2, x[3] >> shift[2])

    def _limited(self, value: Integers, bits: int) -> Integers:
        return self._counter.held(value, -(1 << (bits - 1)), (1 << (bits - 1)) - 1)


class FloatChain:
    """The same in float32: the baseline's own recursion, once more, perhaps in a coarser unit (all words scale)."""

    def __init__(self, component: FloatComponent, counter: Counter, lanes: int) -> None:
        self._component, self._counter = component, counter
        self._step = FloatStep(component)
        self._seen: Integers = np.zeros(lanes, dtype=np.int64)
        self._rates = component.rate_words
        self.start(np.zeros(lanes, dtype=np.int64))

    def start(self, words: Integers) -> None:
        """See :class:`FixedChain`."""
        self.x = [words << LOW_BITS, *(np.zeros_like(words) for _ in range(1, self._component.order))]
        self.rates = [np.zeros(words.shape, dtype=np.float32) for _ in range(self._component.order)]
        self.drive = np.zeros_like(words)

    def word(self, x: list[Integers] | None = None) -> Integers:
        """See :class:`FixedChain`."""
        return (self.x if x is None else x)[0] >> LOW_BITS

    def tried(self, row: Integers, drive: Integers) -> list[Integers]:
        """See :class:`FixedChain`."""
        rates, x, step = self._at(row), list(self.x), self._step
        substeps = self._component.substeps
        if self._component.order > 1:
            old = step.increment(x, self.rates, self.drive)
            new = step.increment(x, rates, drive)
            step.advance(x, step.carry(x, rates, old, new, np.ones(len(row), dtype=bool)))
            substeps -= 1
        for _ in range(substeps):
            step.advance(x, step.increment(x, rates, drive))
        return x

    def advance(self, row: Integers, drive: Integers) -> None:
        """See :class:`FixedChain`."""
        self.x = self.tried(row, drive)
        self.rates, self.drive = self._at(row), drive

    def saturations(self) -> Integers:
        """How often the recursion itself limited a word (a component without a proof)."""
        return np.asarray(np.zeros_like(self.drive) + self._step.saturations)

    def words(self) -> Words:
        """See :class:`FixedChain`."""
        kept: Words = [*(rate.view(np.uint32) for rate in self.rates), self.drive]
        return [*FloatStep.words(self.x), *(kept if self._component.order > 1 else [])]

    def _at(self, row: Integers) -> list[NDArray[np.float32]]:
        return [np.ascontiguousarray(self._rates[row, i]) for i in range(self._component.order)]


class _Component:
    """The states of one component's effects."""

    def __init__(self, part: EffectComponent, lowered: Lowered, counter: Counter, lanes: int) -> None:
        self.part, self._counter = part, counter
        self.chain: FixedChain | FloatChain | None = None
        if part.chain is not None:
            kind = FixedChain if isinstance(lowered, FixedComponent) else FloatChain
            self.chain = kind(lowered, counter, lanes)  # type: ignore[arg-type]
        zero = np.zeros(lanes, dtype=np.int64)
        self.followers: list[Integers] = [zero for _ in part.followers]
        self.inners: list[Integers] = [zero for _ in part.inners]
        self.lags: list[Integers] = [zero for _ in part.lags]
        self.shown: Integers = zero

    def start(self, operands: Values, row: Integers) -> Integers:
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

    def inner_operands(self, row: Integers) -> dict[Operand, Integers]:
        """What the inner states mean for the heat of this sample."""
        found: dict[Operand, Integers] = {}
        for number, (inner, state) in enumerate(zip(self.part.inners, self.inners, strict=True)):
            target = np.asarray(inner.targets, dtype=np.int64)[row]
            distance = (state >> FOLLOWER_BITS) - target
            found["inner", number] = target + rounded(distance * inner.weight, WEIGHT_BITS)
        return found

    def drives(self, operands: Values, row: Integers) -> list[Integers]:
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

    def added(self, row: Integers | None = None, drives: list[Integers] | None = None) -> Integers:
        """What all states add to the rise, in 2^-20 K: now, or after a sample with these drives."""
        total: Integers = np.zeros_like(self.shown)
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

    def advance(self, row: Integers, drives: list[Integers]) -> None:
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

    def read(self, old: Values, new: Values, row: Integers, *, first: bool) -> None:
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


def followed(state: Integers, target: Integers, factor: int) -> Integers:
    """A follower's state after a sample."""
    advanced: Integers = state + (target - (state >> FOLLOWER_BITS)) * factor
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
        self, program: EffectsProgram, components: AnyLowered, lanes: int, channels: Integers | None = None
    ) -> None:
        self._program = program
        self._counter = Counter(lanes)
        self._channels = np.array([np.full(lanes, c.neutral) for c in program.channels], dtype=np.int64)
        self._elapsed: Integers = np.zeros(lanes, dtype=np.int64)
        self._components = {
            part.index: _Component(part, _plain(components[part.index]), self._counter, lanes)
            for part in program.components
        }
        zero = np.zeros(lanes, dtype=np.int64)
        self._rise = dict.fromkeys(program.tracked, zero)
        self._row = zero
        if channels is not None:
            self.set_channels(channels)

    def set_channels(self, values: Integers) -> None:
        """Values of all channels in thousandths, shape (channels, L)."""
        for number, channel in enumerate(self._program.channels):
            self._channels[number] = self._counter.held(values[number], channel.low, channel.high)

    def start(self, index: int, rise_mK: Integers) -> Integers:
        """Put a component's states to their start; the rise in mK from which its baseline starts."""
        part = self._components.get(index)
        if part is None:
            return rise_mK
        end = KELVIN_LIMIT * 1000
        shown = self._counter.held(rise_mK, -end, end)
        return part.start({**self._common(), ("shown", 0): shown}, self._row)

    def started(self, index: int, word: Integers, bits: int) -> None:
        """The component's baseline has started; `word` is its rise in 2^-bits K."""
        if index not in self._rise:
            return
        self._rise[index] = self._total(index, rounded(word, bits - KELVIN_BITS), self._added(index))
        part = self._components.get(index)
        if part is not None:
            operands = {**self._common(), ("rise", index): self._rise[index]}
            part.read(operands, operands, self._row, first=True)

    def step(self, pwm: Integers, row: Integers, words: Mapping[int, tuple[Integers, int]]) -> None:
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
        rises: dict[Operand, Integers] = {("rise", index): self._rise[index] for index in self._program.felt}
        middle: dict[Operand, Integers] = {}
        first: dict[int, Integers] = {}
        for index in self._program.felt:
            part = self._components.get(index)
            added = self._added(index)
            if part is not None and part.part.heats:
                drives = part.drives(common | rises | inner[index], row)
                added, first[index] = part.added(row, drives), drives[0]
            middle["rise", index] = (before[index] + self._total(index, base[index], added)) >> 1
        finer: dict[Operand, Integers] = {}
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
    def limited(self) -> Integers:
        """How often a value was held to its limits, as the board counts."""
        chains = (part.chain for part in self._components.values())
        own = sum((c.saturations() for c in chains if isinstance(c, FloatChain)), np.zeros_like(self._row))
        return np.asarray(np.minimum(self._counter.count + own, _COUNT_LIMIT))

    def shown(self, index: int) -> Integers | None:
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

    def _common(self) -> dict[Operand, Integers]:
        common: dict[Operand, Integers] = {("channel", i): values for i, values in enumerate(self._channels)}
        return common | {("elapsed", 0): self._elapsed}

    def _added(self, index: int) -> Integers:
        part = self._components.get(index)
        nothing: Integers = np.zeros_like(self._row)
        return nothing if part is None else part.added()

    def _total(self, index: int, base: Integers, added: Integers) -> Integers:
        return self._held(index, base + added)

    def _held(self, index: int, rise: Integers) -> Integers:
        low, high = self._program.rise_limits[self._program.tracked.index(index)]
        return self._counter.held(rise, low, high)


def effect_fields(program: EffectsProgram, components: AnyLowered) -> Fields:
    """Names and types of the states, in the order of the board's structure."""
    fields: Fields = []
    for index in program.tracked:
        lowered, part = _plain(components[index]), program.component(index)
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


def _plain(component: object) -> Lowered:
    assert isinstance(component, FixedComponent | FloatComponent), "the fast form has no effects"
    return component


def _chain_fields(name: str, lowered: Lowered) -> Fields:
    numbers = range(1, lowered.order + 1)
    fixed = isinstance(lowered, FixedComponent)
    if fixed:
        words = [(f"{name}{i}", "<i8") for i in numbers]
    else:
        words = [(f"{name}{i}.{half}", kind) for i in numbers for half, kind in (("lo", "u1"), ("hi", "<i4"))]
    kept = [*((f"{name}.R{i - 1}", "<u4") for i in numbers), (f"{name}.drive", "<i8" if fixed else "<i4")]
    return words + (kept if lowered.order > 1 else [])
