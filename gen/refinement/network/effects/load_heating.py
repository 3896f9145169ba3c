"""Heat by a measured current."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients.network import FactorEntry
from gen.coefficients.network_curves import six_digits
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import GROWN, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered


class LoadHeating(NetworkEffect):
    """R I^2 at a node, beside a share of the heat that the model has there."""

    name = "load_heating"

    def __init__(self, motor: Motor, channel: str, square: float, node: int) -> None:
        self.component = motor.names[node]
        self.acts_by = {"channel": channel}
        self.channel, self._node = channel, node
        self._columns = motor.columns
        self._replaces = node in motor.heated
        typical = motor.typical_W / square
        self.numbers = (
            Number("resistance_ohm", 0.0, 0.0, 3.0 * typical, 0.0, np.inf),
            Number("share_of_the_old_heat", 1.0, 0.0, 0.5, 0.01, 3.0, log=True),
        )[: 2 if self._replaces else 1]

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        if self._replaces:
            more = np.expm1(values[1])
            draft.scale_heats(self._node, 1.0 + later * more, [(int(place.columns[1]), later * (1.0 + more))])
        unit = later * self._columns.power(levels, self.channel, 2)
        draft.heat.add(self._node, values[0] * unit, place.slopes(unit))

    def change(self, values: Sequence[float]) -> str:  # noqa: D102
        # A measured current takes over some of the old heat, and adds none to it.
        if not self._replaces or values[1] < GROWN:
            return ""
        return (
            f"{self.component}: its own heat has grown by {values[1] - 1.0:.0%} at every speed, beside what the "
            "current adds, as that of a fault or of weaker magnets does"
        )

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        if self._replaces:
            entry.scale_heat(self.component, lambda w: np.full_like(w, values[1]))
        entry.heat_by_channel(
            self.component, six_digits(max(values[0], 0.0)), FactorEntry(channel=self.channel, poly=(1.0, 0.0, 0.0))
        )


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Each current at each node."""
    for channel in data.currents:
        largest = max(abs(end) for end in data.ranges[channel])
        for node in range(len(motor.names)):
            yield LoadHeating(motor, channel, largest**2, node)
