"""The whole model as the board runs it: words, coefficients and flags after every sample, for many runs at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gen.lowering.dynamics import domain_rows
from gen.lowering.formats import RESIDUE_BITS
from gen.lowering.lower import Program
from gen.reference.fixed import FixedStep

Integers = NDArray[np.int64]
Record = NDArray[np.void]

OUTSIDE_VALIDITY, PWM_CLAMPED, GAIN_ZEROED, START_CLAMPED, SATURATED = 0x01, 0x02, 0x04, 0x08, 0x10
_SATURATION_LIMIT = 0xFFFF


class ReferenceModel:
    """A program's components, advanced together over L independent lanes.

    Parameters
    ----------
    program
        What the board holds.
    start_mK
        Rise of every component at the start, in thousandths of a kelvin, one for each lane.
    """

    def __init__(self, program: Program, start_mK: Sequence[int]) -> None:
        self._program = program
        self.lanes = len(start_mK)
        self._steps = [FixedStep(component) for component in program.components]
        self._states = [
            [np.array(words, dtype=np.int64) for words in zip(*(step.start(rise) for rise in start_mK), strict=True)]
            for step in self._steps
        ]
        self._flags = np.zeros(self.lanes, dtype=np.int64)
        for component in program.components:
            low, high = component.start_range_mK
            limited = [rise < low or rise > high for rise in start_mK]
            self._flags |= np.where(limited, START_CLAMPED, 0)
        self._row: Integers | None = None
        rows = domain_rows(program.model)
        self._row_flags = pwm_flags(program)
        self._first, self._last = int(rows[0]), int(rows[-1])

    def step(self, pwm: Integers) -> None:
        """Advance by one sample with the PWM of each lane, shape (L,)."""
        magnitude = np.abs(pwm)
        row = np.clip(magnitude, self._first, self._last) - self._first
        clamped = np.where((magnitude < self._first) | (magnitude > self._last), PWM_CLAMPED, 0)
        self._flags = (self._flags & (START_CLAMPED | SATURATED)) | self._row_flags[row] | clamped
        before, self._row = self._row, row
        changed = before is None or bool(np.any(before != row))
        for component, step, state in zip(self._program.components, self._steps, self._states, strict=True):
            rates = [component.rates[row, i] for i in range(component.order)]
            steady = component.steady[row]
            if component.order > 1 and changed:
                old = np.zeros(self.lanes, dtype=np.int64)
                if before is not None:
                    previous = [component.rates[before, i] for i in range(component.order)]
                    old = step.increment(state, previous, component.steady[before])
                step.carry(state, old, step.increment(state, rates, steady))
            for _ in range(component.substeps):
                step.advance(state, step.increment(state, rates, steady))
        if self._program.saturates:
            self._flags = self._flags | np.where(self.saturations > 0, SATURATED, 0)

    @property
    def saturations(self) -> Integers:
        """How often each lane had to limit a result, as the board's 16-bit counter has it."""
        total = sum((np.asarray(step.saturations) for step in self._steps), np.zeros(self.lanes, dtype=np.int64))
        return np.minimum(total, _SATURATION_LIMIT)

    @property
    def rises(self) -> NDArray[np.float64]:
        """Rise of every component, from the high words, shape (components, L), in K."""
        return np.array(
            [
                (state[0] >> RESIDUE_BITS) * 2.0 ** (RESIDUE_BITS - component.layout.fraction_bits[0])
                for component, state in zip(self._program.components, self._states, strict=True)
            ]
        )

    def record(self) -> Record:
        """Everything that the board keeps after this sample, shape (L,), see :func:`record_type`."""
        record = np.zeros(self.lanes, dtype=record_type(self._program))
        assert self._row is not None
        for component, state in zip(self._program.components, self._states, strict=True):
            for i, word in enumerate(state):
                record[f"{component.name}.x{i + 1}.lo"] = word & 0xFFFF
                record[f"{component.name}.x{i + 1}.hi"] = word >> RESIDUE_BITS
            for i in range(component.order):
                record[f"{component.name}.R{i}"] = component.rates[self._row, i]
            record[f"{component.name}.S"] = component.steady[self._row]
        record["pwm"] = self._row + self._first
        record["flags"] = self._flags
        if self._program.saturates:
            record["saturations"] = self.saturations
        return record


def pwm_flags(program: Program) -> Integers:
    """The flags that each |PWM| of the domain brings with it, shape (rows,)."""
    rows = domain_rows(program.model)
    low, high = program.model.validity
    flags = np.where((rows < low) | (rows > high), OUTSIDE_VALIDITY, 0)
    for component in program.model.components:
        zeroed = (component.raw_gain(rows) < 0.0) & (component.effective_gain(rows) == 0.0) & (rows > 0)
        flags = flags | np.where(zeroed, GAIN_ZEROED, 0)
    return flags.astype(np.int64)


def record_type(program: Program) -> np.dtype[np.void]:
    """The board's model structure, byte by byte: states, coefficients, PWM and flags, packed and little endian."""
    states: list[tuple[str, str]] = []
    coefficients: list[tuple[str, str]] = []
    for shape in program.shapes:
        for member in shape.members:
            component = program.components[member]
            for i in range(component.order):
                states += [(f"{component.name}.x{i + 1}.lo", "<u2"), (f"{component.name}.x{i + 1}.hi", "<i4")]
            coefficients += [(f"{component.name}.R{i}", "<u4") for i in range(component.order)]
            coefficients.append((f"{component.name}.S", "<i4"))
    tail = [("command", "<i2"), ("pwm", "u1"), ("started", "u1"), ("flags", "u1")]
    if program.saturates:
        tail.append(("saturations", "<u2"))
    return np.dtype(states + coefficients + tail)


#: Fields of the record that are the interface's own business and not compared.
NOT_COMPARED = ("command", "started")
