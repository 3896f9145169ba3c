"""Heat by a measured current."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.coefficients.network import FactorEntry
from gen.coefficients.network_curves import six_digits
from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter, Scale

SHARE_OF_EACH = 0.2
"""Of all heat at full speed and the largest current, that a node has by it where several do."""


class LoadHeating(NetworkEffect):
    """R I^2 at a node, or at several by an R of each, beside a share of the heat that the model has there."""

    name = "load_heating"

    def __init__(self, motor: Motor, channel: str, square: float, nodes: Sequence[int]) -> None:
        alone = len(nodes) == 1
        self.component = motor.names[nodes[0]] if alone else WHOLE
        self.acts_by = {"channel": channel}
        self.channel, self._acts, self._square = channel, tuple(nodes), square
        self._motor, self._columns = motor, motor.columns
        self._replaces = tuple(node for node in nodes if node in motor.heated)
        typical = motor.typical_W / square

        def named(text: str, node: int) -> str:
            return text if alone else f"{text}_of_{motor.names[node]}"

        usual = SHARE_OF_EACH * typical
        resistances = [
            Number(named("resistance_ohm", node), 0.0, 0.0, 3.0 * typical, 0.0, np.inf)
            if alone
            else Number(named("resistance_ohm", node), usual, float(np.log(usual)), 1.5, 0.0, np.inf, log=True)
            for node in nodes
        ]
        shares = [
            Number(named("share_of_the_old_heat", node), 1.0, 0.0, 0.5, 0.01, 3.0, log=True) for node in self._replaces
        ]
        self.numbers = (*resistances, *shares)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later, columns = self._columns.later(levels), place.columns.tolist()
        count = len(self._acts)
        for node, column, value in zip(self._replaces, columns[count:], values[count:], strict=True):
            more = np.expm1(value)
            draft.scale_heats(node, 1.0 + later * more, [(column, later * (1.0 + more))])
        unit = later * self._columns.power(levels, self.channel, 2)
        for k, node in enumerate(self._acts):
            resistance = self.numbers[k].value(float(values[k]))
            slope = resistance * unit if self.numbers[k].log else unit
            draft.heat.add(node, resistance * unit, [(columns[k], slope)])

    def spread(self) -> NetworkEffect | None:  # noqa: D102
        every = tuple(dict.fromkeys((*self._motor.heated, *self._acts)))
        several = len(self._acts) < len(every)
        return LoadHeating(self._motor, self.channel, self._square, every) if several else None

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        names = self._motor.names
        for node, share in zip(self._replaces, values[len(self._acts) :], strict=True):
            entry.scale_heat(names[node], _at_all_speeds(share))
        factor = FactorEntry(channel=self.channel, poly=(1.0, 0.0, 0.0))
        for node, resistance in zip(self._acts, values, strict=False):
            entry.heat_by_channel(names[node], six_digits(max(resistance, 0.0)), factor)


def _at_all_speeds(share: float) -> Scale:
    return lambda w: np.full_like(w, share)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Each current at each node."""
    for channel in data.currents:
        largest = max(abs(end) for end in data.ranges[channel])
        for node in range(len(motor.names)):
            yield LoadHeating(motor, channel, largest**2, [node])
