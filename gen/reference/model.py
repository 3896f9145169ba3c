"""The whole model as the board runs it: words, coefficients and flags after every sample, for many runs at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray, RecordArray
from gen.lowering.effects.program import KELVIN_BITS
from gen.lowering.program import Program
from gen.lowering.recursion.dynamics import domain_rows
from gen.reference.effects import ReferenceEffects, effect_fields
from gen.reference.flags import GAIN_ZEROED, OUTSIDE_VALIDITY, PWM_CLAMPED, SATURATED, START_CLAMPED, STARTED
from gen.reference.lanes import coefficient_fields, lanes_of, state_fields, word_bits
from gen.reference.thousandths import thousandths

_SATURATION_LIMIT = 0xFFFF
#: The ambient over the reference, in thousandths of a kelvin, at the end of the board's state.
AMBIENT_FIELD = ("ambient_mK", "<i4")


class ReferenceModel:
    """A program's components, advanced together over L independent lanes.

    Parameters
    ----------
    program
        What the board holds.
    start_mK
        Rise at the start in thousandths of a kelvin, one for each lane: of all components, or by component.
    channels
        What the effects are told at the start, in thousandths, shape (channels, L); None: the neutral values.
    """

    def __init__(
        self,
        program: Program,
        start_mK: Sequence[int] | Mapping[str, Sequence[int]],
        channels: IntArray | None = None,
    ) -> None:
        self._program = program
        starts = dict(start_mK) if isinstance(start_mK, Mapping) else {c.name: start_mK for c in program.components}
        self.lanes = len(starts[program.components[0].name])
        self._effects: ReferenceEffects | None = None
        if program.effects is not None:
            self._effects = ReferenceEffects(program.effects, program.components, self.lanes, channels)
            for index, name in enumerate(program.model.component_names):
                shown = np.asarray(starts[name], dtype=np.int64)
                starts[name] = self._effects.start(index, shown).tolist()
        self._ambient = program.ambient
        self._over: IntArray = np.zeros(self.lanes, dtype=np.int64)
        if self._ambient is not None:
            self._over = self._over_of(channels)
            for index, name in enumerate(program.model.component_names):
                if self._effects is None or not self._effects.starts(index):
                    starts[name] = (np.asarray(starts[name], dtype=np.int64) + self._over).tolist()
        #: Rise from which each component's baseline starts, in thousandths of a kelvin, before its limits: over the
        #: reference, where changes of the ambient pass the dynamics.
        self.starts_mK = {name: np.asarray(given, dtype=np.int64) for name, given in starts.items()}
        self._components = [lanes_of(component, starts[component.name]) for component in program.components]
        for component in self._components:
            component.set_ambient(self._over)
        if self._effects is not None:
            for number, word in self._words().items():
                self._effects.started(number, *word)
        self._flags = np.zeros(self.lanes, dtype=np.int64)
        for component in self._components:
            self._flags |= np.where(component.limited, START_CLAMPED, 0)
        self._row: IntArray | None = None
        self._command: IntArray = np.zeros(self.lanes, dtype=np.int64)
        rows = domain_rows(program.model)
        self._row_flags = pwm_flags(program)
        self._first, self._last = int(rows[0]), int(rows[-1])

    @property
    def within_ranges(self) -> BoolArray:
        """Lanes in which no effect's value was held to its range so far, shape (L,)."""
        limited = self._effects.limited if self._effects is not None else np.zeros(self.lanes)
        return np.asarray(limited == 0)

    def _words(self) -> dict[int, tuple[IntArray, int]]:
        """Rises of the components that the effects watch, as words with their fraction bits."""
        tracked = self._program.effects.tracked if self._program.effects is not None else ()
        return {i: (self._components[i].state_words()[1], word_bits(self._program.components[i])) for i in tracked}

    def set_channels(self, values: IntArray) -> None:
        """Tell the channels' values from now on, in thousandths, shape (channels, L)."""
        if self._effects is not None:
            self._effects.set_channels(values)
        if self._ambient is not None:
            self._over = self._over_of(values)
            for component in self._components:
                component.set_ambient(self._over)

    def _over_of(self, channels: IntArray | None) -> IntArray:
        """The ambient over the reference, in thousandths of a kelvin, held to its range."""
        assert self._ambient is not None
        if channels is None:
            return np.zeros(self.lanes, dtype=np.int64)
        told = np.clip(np.asarray(channels[0], dtype=np.int64), self._ambient.low, self._ambient.high)
        return np.asarray(told - self._ambient.neutral)

    def step(self, pwm: IntArray) -> None:
        """Advance by one sample with the PWM of each lane, shape (L,)."""
        self._command = pwm
        magnitude = np.abs(pwm)
        row = np.clip(magnitude, self._first, self._last) - self._first
        clamped = np.where((magnitude < self._first) | (magnitude > self._last), PWM_CLAMPED, 0)
        self._flags = (self._flags & (START_CLAMPED | SATURATED)) | self._row_flags[row] | clamped
        before, self._row = self._row, row
        for component in self._components:
            component.sample(row, before)
        if self._program.saturates:
            self._flags = self._flags | np.where(self.saturations > 0, SATURATED, 0)
        if self._effects is not None:
            self._effects.step(pwm, row, self._words())
            self._flags = self._flags | np.where(self._effects.limited > 0, SATURATED, 0)

    @property
    def saturations(self) -> IntArray:
        """How often each lane had to limit a result, as the board's 16-bit counter has it."""
        total = sum((component.saturations() for component in self._components), np.zeros(self.lanes, dtype=np.int64))
        return np.minimum(total, _SATURATION_LIMIT)

    @property
    def rises(self) -> FloatArray:
        """Rise of every component over the ambient as the board gives it out, shape (components, L), in K."""
        rises = [component.rise() - self._over / 1000.0 for component in self._components]
        return np.array([value if own is None else own * 2.0**-KELVIN_BITS for value, own in self._with_shown(rises)])

    @property
    def readings(self) -> FloatArray:
        """Reading of every component as the board has it, shape (components, L), in degC, where its ambient moves."""
        assert self._ambient is not None, "the board counts from what it is not told"
        return np.asarray(self.rises + (self._over + self._ambient.neutral) / 1000.0)

    @property
    def rises_mK(self) -> IntArray:
        """The same in thousandths of a kelvin, to nearest, as integers."""
        rises = [component.rise_mK() - self._over for component in self._components]
        return np.array(
            [value if own is None else thousandths(own, KELVIN_BITS) for value, own in self._with_shown(rises)]
        )

    def _with_shown(self, rises: list[Any]) -> list[tuple[Any, IntArray | None]]:
        """Each component's rise, and what its sensor shows where effects change that."""
        shown = self._effects.shown if self._effects is not None else lambda _: None
        return [(rise, shown(index)) for index, rise in enumerate(rises)]

    def state_record(self) -> RecordArray:
        """The state words alone, shape (L,); the record's other fields are 0."""
        record = np.zeros(self.lanes, dtype=record_type(self._program))
        for component, lanes in zip(self._program.components, self._components, strict=True):
            for (name, _), word in zip(state_fields(component), lanes.state_words(), strict=True):
                record[name] = word
        if self._ambient is not None:
            record[AMBIENT_FIELD[0]] = self._over
        return record

    def record(self) -> RecordArray:
        """Everything that the board keeps after a sample, shape (L,), see :func:`record_type`."""
        record = self.state_record()
        assert self._row is not None, "no sample was taken yet"
        for component, lanes in zip(self._program.components, self._components, strict=True):
            for (name, _), word in zip(coefficient_fields(component), lanes.coefficient_words(self._row), strict=True):
                record[name] = word
        for name, member in _ambient_words(self._program):
            record[name] = self._components[member].ambient
        record["command"] = self._command
        record["flags"] = self._flags | STARTED
        if self._program.saturates:
            record["saturations"] = self.saturations
        if self._effects is not None and self._program.effects is not None:
            fields = effect_fields(self._program.effects, self._program.components)
            for (name, _), word in zip(fields, self._effects.words(), strict=True):
                record[name] = word
        return record


