"""Heat that goes with speed otherwise than the model says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.identification.network.fitting.bends import BEND, KNOTS, WIDE, Bend
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import SPEEDS, WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

MOST_FACTOR, FALLS = 3.0, 0.8
"""Of heat at some speeds; and below which it falls at others: a little less is what a curve does beside a peak."""

NARROW = Bend(np.linspace(0.0, 1.0, 21), 0.12, 1e-4)
"""A resonance or a step within a tenth of full speed: between knots twice as far apart a sixth of one with a standard
deviation of 0.06 gets lost, between these a hundredth. They are too near each other to go apart."""
NEAR = 0.05
"""What a narrow bend is at a speed further off than this share of full speed no run says."""
AS_THE_FILE = 0.1
"""Standard deviation of the logarithm of a narrow bend's factor where no run says it: the file was measured there."""


class ScheduleError(NetworkEffect):
    """The heat of a node, or of all nodes, times a smooth factor over speed; or a heat where the model has none.

    Parameters
    ----------
    motor
        What it is put on.
    nodes, component
        Whose heat, and what they are called together.
    bend
        How narrowly the factor bends.
    unknown
        Knots of it that no run comes near, shape (knots,): there it stays what the file says.
    """

    name = "schedule_error"
    goes_with_speed = True
    bends_the_file = True

    def __init__(
        self,
        motor: Motor,
        nodes: Sequence[int],
        component: str,
        bend: Bend = WIDE,
        unknown: BoolArray | None = None,
    ) -> None:
        self.component = component
        self._nodes, self._columns, self._bend = tuple(nodes), motor.columns, bend
        self._names = [motor.names[node] for node in nodes]
        self.replaces = all(node in motor.heated for node in nodes)
        self._heat_W = sum(
            (motor.heat_W[motor.heated.index(n)] for n in nodes if n in motor.heated), np.zeros(SPEEDS.size)
        )
        if self.replaces:
            self.precision = bend.precision()
            if unknown is not None:
                self.precision = self.precision + np.diag(unknown / AS_THE_FILE**2)
            self.numbers = tuple(
                Number(f"factor_at_{knot:.0%}_of_full_speed".replace("%", "pct"), 1.0, 0.0, BEND, 0.02, 50.0, log=True)
                for knot in bend.knots
            )
        else:
            self.numbers = (Number("power_at_full_speed_W", 0.0, 0.0, motor.typical_W, -np.inf, np.inf),)

    @property
    def freedom(self) -> int:  # noqa: D102
        # Neighbouring knots go together, which the fit's own penalty counts: a narrow bend is one more place, no more.
        return min(len(self.numbers), 1 + KNOTS.size)

    def factor(self, speed: FloatArray, values: Sequence[float]) -> FloatArray:
        """Give the factor at speeds, shape (L,), from its values at the knots."""
        return np.asarray(np.exp(self._bend(speed) @ np.log(np.asarray(values))))

    def added_W(self, speed: FloatArray, values: Sequence[float]) -> FloatArray:
        """Give what the factor adds to the file's heat at speeds, W, shape (L,)."""
        return (self.factor(speed, values) - 1.0) * np.interp(speed, SPEEDS, self._heat_W)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        turning = later * (1.0 - levels.rest)
        if not self.replaces:
            unit = turning * levels.speed
            draft.heat.add(self._nodes[0], values[0] * unit, place.slopes(unit))
            return
        functions = self._bend(levels.speed)
        factor = np.exp(np.clip(functions @ values, -60.0, 60.0))
        slopes = [turning * factor * functions[:, k] for k in range(functions.shape[1])]
        for node in self._nodes:
            draft.scale_heats(node, 1.0 + turning * (factor - 1.0), place.slopes(*slopes))

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        # No run says what a curve would be at rest, the first knot. Heat that has grown everywhere is a change.
        told = values[1:]
        if self.replaces and min(told) < FALLS and not all(1.0 / MOST_FACTOR < value < MOST_FACTOR for value in told):
            return ["heat at some speed would be off by a factor of more than three: that is no error of a schedule"]
        return []

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for name in self._names:
            if self.replaces:
                entry.scale_heat(name, lambda w: self.factor(w, values))
            else:
                entry.heat_over_speed(name, lambda w: np.maximum(values[0] * w, 0.0))


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """At every node, and at all that are heated."""
    unknown = ~data.was_run(NARROW.knots, NEAR)
    for node in range(len(motor.names)):
        yield ScheduleError(motor, [node], motor.names[node])
        if node in motor.heated:
            yield ScheduleError(motor, [node], motor.names[node], NARROW, unknown)
    if len(motor.heated) > 1:
        yield ScheduleError(motor, motor.heated, WHOLE)
        yield ScheduleError(motor, motor.heated, WHOLE, NARROW, unknown)
