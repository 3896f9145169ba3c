"""Heat that is another when the motor turns backwards."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gen.arrays import FloatArray
from gen.coefficients.network import FactorEntry, FactorPoints
from gen.coefficients.network_curves import six_digits
from gen.identification.network.fitting.inputs import Levels
from gen.model.network_parts import PWM
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered


class Direction(NetworkEffect):
    """A node's heat, times a factor while the motor turns backwards."""

    name = "direction"

    def __init__(self, motor: Motor, node: int) -> None:
        self.component = motor.names[node]
        self._node, self._columns = node, motor.columns
        self.numbers = (Number("more_backwards", 0.0, 0.0, 0.5, -0.95, 10.0),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        unit = self._columns.later(levels) * self._columns.backwards(levels)
        draft.scale_heats(self._node, (1.0 + values[0] * unit).clip(0.02), place.slopes(unit))

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        points = FactorPoints(at=(-1.0, 0.0), value=(six_digits(1.0 + values[0]), 1.0))
        entry.factor_on_heats(self.component, FactorEntry(channel=PWM, table=points))


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """At every node with heat, where it turned backwards."""
    if data.backwards:
        for node in motor.heated:
            yield Direction(motor, node)
