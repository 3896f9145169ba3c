"""A measured flow of air that cools paths to the ambient."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.coefficients.network import FactorEntry, FactorPoints
from gen.coefficients.network_curves import six_digits
from gen.identification.network.fitting.bins import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.columns import Columns
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter, ends
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

POINTS = 9
"""Of the table that a file holds for a root."""


class Airflow(NetworkEffect):
    """G (1 + a v^m), v a channel over its largest value; on one path to the ambient, or on all.

    m is 1, or 1/2 (laminar flow along a plate and across a cylinder, Incropera et al., Fundamentals of Heat and Mass
    Transfer, 7.2 and 7.4).
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
        held: bool = False,
    ) -> None:
        self.component = component
        self.acts_by = {"channel": channel}
        self.channel, self._power, self._acts = channel, power, tuple(paths)
        self._usual, self._largest = ends_at
        self._held = held
        self._as_made = (motor, channel, ends_at, power, paths, component)
        self._between = [ends(motor.paths[q], motor.names) for q in paths]
        self._columns: Columns = motor.columns
        self.numbers = (Number("gain_at_most_flow", 0.0, 0.0, 2.0, 0.0, 30.0),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        if self._held:
            flow = np.full(levels.count, (self._usual / self._largest) ** self._power)
        else:
            flow = self._columns.power(levels, self.channel, self._power) / self._largest**self._power
        unit = self._columns.later(levels) * flow
        factor = (1.0 + values[0] * unit).clip(0.02)
        for q in self._acts:
            draft.conductance.scale(q, factor, place.slopes(unit))

    def unmoved(self) -> NetworkEffect | None:  # noqa: D102
        return Airflow(*self._as_made, held=True)

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        if self._power == 1.0:
            poly = (six_digits(values[0] / self._largest), 1.0)
            factor = FactorEntry(channel=self.channel, poly=poly)
        else:
            # Closer together where the root is steep.
            share = np.linspace(0.0, 1.0, POINTS) ** 2
            points = FactorPoints(
                at=tuple(six_digits(float(x)) for x in share * self._largest),
                value=tuple(six_digits(1.0 + values[0] * float(x) ** self._power) for x in share),
            )
            factor = FactorEntry(channel=self.channel, table=points)
        for between in self._between:
            entry.factor_on_path(between, factor)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Every channel that moves and is never below 0 may be a flow: on all paths to the ambient, or on one."""
    for channel in data.flows:
        low, largest = data.ranges[channel]
        if low < 0.0:
            continue
        ends_at = (data.typical[channel], largest)
        for power in (1.0, 0.5):
            yield Airflow(motor, channel, ends_at, power, motor.outer, WHOLE)
            if len(motor.outer) > 1:
                for q in motor.outer:
                    yield Airflow(motor, channel, ends_at, power, [q], motor.names[motor.paths[q][0]])
