"""Heat that grows with the temperature of where it arises."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gen.identification.network.fitting.bins import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter

REFERENCE = 25.0
"""degC: what resistances are told at."""


class TemperatureDependentLoss(NetworkEffect):
    """All heat of a node, or of all nodes, times 1 + k (T - T_reference)."""

    name = "temperature_dependent_loss"
    goes_with_speed = True

    def __init__(self, motor: Motor, nodes: Sequence[int], component: str, reference: Sequence[float]) -> None:
        self.component = component
        self._acts = tuple(nodes)
        self._reference = tuple(reference)
        self._names = motor.names
        self._columns = motor.columns
        self.numbers = (Number("per_K", 0.0, 0.0, 0.01, -0.02, 0.05),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        for node, reference in zip(self._acts, self._reference, strict=True):
            draft.grow(node, values[0] * later, reference, place.slopes(later))

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for node, reference in zip(self._acts, self._reference, strict=True):
            entry.grows(self._names[node], values[0], reference)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """At every node with heat, or at all of them; about 25 degC, or about how warm the model's nodes usually are.

    What was identified without such a loss is right at usual temperatures, if the motor always had it.
    """
    for references in ([REFERENCE] * len(motor.names), motor.usual_degC):
        yield TemperatureDependentLoss(motor, motor.heated, WHOLE, [references[node] for node in motor.heated])
        if len(motor.heated) > 1:
            for node in motor.heated:
                yield TemperatureDependentLoss(motor, [node], motor.names[node], [references[node]])
