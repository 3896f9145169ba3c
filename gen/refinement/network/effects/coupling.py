"""A path between two parts that the model lacks, or that conducts more than it says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered


class Coupling(NetworkEffect):
    """A further conductance between two nodes."""

    name = "coupling"
    goes_with_speed = True

    def __init__(self, motor: Motor, first: int, second: int) -> None:
        self.component = motor.names[first]
        self.other = motor.names[second]
        self.acts_by = {"other": self.other}
        self._pair = (first, second)
        self._columns = motor.columns
        typical = motor.typical_W_per_K
        self.numbers = (Number("conductance_W_per_K", 0.2 * typical, float(np.log(typical)), 2.0, 1e-6, 1e6, log=True),)

    @property
    def paths(self) -> tuple[tuple[int, int], ...]:  # noqa: D102
        return (self._pair,)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        value = self._columns.later(levels) * float(np.exp(values[0]))
        draft.conductance.add(place.path, value, place.slopes(value))

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        entry.path(self.component, self.other, values[0])


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Between every two nodes."""
    count = len(motor.names)
    for first in range(count):
        for second in range(first + 1, count):
            yield Coupling(motor, first, second)
