"""A network, word for word as the board computes it, over many lanes at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import BoolArray, FloatArray, IntArray, RecordArray, SingleArray
from gen.lowering.network import fixed, float32
from gen.lowering.network.factors import WORD_BITS, scaled
from gen.lowering.network.gains import share
from gen.lowering.network.program import NetworkProgram, Reading, StateProgram, TermProgram
from gen.lowering.network.series import FIRST, WEIGHT, WHOLE
from gen.lowering.network.start import degrees, scale_of
from gen.reference.flags import OUTSIDE_VALIDITY, PWM_CLAMPED, SATURATED, START_CLAMPED, STARTED
from gen.reference.float32 import accumulated
from gen.reference.thousandths import thousandths

_LIMIT = 0xFFFF


class ReferenceNetwork:
    """A program's network, advanced over L independent lanes.

    Parameters
    ----------
    program
        What the board holds.
    domain, validity
        Ranges of |PWM|.
    start_mK
        Reading over the ambient at the start, in thousandths of a kelvin, by component: one for each lane.
    channels
        What is told at the start, in thousandths, shape (channels, L), the ambient first; None: the neutral values.
    """

    def __init__(
        self,
        program: NetworkProgram,
        domain: tuple[int, int],
        validity: tuple[int, int],
        start_mK: Mapping[str, Sequence[int]],
        channels: IntArray | None = None,
    ) -> None:
        self._program = program
        self._domain, self._validity = domain, validity
        self.lanes = len(start_mK[program.readings[0].name])
        self._low_bits = fixed.LOW_BITS if program.arithmetic == "fixed" else float32.LOW_BITS
        self._limited: IntArray = np.zeros(self.lanes, dtype=np.int64)
        neutral = np.array([channel.neutral for channel in program.channels], dtype=np.int64)
        self._channels: IntArray = np.repeat(neutral[:, None], self.lanes, axis=1)
        if channels is not None:
            self.set_channels(channels)
        self._flags: IntArray = np.zeros(self.lanes, dtype=np.int64)
        self._command: IntArray = np.zeros(self.lanes, dtype=np.int64)
        self._sums = (FixedSums if program.arithmetic == "fixed" else FloatSums)(program)
        self._state: IntArray = np.zeros((len(program.states), self.lanes), dtype=np.int64)
        #: Readings over the ambient at the start, in thousandths of a kelvin, before their limits.
        self.starts_mK = {name: np.asarray(given, dtype=np.int64) for name, given in start_mK.items()}
        self._start()

    def _start(self) -> None:
        program, room = self._program, self._channels[0]
        ambient = self._ambient()
        high = np.repeat(ambient[None], len(program.states), axis=0)
        high[list(program.drifts)] = 0
        sensed = []
        for reading in program.readings:
            low_mC, high_mC = program.start_mC
            asked = self.starts_mK[reading.name] + room
            self._flags |= np.where((asked < low_mC) | (asked > high_mC), START_CLAMPED, 0)
            word = degrees(np.clip(asked, low_mC, high_mC), scale_of(program.fraction_bits)) - reading.offset
            if reading.gain is not None and program.gains is not None:
                word = word - share(reading.gain.over(word, ambient), reading.gain.back, program.gains.back)
            high[reading.node] = high[reading.state] = word
            sensed.append(word)
        for weights, node in zip(program.rest, program.hidden, strict=True):
            pairs = zip(sensed, weights.tolist(), strict=True)
            total = sum((WHOLE.of(word - ambient, 0 * ambient + weight) for word, weight in pairs), 0 * ambient)
            high[node] = ambient + (total >> program.rest_bits - 8 * WHOLE.least)
        self._state = high << self._low_bits

    def _ambient(self) -> IntArray:
        return degrees(self._channels[0], scale_of(self._program.fraction_bits))

    @property
    def within_ranges(self) -> BoolArray:
        """Lanes in which no channel was held to its range so far, shape (L,)."""
        return np.asarray(self._limited == 0)

    @property
    def saturations(self) -> IntArray:
        """How often a told value was held to its range, as the board's 16-bit counter has it."""
        return self._limited

    def set_channels(self, values: IntArray) -> None:
        """Tell the channels' values from now on, in thousandths, shape (channels, L)."""
        for number in range(len(self._program.channels)):
            self.set_channel(number, values[number])

    def set_channel(self, number: int, values: IntArray) -> None:
        """Tell one channel's values from now on, in thousandths, shape (L,)."""
        channel = self._program.channels[number]
        held = np.clip(values, channel.low, channel.high)
        self._limited = np.minimum(self._limited + (held != values), _LIMIT)
        self._channels[number] = held

    def step(self, pwm: IntArray) -> None:
        """Advance by one sample with the PWM of each lane, shape (L,)."""
        (first, last), (low, high) = self._domain, self._validity
        magnitude = np.abs(pwm)
        within = np.clip(magnitude, first, last)
        flags = np.where(within != magnitude, PWM_CLAMPED, 0)
        flags |= np.where((within < low) | (within > high), OUTSIDE_VALIDITY, 0)
        self._flags = (self._flags & START_CLAMPED) | flags | np.where(self._limited > 0, SATURATED, 0)
        self._command = pwm
        factors = [factor.word(self._channels[factor.channel]) for factor in self._program.factors]
        upper = self._state >> self._low_bits
        self._state = self._sums.advance(self._state, upper, self._ambient(), within - first, factors)

    @property
    def _reading_words(self) -> IntArray:
        upper, ambient = self._state >> self._low_bits, self._ambient()
        drifted = [0 if r.drift is None else upper[r.drift] for r in self._program.readings]
        readings = zip(self._program.readings, drifted, strict=True)
        return np.array([self._shown(r, upper[r.state], ambient) + r.offset + drift for r, drift in readings])

    def _shown(self, reading: Reading, word: IntArray, ambient: IntArray) -> IntArray:
        """What a sensor shows of a temperature without its offset."""
        gain, shape = reading.gain, self._program.gains
        if gain is None or shape is None:
            return word
        return word + share(gain.over(word, ambient), gain.word, shape.shown)

    @property
    def readings(self) -> FloatArray:
        """Reading of every component as its word, shape (components, L), in degC."""
        return np.asarray(self._reading_words * 2.0**-self._program.fraction_bits, dtype=np.float64)

    @property
    def temperatures(self) -> FloatArray:
        """Every state as its upper word, shape (states, L), in degC."""
        upper = self._state >> self._low_bits
        return np.asarray(upper * 2.0**-self._program.fraction_bits, dtype=np.float64)

    def copy_lanes(self, source: NDArray[np.intp], target: NDArray[np.intp]) -> None:
        """Let lanes go on from the states and channels of others."""
        self._state[:, target] = self._state[:, source]
        self._channels[:, target] = self._channels[:, source]

    @property
    def rises(self) -> FloatArray:
        """Reading of every component over the ambient that was told last, shape (components, L), in K."""
        return np.asarray((self._reading_words - self._ambient()) * 2.0**-self._program.fraction_bits, dtype=np.float64)

    @property
    def rises_mK(self) -> IntArray:
        """The same in thousandths of a kelvin, to nearest."""
        return thousandths(self._reading_words - self._ambient(), self._program.fraction_bits)

    def node_mC(self, state: int) -> IntArray:
        """A state's temperature in thousandths of a degree Celsius, to nearest, shape (L,): of a hidden node, too."""
        return thousandths(self._state[state] >> self._low_bits, self._program.fraction_bits)

    def state_record(self) -> RecordArray:
        """The state words alone, shape (L,); the record's other fields are 0."""
        record = np.zeros(self.lanes, dtype=record_type(self._program))
        for state, words in zip(self._program.states, self._state, strict=True):
            record[f"{state.name}.T.lo"] = words & ((1 << self._low_bits) - 1)
            record[f"{state.name}.T.hi"] = words >> self._low_bits
        return record

    def record(self) -> RecordArray:
        """Everything that the board keeps after a sample, shape (L,), see :func:`record_type`."""
        record = self.state_record()
        for channel, values in zip(self._program.channels, self._channels, strict=True):
            record[f"channel.{channel.column}"] = values
        record["command"] = self._command
        record["flags"] = self._flags | STARTED
        record["limited"] = self._limited
        return record


