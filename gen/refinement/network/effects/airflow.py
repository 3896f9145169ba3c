"""A measured flow of air that cools paths to the ambient."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gen.coefficients.network import FactorEntry
from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.refinement.network.columns import Columns
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter, ends, short


class Airflow(NetworkEffect):
    """G (1 + a v + b v^2), v a channel over its largest value; on one path to the ambient, or on all."""

    name = "airflow"

    def __init__(self, motor: Motor, channel: str, largest: float, paths: Sequence[int], component: str) -> None:
        self.component = component
        self.acts_by = {"channel": channel}
        self.channel, self._largest, self._acts = channel, largest, tuple(paths)
        self._between = [ends(motor.paths[q], motor.names) for q in paths]
        self._columns: Columns = motor.columns
        self.numbers = (
            Number("gain_at_most_flow", 0.3, 0.0, 2.0, 0.0, 30.0),
            Number("curvature_at_most_flow", 0.0, 0.0, 1.0, -15.0, 15.0),
        )

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        first = later * self._columns.power(levels, self.channel, 1) / self._largest
        # What curvature adds is zero at both ends.
        second = later * self._columns.power(levels, self.channel, 2) / self._largest**2 - first
        factor = 1.0 + values[0] * first + values[1] * second
        held = factor.clip(0.02)
        for q in self._acts:
            draft.conductance.scale(q, held, place.slopes(first, second))

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        return ["more flow would cool less"] if abs(values[1]) > values[0] else []

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        a, b, v = values[0], values[1], self._largest
        poly = (short(b / v**2), short((a - b) / v), 1.0)
        for between in self._between:
            entry.factor_on_path(between, FactorEntry(channel=self.channel, poly=poly))


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Every channel that moves may be a flow: on all paths to the ambient, or on one."""
    for channel in data.flows:
        largest = max(abs(end) for end in data.ranges[channel])
        yield Airflow(motor, channel, largest, motor.outer, WHOLE)
        if len(motor.outer) > 1:
            for q in motor.outer:
                yield Airflow(motor, channel, largest, [q], motor.names[motor.paths[q][0]])
