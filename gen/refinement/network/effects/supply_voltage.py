"""Heat that follows a supply which moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gen.coefficients.network import FactorEntry
from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter, short


class SupplyVoltage(NetworkEffect):
    """All heat times 1 + b + a u, u the voltage over its usual one, less 1."""

    name = "supply_voltage"
    component = WHOLE

    def __init__(self, motor: Motor, channel: str, usual: float) -> None:
        self.acts_by = {"channel": channel}
        self.channel, self._usual = channel, usual
        self._columns = motor.columns
        self._heated = motor.heated
        self._names = motor.names
        self.numbers = (
            Number("heat_per_share_of_voltage", 0.5, 0.0, 2.0, -8.0, 8.0),
            Number("heat_at_usual_voltage", 0.0, 0.0, 0.1, -0.5, 0.5),
        )

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        unit = later * (self._columns.power(levels, self.channel, 1) / self._usual - 1.0)
        factor = (1.0 + values[0] * unit + values[1] * later).clip(0.02)
        for node in self._heated:
            draft.scale_heats(node, factor, place.slopes(unit, later))

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        poly = (short(values[0] / self._usual), short(1.0 + values[1] - values[0]))
        for node in self._heated:
            entry.factor_on_heats(self._names[node], FactorEntry(channel=self.channel, poly=poly))


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Each voltage that moves."""
    for channel in data.voltages:
        if data.typical[channel] > 0.0:
            yield SupplyVoltage(motor, channel, data.typical[channel])