def state_fields(program: NetworkProgram) -> list[tuple[str, str]]:
    """Names and types of the states' words, in the order of the board's structure."""
    parts = (("lo", "<u2" if program.arithmetic == "fixed" else "u1"), ("hi", "<i4"))
    return [(f"{state.name}.T.{half}", kind) for state in program.states for half, kind in parts]


def record_type(program: NetworkProgram) -> np.dtype[np.void]:
    """The board's model structure, byte by byte: states, channels, PWM and flags, packed and little endian."""
    channels = [(f"channel.{channel.column}", "<i4") for channel in program.channels]
    return np.dtype([*state_fields(program), *channels, ("command", "<i2"), ("flags", "u1"), ("limited", "<u2")])


class _Layout:
    """All terms as arrays, sorted by target: who is read, who is changed."""

    def __init__(self, program: NetworkProgram) -> None:
        self.program = program
        own = [(k, term) for k, state in enumerate(program.states) for term in state.terms]
        self.terms: list[TermProgram] = [term for _, term in own]
        self.target = np.array([k for k, _ in own])
        size = len(program.states)
        sources = {"state": 0, "ambient": size, "reference": size + 1}
        self.source = np.array(
            [t.term.other if t.term.source == "state" else sources[t.term.source] for t in self.terms]
        )
        self.reference = np.array([t.reference for t in self.terms], dtype=np.int64)[:, None]
        self.is_reference = self.source == size + 1
        self.growing = np.array([t.term.growing for t in self.terms])[:, None]
        self.laws = [(k, term.term.law) for k, term in enumerate(self.terms) if term.term.law is not None]
        self.first = np.flatnonzero(np.diff(self.target, prepend=-1))
        self.orders = np.array([state.orders for state in program.states])

    def driven(self, temperatures: IntArray, ambient: IntArray) -> list[tuple[IntArray, IntArray]]:
        """What drives heat along each path with a law, from its first end, and its slope."""
        ends = [(own, temperatures[own.first], own.second) for own in self.program.laws]
        return [own.evaluate(one, ambient if other is None else temperatures[other]) for own, one, other in ends]

    def differences(
        self, temperatures: IntArray, ambient: IntArray, driven: Sequence[tuple[IntArray, IntArray]]
    ) -> IntArray:
        """Source less target of each term, or what its law makes of it; the other way round where it grows."""
        sources = np.concatenate([temperatures, ambient[None], np.zeros((1, ambient.size), dtype=np.int64)])
        given = sources[self.source] + np.where(self.is_reference[:, None], self.reference, 0)
        made = given - temperatures[self.target]
        for k, law in self.laws:
            made[k] = -driven[law.index][0] if law.first == self.target[k] else driven[law.index][0]
        return np.asarray(np.where(self.growing, -made, made), dtype=np.int64)

    def of_series(self, y: NDArray[Any]) -> NDArray[Any]:
        """The same of a term of the series, which neither the ambient nor a fixed temperature has."""
        padded = np.concatenate([y, np.zeros((2, y.shape[1]), dtype=y.dtype)])
        made = padded[self.source] - y[self.target]
        return np.asarray(np.where(self.growing, -made, made))


