"""Heat that follows a supply which moves."""

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
from gen.refinement.network.writer import NetworkWriter, ends


class SupplyVoltage(NetworkEffect):
    """Each heat times 1 + a u + b u^2, all cooling times 1 + c u; u the voltage over its usual one, less 1.

    Speed goes with the voltage, and heat with a power of it between one and three: a is that power, b half of it times
    one less. Runs hold few voltages for long, and say little of b by themselves. What goes with a higher power of speed
    than the heats of the motor do in the mean goes with that much higher a power of the voltage. The usual voltage is
    the one that the motor was identified at: near the median of later runs, and not that.
    """

    name = "supply_voltage"
    component = WHOLE

    def __init__(self, motor: Motor, channel: str, usual: float, apart: float) -> None:
        self.acts_by = {"channel": channel}
        self.channel = channel
        self._columns = motor.columns
        self._outer = motor.outer
        mean = float(np.mean(motor.heat_powers)) if motor.heat_powers else 0.0
        self._heated = [(node, power - mean) for node, power in zip(motor.heated, motor.heat_powers, strict=True)]
        self._names = motor.names
        self._between = [ends(motor.paths[q], motor.names) for q in motor.outer]
        self.numbers = (
            Number("heat_per_share_of_voltage", 0.0, 2.0, 1.0, -8.0, 8.0),
            Number("heat_per_square", 0.0, 1.0, 0.7, -20.0, 20.0),
            Number("cooling_per_share_of_voltage", 0.0, 0.4, 0.4, -3.0, 3.0),
            Number("usual_V", usual, usual, apart, 0.3 * usual, 3.0 * usual),
        )

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        a, b, c, usual = values
        first = self._columns.power(levels, self.channel, 1) / usual
        second = self._columns.power(levels, self.channel, 2) / usual**2
        unit, square = later * (first - 1.0), later * (second - 2.0 * first + 1.0)
        unit_by_usual, square_by_usual = -later * first / usual, 2.0 * later * (first - second) / usual
        columns = place.columns.tolist()
        for node, more in self._heated:
            own, bent = _of(a, b, more)
            heat = (1.0 + own * unit + bent * square).clip(0.02)
            by_usual = own * unit_by_usual + bent * square_by_usual
            slopes = [(columns[0], unit + more * square), (columns[1], square), (columns[3], by_usual)]
            draft.scale_heats(node, heat, slopes)
        # What the file can hold: a factor by a channel acts at rest, too, where there is next to nothing to cool.
        cooling = (1.0 + c * unit).clip(0.02)
        for q in self._outer:
            draft.conductance.scale(q, cooling, [(columns[2], unit), (columns[3], c * unit_by_usual)])

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        return ["more voltage would heat less"] if values[0] <= 0.0 else []

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        a, b, c, v = values
        cooling = FactorEntry(channel=self.channel, poly=(six_digits(c / v), six_digits(1.0 - c)))
        for node, more in self._heated:
            own, bent = _of(a, b, more)
            poly = (bent / v**2, (own - 2.0 * bent) / v, 1.0 - own + bent)
            heat = FactorEntry(channel=self.channel, poly=tuple(six_digits(x) for x in poly))
            entry.factor_on_heats(self._names[node], heat)
        for between in self._between:
            entry.factor_on_path(between, cooling)


def _of(power: float, bend: float, more: float) -> tuple[float, float]:
    """The numbers of a heat that goes with a power of the voltage that is so much higher: x -> x (x - 1) / 2 bends."""
    return power + more, bend + more * power + 0.5 * more * (more - 1.0)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Each voltage that moves."""
    for channel in data.voltages:
        usual, (low, high) = data.typical[channel], data.ranges[channel]
        if usual > 0.0:
            yield SupplyVoltage(motor, channel, usual, 0.25 * (high - low))
