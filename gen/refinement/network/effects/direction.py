"""Heat that is another when the motor turns backwards."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gen.coefficients.network import FactorEntry, FactorPoints
from gen.coefficients.network_curves import six_digits
from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.model.network_parts import PWM
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter


class Direction(NetworkEffect):
    """A node's heat, or each node's by a number of its own, times a factor while the motor turns backwards."""

    name = "direction"

    def __init__(self, motor: Motor, nodes: Sequence[int]) -> None:
        alone = len(nodes) == 1
        self.component = motor.names[nodes[0]] if alone else WHOLE
        self._motor, self._acts, self._columns = motor, tuple(nodes), motor.columns
        names = ["more_backwards"] if alone else [f"more_backwards_of_{motor.names[node]}" for node in nodes]
        self.numbers = tuple(Number(name, 0.0, 0.0, 0.5, -0.95, 10.0) for name in names)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        unit = self._columns.later(levels) * self._columns.backwards(levels)
        for node, column, value in zip(self._acts, place.columns.tolist(), values, strict=True):
            draft.scale_heats(node, (1.0 + value * unit).clip(0.02), [(column, unit)])

    def spread(self) -> NetworkEffect | None:  # noqa: D102
        several = len(self._acts) < len(self._motor.heated)
        return Direction(self._motor, self._motor.heated) if several else None

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for node, value in zip(self._acts, values, strict=True):
            points = FactorPoints(at=(-1.0, 0.0), value=(six_digits(1.0 + value), 1.0))
            entry.factor_on_heats(self._motor.names[node], FactorEntry(channel=PWM, table=points))


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """At every node with heat, where it turned backwards."""
    if data.backwards:
        for node in motor.heated:
            yield Direction(motor, [node])