class FixedSums:
    """Sums in fixed point."""

    def __init__(self, program: NetworkProgram) -> None:
        self._layout = _Layout(program)
        self._program = program
        self._words = np.stack([term.words for term in self._layout.terms]).astype(np.int64)
        self._shift = np.array([state.shift for state in program.states])[:, None]

    def advance(
        self, state: IntArray, upper: IntArray, ambient: IntArray, row: IntArray, factors: list[IntArray]
    ) -> IntArray:
        """States after one sample, shape (n, L)."""
        program, layout = self._program, self._layout
        rates = self._words[:, row]
        for k, term in enumerate(layout.terms):
            rates[k] = _scaled(rates[k], term.term.factors, factors)
        driven = layout.driven(upper, ambient)
        total = self._gathered(1, layout.differences(upper, ambient, driven), rates)
        for k, own in enumerate(program.states):
            total[k] += self._heat(own, row, factors)
        for k, law in layout.laws:
            rates[k] = scaled(rates[k], driven[law.index][1])
        unit = fixed.LOW_BITS + program.fraction_bits
        change = y = np.zeros_like(state)
        for order in range(1, program.orders + 1):
            bits = self._shift + fixed.sum_bits(program.products, program.series_bits, program.fraction_bits, order)
            if order > 1:
                total = self._gathered(order, layout.of_series(y), rates)
                total = np.where((layout.orders >= order)[:, None], total, 0)
            change = change + _shifted(total, bits - unit)
            if order < program.orders:
                y = self._handed_on(total, bits - program.series_bits[order - 1], order + 1)
        return np.asarray(state + change, dtype=np.int64)

    def _handed_on(self, total: IntArray, bits: IntArray, order: int) -> IntArray:
        """A sum as a word for the next order; a third or a fifth is taken a byte below it."""
        if order not in WEIGHT:
            return _shifted(total, bits)
        below = 8 if self._program.products[order - 1].width < 4 else 0
        return weighted(_shifted(total, bits - below), order) >> below

    def _gathered(self, order: int, differences: IntArray, rates: IntArray) -> IntArray:
        """Sum of each state's products."""
        product = self._program.products[order - 1]
        made = product.of(differences, rates >> 8 * (4 - product.width))
        return np.asarray(np.add.reduceat(made, self._layout.first, axis=0), dtype=np.int64)

    def _heat(self, state: StateProgram, row: IntArray, factors: list[IntArray]) -> IntArray:
        total = np.zeros(row.size, dtype=np.int64)
        for heat in state.heats:
            word = np.asarray(heat.words, dtype=np.int64)[row]
            own = heat.heat.factors
            if own:
                total += FIRST.of(factors[own[0]], _scaled(word, own[1:], factors))
            else:
                total += word << heat.left
        return total


