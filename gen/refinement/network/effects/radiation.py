"""Heat that a surface gives off by the fourth power of its temperature."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.excess import REFERENCE
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered


class Radiation(NetworkEffect):
    """A path to the ambient that radiates."""

    name = "radiation"
    goes_with_speed = True

    def __init__(self, motor: Motor, node: int) -> None:
        self.component = motor.names[node]
        self._node, self._excess, self._columns = node, motor.radiates[node], motor.columns
        typical = motor.typical_W_per_K
        self.numbers = (
            Number("conductance_W_per_K", 0.1 * typical, float(np.log(0.3 * typical)), 2.0, 1e-6, 1e6, log=True),
        )

    @property
    def paths(self) -> tuple[tuple[int, int], ...]:  # noqa: D102
        return ((self._node, -1),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        value = self._columns.later(levels) * float(np.exp(np.clip(values[0], -60.0, 60.0)))
        draft.conductance.add(place.path, value, place.slopes(value))
        draft.law(place.path, (self._node, -1), self._columns.excess(levels, self._excess))

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        entry.radiates(self.component, values[0], REFERENCE)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """At every node."""
    for node in range(len(motor.names)):
        yield Radiation(motor, node)
