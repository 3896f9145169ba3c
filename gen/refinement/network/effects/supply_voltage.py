"""Heat that follows a supply which moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gen.coefficients.network import FactorEntry
from gen.coefficients.network_curves import six_digits
from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter, ends


class SupplyVoltage(NetworkEffect):
    """All heat times 1 + a u + b u^2, all cooling times 1 + c u; u the voltage over its usual one, less 1.

    Speed goes with the voltage, and heat with a power of it between one and three: a is that power, b half of it times
    one less. Runs hold few voltages for long, and say little of b by themselves.
    """

    name = "supply_voltage"
    component = WHOLE

    def __init__(self, motor: Motor, channel: str, usual: float) -> None:
        self.acts_by = {"channel": channel}
        self.channel, self._usual = channel, usual
        self._columns = motor.columns
        self._heated, self._outer = motor.heated, motor.outer
        self._names = motor.names
        self._between = [ends(motor.paths[q], motor.names) for q in motor.outer]
        self.numbers = (
            Number("heat_per_share_of_voltage", 0.0, 2.0, 1.0, -8.0, 8.0),
            Number("heat_per_square", 0.0, 1.0, 0.7, -20.0, 20.0),
            Number("cooling_per_share_of_voltage", 0.0, 0.4, 0.4, -3.0, 3.0),
        )

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        first = self._columns.power(levels, self.channel, 1) / self._usual
        second = self._columns.power(levels, self.channel, 2) / self._usual**2
        unit, square = later * (first - 1.0), later * (second - 2.0 * first + 1.0)
        a, b, c = values
        heat = (1.0 + a * unit + b * square).clip(0.02)
        columns = place.columns.tolist()
        for node in self._heated:
            draft.scale_heats(node, heat, [(columns[0], unit), (columns[1], square)])
        # What the file can hold: a factor by a channel acts at rest, too, where there is next to nothing to cool.
        cooling = (1.0 + c * unit).clip(0.02)
        for q in self._outer:
            draft.conductance.scale(q, cooling, [(columns[2], unit)])

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        return ["more voltage would heat less"] if values[0] <= 0.0 else []

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        a, b, c = values
        v = self._usual
        heat = FactorEntry(
            channel=self.channel, poly=(six_digits(b / v**2), six_digits((a - 2.0 * b) / v), six_digits(1.0 - a + b))
        )
        cooling = FactorEntry(channel=self.channel, poly=(six_digits(c / v), six_digits(1.0 - c)))
        for node in self._heated:
            entry.factor_on_heats(self._names[node], heat)
        for between in self._between:
            entry.factor_on_path(between, cooling)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Each voltage that moves."""
    for channel in data.voltages:
        if data.typical[channel] > 0.0:
            yield SupplyVoltage(motor, channel, data.typical[channel])