def _shifted(total: IntArray, bits: IntArray) -> IntArray:
    """Down by each state's bits, or up where they are negative."""
    return np.asarray((total << np.maximum(-bits, 0)) >> np.maximum(bits, 0), dtype=np.int64)


def weighted(y: IntArray, order: int) -> IntArray:
    """A third or a fifth of y: 85/256 or 51/256 of it, and a 256th of that more."""
    part = y * WEIGHT[order] >> 8
    return part + (part >> 8)


def _scaled(word: IntArray, own: Sequence[int], factors: list[IntArray]) -> IntArray:
    for k in own:
        word = scaled(word, factors[k])
    return word


class FloatSums:
    """Sums in float32, one operation after the other in the board's order."""

    def __init__(self, program: NetworkProgram) -> None:
        self._layout = _Layout(program)
        self._program = program
        self._rates = np.stack([np.asarray(term.words, dtype=np.float32) for term in self._layout.terms])
        starts = self._layout.first
        #: Which terms are the first, second, .. of their states.
        counts = np.diff(np.append(starts, len(self._layout.terms)))
        self._places = [(starts[counts > k] + k, np.flatnonzero(counts > k)) for k in range(int(counts.max()))]

    def advance(
        self, state: IntArray, upper: IntArray, ambient: IntArray, row: IntArray, factors: list[IntArray]
    ) -> IntArray:
        """States after one sample, shape (n, L)."""
        program, layout = self._program, self._layout
        singles = [
            word.astype(np.float32) * np.float32(2.0**-own.bits)
            for word, own in zip(factors, program.factors, strict=True)
        ]
        rates = self._rates[:, row]
        for k, term in enumerate(layout.terms):
            for factor in term.term.factors:
                rates[k] = rates[k] * singles[factor]
        total = np.zeros((len(program.states), row.size), dtype=np.float32)
        for k, own in enumerate(program.states):
            for heat in own.heats:
                warmth = np.asarray(heat.words, dtype=np.float32)[row]
                for factor in heat.heat.factors:
                    warmth = warmth * singles[factor]
                total[k] = total[k] + warmth
        driven = layout.driven(upper, ambient)
        y = self._gathered(total, layout.differences(upper, ambient, driven).astype(np.float32), rates)
        for k, law in layout.laws:
            rates[k] = rates[k] * (driven[law.index][1].astype(np.float32) * np.float32(2.0**-WORD_BITS))
        change = y
        for order in range(2, program.orders + 1):
            before = np.asarray(layout.of_series(y), dtype=np.float32)
            total = self._gathered(np.zeros_like(total), before, rates)
            partakes = (layout.orders >= order)[:, None]
            y = np.where(partakes, total * np.float32(1.0 / order), np.float32(0.0))
            change = np.where(partakes, change + y, change)
        return accumulated(state, change, 0)

    def _gathered(self, total: SingleArray, differences: SingleArray, rates: SingleArray) -> SingleArray:
        products = differences * rates
        total = total.copy()
        for terms, targets in self._places:
            total[targets] = total[targets] + products[terms]
        return total
