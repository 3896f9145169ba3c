"""Heat that goes with speed otherwise than the model says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.identification.network.bends import BEND, KNOTS, spline
from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter

MOST_FACTOR = 3.0


class ScheduleError(NetworkEffect):
    """A node's heat times a smooth factor over speed, or a heat where the model has none."""

    name = "schedule_error"
    bends_the_file = True

    def __init__(self, motor: Motor, node: int) -> None:
        self.component = motor.names[node]
        self._node, self._columns = node, motor.columns
        self.replaces = node in motor.heated
        if self.replaces:
            self.numbers = tuple(
                Number(f"factor_at_{knot:.0%}_of_full_speed".replace("%", "pct"), 1.0, 0.0, BEND, 0.02, 50.0, log=True)
                for knot in KNOTS
            )
        else:
            self.numbers = (Number("power_at_full_speed_W", 0.0, 0.0, motor.typical_W, -np.inf, np.inf),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        turning = later * (1.0 - levels.rest)
        if not self.replaces:
            unit = turning * levels.speed
            draft.heat.add(self._node, values[0] * unit, place.slopes(unit))
            return
        functions = spline(levels.speed)
        factor = np.exp(np.clip(functions @ values, -60.0, 60.0))
        slopes = [turning * factor * functions[:, k] for k in range(functions.shape[1])]
        draft.scale_heats(self._node, 1.0 + turning * (factor - 1.0), place.slopes(*slopes))

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        # No run says what a curve would be at rest, the first knot. Heat that has grown everywhere is a change.
        told = values[1:]
        if self.replaces and min(told) < 1.0 and not all(1.0 / MOST_FACTOR < value < MOST_FACTOR for value in told):
            return ["heat at some speed would be off by a factor of more than three: that is no error of a schedule"]
        return []

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        if not self.replaces:
            entry.heat_over_speed(self.component, lambda w: np.maximum(values[0] * w, 0.0))
            return
        logs = np.log(np.asarray(values))
        entry.scale_heat(self.component, lambda w: np.exp(spline(w) @ logs))


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """At every node."""
    for node in range(len(motor.names)):
        yield ScheduleError(motor, node)
