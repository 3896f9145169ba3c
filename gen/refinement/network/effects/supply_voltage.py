"""Heat that follows a supply which moves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients.network import FactorEntry
from gen.coefficients.network_curves import six_digits
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter, Scale
from gen.refinement.network.effects.base import SPEEDS, WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

POWERS = np.array([0.0, 1.0, 3.0])
"""Of the voltage, in the heats that are written: any power between two of them is a mixture of these."""
SECOND = 0.5 * POWERS * (POWERS - 1.0)
"""What bends them: v^q = 1 + q (v - 1) + q (q - 1) / 2 (v - 1)^2."""
BENDS = float((SECOND[2] - SECOND[1]) / (POWERS[2] - POWERS[1]))
"""How that grows with the power above 1; below it nothing bends."""


class SupplyVoltage(NetworkEffect):
    """Each heat times v^p, each conductance to the ambient times 1 + p (v - 1); v the voltage over its usual one.

    A motor's mean voltage is the supply's times the duty, so what a higher supply does is what more PWM does: p is the
    power of speed that a heat or a conductance goes with in the file, at each speed, times a number near 1 that is
    fitted. The usual voltage is the one that the motor was identified at: near the median of later runs, and not that.
    """

    name = "supply_voltage"
    component = WHOLE

    def __init__(self, motor: Motor, channel: str, usual: float, apart: float) -> None:
        self.acts_by = {"channel": channel}
        self.channel = channel
        self._columns = motor.columns
        self._heated = list(zip(motor.heated, motor.heat_powers, strict=True))
        self._cooled = list(zip(motor.outer, motor.outer_powers, strict=True))
        self._names = motor.names
        self._places = [motor.path_at(q) for q in motor.outer]
        self.numbers = (
            Number("heat_over_that_by_pwm", 1.0, 1.0, 0.4, -3.0, 5.0),
            Number("cooling_over_that_by_pwm", 1.0, 1.0, 0.7, -3.0, 8.0),
            Number("usual_V", usual, usual, apart, 0.3 * usual, 3.0 * usual),
        )

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        heating, cooling, usual = values
        first = self._columns.power(levels, self.channel, 1) / usual
        second = self._columns.power(levels, self.channel, 2) / usual**2
        unit, square = later * (first - 1.0), later * (second - 2.0 * first + 1.0)
        unit_by_usual, square_by_usual = -later * first / usual, 2.0 * later * (first - second) / usual
        columns = place.columns.tolist()
        for node, powers in self._heated:
            own = np.interp(levels.speed, SPEEDS, powers)
            power = np.clip(heating * own, POWERS[0], POWERS[-1])
            bent = np.interp(power, POWERS, SECOND)
            within = (power > POWERS[0]) & (power < POWERS[-1])
            heat = (1.0 + power * unit + bent * square).clip(0.02)
            by_heating = own * within * (unit + np.where(power > POWERS[1], BENDS, 0.0) * square)
            by_usual = power * unit_by_usual + bent * square_by_usual
            draft.scale_heats(node, heat, [(columns[0], by_heating), (columns[2], by_usual)])
        # What the file can hold: a factor by a channel acts at rest, too, where there is next to nothing to cool.
        for q, power in self._cooled:
            factor = (1.0 + cooling * power * unit).clip(0.02)
            slopes = [(columns[1], power * unit), (columns[2], cooling * power * unit_by_usual)]
            draft.conductance.scale(q, factor, slopes)

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        return ["more voltage would heat less"] if values[0] <= 0.0 else []

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        heating, cooling, v = values
        factors: list[FactorEntry | None] = [None]
        for q, bend in zip(POWERS.tolist()[1:], SECOND.tolist()[1:], strict=True):
            poly = (bend / v**2, (q - 2.0 * bend) / v, 1.0 - q + bend)
            factors.append(FactorEntry(channel=self.channel, poly=tuple(six_digits(x) for x in poly)))
        for node, powers in self._heated:
            shares = [_share(k, heating, powers) for k in range(POWERS.size)]
            entry.split_heat(self._names[node], list(zip(shares, factors, strict=True)))
        for at, (_, power) in zip(self._places, self._cooled, strict=True):
            c = cooling * power
            entry.factor_on_path(at, FactorEntry(channel=self.channel, poly=(six_digits(c / v), six_digits(1.0 - c))))


def _share(k: int, heating: float, powers: FloatArray) -> Scale:
    """What of a heat goes with the k-th power of the voltage, by speed."""
    unit = np.eye(POWERS.size)[k]
    return lambda w: np.interp(np.clip(heating * np.interp(w, SPEEDS, powers), POWERS[0], POWERS[-1]), POWERS, unit)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Each voltage that moves."""
    for channel in data.voltages:
        usual, (low, high) = data.typical[channel], data.ranges[channel]
        if usual > 0.0:
            yield SupplyVoltage(motor, channel, usual, 0.25 * (high - low))
