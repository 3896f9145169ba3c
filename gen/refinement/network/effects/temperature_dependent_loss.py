"""Heat that grows with the temperature of where it arises."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

REFERENCE = 25.0
"""degC: what resistances are told at."""
LEAST, MOST = -0.1, 0.05
"""1/K. Grease thins by 3 to 7 % for each kelvin about room temperature; metals' resistance grows by 0.4 %."""
METALS, UNSEEN = 0.012, 2.0
"""1/K. Metals come to less: copper has 0.4 %, and where ferrite magnets weaken by 0.2 % the same torque takes as much
more current, and heats by the square of it. From 25 to 100 degC that is 1.05 % of the heat at 25 for each kelvin.
At a part without a sensor there may be more heat than the file gives it, of which what it grows by is a larger share:
by this factor at most."""


class TemperatureDependentLoss(NetworkEffect):
    """All heat of a node, or of all nodes, times 1 + k (T - T_reference)."""

    name = "temperature_dependent_loss"
    goes_with_speed = True

    def __init__(
        self, motor: Motor, nodes: Sequence[int], component: str, reference: Sequence[float], hottest: Sequence[float]
    ) -> None:
        self.component = component
        self._acts = tuple(nodes)
        self._reference = tuple(reference)
        self._hottest = tuple(hottest)
        self._names = motor.names
        self._may_be_more = UNSEEN if min(nodes) >= motor.sensed else 1.0
        self._columns = motor.columns
        self.numbers = (Number("per_K", 0.0, 0.0, 0.01, LEAST, MOST),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        for node, reference in zip(self._acts, self._reference, strict=True):
            draft.grow(node, values[0] * later, reference, place.slopes(later))

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        warmest = zip(self._hottest, self._reference, strict=True)
        shares = [(1.0 + values[0] * (degC - reference), degC) for degC, reference in warmest]
        least, degC = min(shares)
        return [f"heat would be less than none at {degC:.0f} degC, which was reached"] if least < 0.0 else []

    def change(self, values: Sequence[float]) -> str:  # noqa: D102
        if values[0] < METALS * self._may_be_more:
            return ""
        return (
            f"{self.component}: its heat grows by {values[0]:.1%} for each kelvin, where copper and magnets come to "
            f"less than {METALS:.1%} together: so looks what cools less than it did (blocked vents, a cover)"
        )

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for node, reference in zip(self._acts, self._reference, strict=True):
            entry.grows(self._names[node], values[0], reference)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """At every node with heat, or at all of them; about 25 degC, or about how warm the model's nodes usually are.

    What was identified without such a loss is right at usual temperatures, if the motor always had it.
    """
    hottest = [data.hottest(name) for name in motor.names]
    for references in ([REFERENCE] * len(motor.names), motor.usual_degC):
        for nodes, component in _where(motor):
            where = [references[node] for node in nodes], [hottest[node] for node in nodes]
            yield TemperatureDependentLoss(motor, nodes, component, *where)


def _where(motor: Motor) -> Iterator[tuple[Sequence[int], str]]:
    yield motor.heated, WHOLE
    if len(motor.heated) > 1:
        for node in motor.heated:
            yield [node], motor.names[node]
