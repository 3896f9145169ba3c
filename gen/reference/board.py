"""The reference of whatever a program holds, behind one interface."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray, RecordArray
from gen.lowering.program import Program
from gen.reference import lanes, network
from gen.reference.model import AMBIENT_FIELD, ReferenceModel
from gen.reference.model import record_type as components_record_type
from gen.reference.network import ReferenceNetwork


class Reference(Protocol):
    """What the board keeps and gives out, for L independent lanes at once."""

    lanes: int
    starts_mK: dict[str, IntArray]

    @property
    def within_ranges(self) -> BoolArray:
        """Lanes in which nothing was held to its range so far, shape (L,)."""

    @property
    def saturations(self) -> IntArray:
        """How often each lane had to limit something, as the board's 16-bit counter has it."""

    @property
    def rises(self) -> FloatArray:
        """Rise of every component as the board gives it out, shape (components, L), in K."""

    @property
    def readings(self) -> FloatArray:
        """Reading of every component, shape (components, L), in degC: its rise over the ambient that was told last."""

    @property
    def rises_mK(self) -> IntArray:
        """The same in thousandths of a kelvin, to nearest, as integers."""

    def set_channels(self, values: IntArray) -> None:
        """Tell the channels' values from now on, in thousandths, shape (channels, L)."""

    def step(self, pwm: IntArray) -> None:
        """Advance by one sample with the PWM of each lane, shape (L,)."""

    def state_record(self) -> RecordArray:
        """The state words alone, shape (L,); the record's other fields are 0."""

    def record(self) -> RecordArray:
        """Everything that the board keeps after a sample, shape (L,), see :func:`record_type`."""


def reference_of(
    program: Program, start_mK: Sequence[int] | Mapping[str, Sequence[int]], channels: IntArray | None = None
) -> Reference:
    """Start a program's reference.

    Parameters
    ----------
    program
        What the board holds.
    start_mK
        Rise at the start in thousandths of a kelvin, one for each lane: of all components, or by component.
    channels
        What is told at the start, in thousandths, shape (channels, L); None: the neutral values.
    """
    if program.network is None:
        return ReferenceModel(program, start_mK, channels)
    names = program.model.component_names
    starts = dict(start_mK) if isinstance(start_mK, Mapping) else dict.fromkeys(names, start_mK)
    return ReferenceNetwork(program.network, program.model.domain_pwm, program.model.validity, starts, channels)


def record_type(program: Program) -> np.dtype[np.void]:
    """The board's model structure, byte by byte, packed and little endian."""
    return components_record_type(program) if program.network is None else network.record_type(program.network)


def state_names(program: Program) -> list[str]:
    """Names of the state's words, in the order of the board's structure."""
    if program.network is not None:
        return [name for name, _ in network.state_fields(program.network)]
    members = [program.components[member] for shape in program.shapes for member in shape.members]
    own = [AMBIENT_FIELD[0]] if program.ambient is not None else []
    return [name for component in members for name, _ in lanes.state_fields(component)] + own
