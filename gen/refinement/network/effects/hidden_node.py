"""A mass that the model lacks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import OWN, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

FASTEST_S, SLOWEST_S = 30.0, 40_000.0
FIRMLY_S, HEAVY = 5.0, 0.2
"""A part that is heavier than this many median capacities of the motor's nodes shows by its mass, however firmly it is
bolted on: only how firmly is not to be seen. A lighter one so quick is heat at its node."""
LEAST_EXPONENT, MOST_EXPONENT = -0.5, 4.0
MOST_PARTS, MOST_HEATS = 100.0, 2.0
"""How many median capacities of the motor's nodes it may have, and how many times the motor's whole heat at full speed:
what is more stands for something else (a fan of one run, a supply, another motor)."""
A_HEATSINK = "a mass with a surface of its own that makes next to no heat: a heatsink, a mount, a cover"
HARDLY_K = 1.0
"""What its own heat alone would warm such a mass by."""
SLOWEST = 1e-3
"""Share of full speed, of what has no logarithm."""


class HiddenNode(NetworkEffect):
    """A node of its own: a capacity, a path to a node, one to the ambient, and heat that goes with a power of w."""

    name = "hidden_node"
    goes_with_speed = True
    nodes = 1

    def __init__(self, motor: Motor, node: int, *, outside: bool) -> None:
        self.component = motor.names[node]
        self._node, self._columns = node, motor.columns
        self._motor = motor
        g, c, p = motor.typical_W_per_K, motor.typical_J_per_K, motor.typical_W

        def by_log(name: str, start: float, mean: float, deviation: float, most: float = 1e9) -> Number:
            return Number(name, start, float(np.log(mean)), deviation, 1e-9, most, log=True)

        self.numbers = (
            by_log("capacity_J_per_K", 0.3 * c if outside else c, c, 1.5, MOST_PARTS * c),
            by_log("conductance_W_per_K", g if outside else 0.3 * g, g, 1.5),
            by_log("to_ambient_W_per_K", 0.3 * g if outside else 0.02 * g, 0.1 * g, 2.0),
            by_log("power_at_full_speed_W", 0.005 * p if outside else 0.02 * p, 0.03 * p, 2.0, MOST_HEATS * p),
            # Friction goes with w or somewhat more, iron with up to w^2, a load's current hardly changes with speed.
            Number("exponent", 1.5, 1.5, 0.7, LEAST_EXPONENT, MOST_EXPONENT),
        )

    @property
    def paths(self) -> tuple[tuple[int, int], ...]:  # noqa: D102
        return ((OWN, self._node), (OWN, -1))

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        _, inner, outer, power = np.exp(np.clip(values[:4], -60.0, 60.0))
        columns = place.columns.tolist()
        draft.conductance.add(place.path, inner * later, [(columns[1], inner * later)])
        # In earlier runs the node stands apart: a way out keeps it at the ambient.
        draft.conductance.add(
            place.path + 1, np.full(levels.count, outer), [(columns[2], np.full(levels.count, outer))]
        )
        speed = np.maximum(levels.speed, SLOWEST)
        heat = later * (1.0 - levels.rest) * speed ** values[4] * power
        draft.heat.add(place.node, heat, [(columns[3], heat), (columns[4], heat * np.log(speed))])

    def follows_within_s(self, values: Sequence[float]) -> float:
        """Give its time constant beside its node and the ambient, s."""
        return values[0] / (values[1] + values[2])

    def mass(self, values: Sequence[float]) -> float:
        """Give its capacity, over what the motor's nodes usually have."""
        return values[0] / self._motor.typical_J_per_K

    def warming(self, values: Sequence[float]) -> float:
        """Give how fast its heat alone would warm it at full speed, over how fast the motor's would warm the motor."""
        return (values[3] / values[0]) / (self._motor.typical_W / self._motor.whole_J_per_K)

    def heat_W(self, speed: FloatArray, values: Sequence[float]) -> FloatArray:
        """Give what of its heat goes into its node at speeds, W, shape (L,); the rest goes to the ambient."""
        _, inner, outer, power, exponent = values
        return np.asarray(power * np.maximum(speed, SLOWEST) ** exponent * inner / (inner + outer))

    def cools_W(self, rise_K: float, values: Sequence[float]) -> float:
        """Give what its node loses through it to the ambient at a rise, W, beside the heat that it brings."""
        _, inner, outer, _, _ = values
        return inner * outer / (inner + outer) * rise_K

    def title_of(self, values: Sequence[float]) -> str:  # noqa: D102
        _, inner, outer, power, _ = values
        return A_HEATSINK if power < HARDLY_K * (inner + outer) else self.title

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        settles = self.follows_within_s(values)
        fastest = FIRMLY_S if self.mass(values) > HEAVY else FASTEST_S
        if fastest < settles < SLOWEST_S:
            return []
        return [f"it would settle within {settles:.0f} s: such runs do not show that"]

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        capacity, inner, outer, power, exponent = values
        name = entry.node(capacity)
        entry.path(self.component, name, inner)
        entry.path(name, "ambient", outer)
        entry.heat_over_speed(name, lambda w: power * w**exponent)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """At every node; the search begins with a mass within the motor, and with one that is a way out."""
    for node in range(len(motor.names)):
        yield HiddenNode(motor, node, outside=False)
        yield HiddenNode(motor, node, outside=True)
