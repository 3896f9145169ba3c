"""A measured flow of air that cools paths to the ambient."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients.network import FactorEntry, FactorPoints
from gen.coefficients.network_curves import six_digits
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.columns import Columns
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

POINTS = 9
"""Of the table that a file holds for a root."""
MOST = 30.0
"""Of what a flow adds, over what conducts without it."""
BEYOND = 2.0
"""How far a straight line goes, over the largest value: further than a file lets the channel be."""


class Airflow(NetworkEffect):
    """G (1 + a v^m), v a channel over its largest value, on one path to the ambient, or on all; or G + b v^m on one.

    The first is a flow that the motor's own moves along with, the second one that cools a surface of its own, whatever
    the motor does. m is 1, or 1/2 (laminar flow along a plate and across a cylinder, Incropera et al., Fundamentals of
    Heat and Mass Transfer, 7.2 and 7.4).

    Parameters
    ----------
    motor
        What it is put on.
    channel, ends_at
        The flow, its usual value and its largest.
    power
        m.
    paths, component
        Which paths, and where they begin.
    beside
        The second of both.
    held
        With the channel held at its usual value.
    """

    name = "airflow"

    def __init__(
        self,
        motor: Motor,
        channel: str,
        ends_at: tuple[float, float],
        power: float,
        paths: Sequence[int],
        component: str,
        *,
        beside: bool = False,
        held: bool = False,
    ) -> None:
        self.component = component
        self.acts_by = {"channel": channel}
        self.channel, self._power, self._acts = channel, power, tuple(paths)
        self._usual, self._largest = ends_at
        self._held, self._beside = held, beside
        self._as_made = (motor, channel, ends_at, power, paths, component)
        self._places = [motor.path_at(q) for q in paths]
        self._columns: Columns = motor.columns
        if beside:
            usual = motor.typical_W_per_K
            self.numbers = (Number("conductance_at_most_flow_W_per_K", 0.0, 0.0, 2.0 * usual, 0.0, MOST * usual),)
        else:
            self.numbers = (Number("gain_at_most_flow", 0.0, 0.0, 2.0, 0.0, MOST),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        if self._held:
            flow = np.full(levels.count, (self._usual / self._largest) ** self._power)
        else:
            flow = self._columns.power(levels, self.channel, self._power) / self._largest**self._power
        unit = self._columns.later(levels) * flow
        if self._beside:
            for q in self._acts:
                draft.conductance.add(q, values[0] * unit, place.slopes(unit))
            return
        factor = (1.0 + values[0] * unit).clip(0.02)
        for q in self._acts:
            draft.conductance.scale(q, factor, place.slopes(unit))

    def unmoved(self) -> NetworkEffect | None:  # noqa: D102
        return Airflow(*self._as_made, beside=self._beside, held=True)

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        if self._beside:
            for at in self._places:
                entry.path_by_channel(at, values[0], self._factor(0.0, 1.0))
        else:
            factor = self._factor(1.0, values[0])
            for at in self._places:
                entry.factor_on_path(at, factor)

    def _factor(self, without: float, more: float) -> FactorEntry:
        """Without any flow, and what the largest adds."""
        if self._power != 1.0:
            # Closer together where the root is steep.
            share = np.linspace(0.0, 1.0, POINTS) ** 2
        elif without > 0.0:
            return FactorEntry(channel=self.channel, poly=(six_digits(more / self._largest), without))
        else:
            # A table ends at none; a line would go on to less where a channel is a little below 0.
            share = np.array([0.0, BEYOND])
        points = FactorPoints(
            at=tuple(six_digits(float(x)) for x in share * self._largest),
            value=tuple(six_digits(without + more * float(x) ** self._power) for x in share),
        )
        return FactorEntry(channel=self.channel, table=points)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Every channel that moves and is never below 0 may be a flow: on all paths to the ambient, or on one."""
    for channel in data.flows:
        low, largest = data.ranges[channel]
        if low < 0.0:
            continue
        ends_at = (data.typical[channel], largest)
        for power in (1.0, 0.5):
            yield Airflow(motor, channel, ends_at, power, motor.outer, WHOLE)
            for q in motor.outer:
                node = motor.names[motor.paths[q][0]]
                if len(motor.outer) > 1:
                    yield Airflow(motor, channel, ends_at, power, [q], node)
                if not motor.has_beside(q, channel):
                    yield Airflow(motor, channel, ends_at, power, [q], node, beside=True)
