"""A measured flow of air that cools paths to the ambient."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.coefficients.network import FactorEntry, FactorPoints
from gen.coefficients.network_curves import six_digits
from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.refinement.network.columns import Columns
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter, ends

POINTS = 9
"""Of the table that a file holds for a root."""
USUAL_GAIN, MOST_GAIN = 0.5, 30.0
"""What a flow adds at its most, as a share of what a path conducts without it."""


class Airflow(NetworkEffect):
    """G (1 + a v^m), v a channel over its largest value; on one path to the ambient, all alike, or each by its own a.

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
        alike: bool = True,
    ) -> None:
        self.component = component
        self.acts_by = {"channel": channel}
        self.channel, self._power, self._acts = channel, power, tuple(paths)
        self._usual, self._largest = ends_at
        self._held, self._motor = held, motor
        self._between = [ends(motor.paths[q], motor.names) for q in paths]
        self._columns: Columns = motor.columns
        self._number = [0 if alike else k for k in range(len(self._acts))]
        if alike:
            self.numbers = (Number("gain_at_most_flow", 0.0, 0.0, 2.0, 0.0, MOST_GAIN),)
        else:
            names = [f"gain_at_most_flow_of_{node}" for node, _ in self._between]
            self.numbers = tuple(
                Number(n, USUAL_GAIN, np.log(USUAL_GAIN), 1.0, 0.0, MOST_GAIN, log=True) for n in names
            )

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        if self._held:
            flow = np.full(levels.count, (self._usual / self._largest) ** self._power)
        else:
            flow = self._columns.power(levels, self.channel, self._power) / self._largest**self._power
        unit = self._columns.later(levels) * flow
        for q, k in zip(self._acts, self._number, strict=True):
            number = self.numbers[k]
            gain = number.value(float(values[k]))
            slope = (int(place.columns[k]), gain * unit if number.log else unit)
            draft.conductance.scale(q, (1.0 + gain * unit).clip(0.02), [slope])

    def unmoved(self) -> NetworkEffect | None:  # noqa: D102
        ends_at = (self._usual, self._largest)
        return Airflow(self._motor, self.channel, ends_at, self._power, self._acts, self.component, held=True)

    def spread(self) -> NetworkEffect | None:  # noqa: D102
        motor, ends_at = self._motor, (self._usual, self._largest)
        if len(motor.outer) < 2 or len(self.numbers) > 1:
            return None
        return Airflow(motor, self.channel, ends_at, self._power, motor.outer, WHOLE, alike=False)

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for between, k in zip(self._between, self._number, strict=True):
            entry.factor_on_path(between, self._factor(values[k]))

    def _factor(self, gain: float) -> FactorEntry:
        if self._power == 1.0:
            return FactorEntry(channel=self.channel, poly=(six_digits(gain / self._largest), 1.0))
        # Closer together where the root is steep.
        share = np.linspace(0.0, 1.0, POINTS) ** 2
        points = FactorPoints(
            at=tuple(six_digits(float(x)) for x in share * self._largest),
            value=tuple(six_digits(1.0 + gain * float(x) ** self._power) for x in share),
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
            if len(motor.outer) > 1:
                for q in motor.outer:
                    yield Airflow(motor, channel, ends_at, power, [q], motor.names[motor.paths[q][0]])