def pwm_flags(program: Program) -> IntArray:
    """The flags that each |PWM| of the domain brings with it, shape (rows,)."""
    rows = domain_rows(program.model)
    low, high = program.model.validity
    flags = np.where((rows < low) | (rows > high), OUTSIDE_VALIDITY, 0)
    for component in program.model.components:
        zeroed = (component.raw_gain(rows) < 0.0) & (component.effective_gain(rows) == 0.0) & (rows > 0)
        flags = flags | np.where(zeroed, GAIN_ZEROED, 0)
    return flags.astype(np.int64)


def _ambient_words(program: Program) -> list[tuple[str, int]]:
    """The ambient's words on the board: a name for each shape, and a component of it."""
    return [(f"ambient.{s.identifier}", s.members[0]) for s in program.shapes] if program.ambient is not None else []


def record_type(program: Program) -> np.dtype[np.void]:
    """The board's model structure, byte by byte: states, coefficients, PWM and flags, packed and little endian."""
    members = [program.components[member] for shape in program.shapes for member in shape.members]
    states = [field for component in members for field in state_fields(component)]
    states += [AMBIENT_FIELD] if program.ambient is not None else []
    coefficients = [field for component in members for field in coefficient_fields(component)]
    ambient = [(name, "<i4") for name, _ in _ambient_words(program)]
    tail = [*ambient, ("command", "<i2"), ("flags", "u1")]
    if program.saturates:
        tail.append(("saturations", "<u2"))
    if program.effects is not None:
        tail += effect_fields(program.effects, program.components)
    return np.dtype(states + coefficients + tail)
