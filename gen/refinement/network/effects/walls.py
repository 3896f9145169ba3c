"""A room whose walls lag behind its air: what the thermometer reads is not all that the motor gives its heat to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import OWN, WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

STIFF = 300.0
"""Conductance between walls and air over the motor's typical one: so the motor does not warm its room."""
FASTEST_S, SLOWEST_S = 1800.0, 40_000.0
LEAST_RATIO = 0.1
"""Of what goes to walls over what goes to the air: radiation alone carries more of what a motor gives off. There is no
most: in a cabinet outside of which the thermometer is, all goes to walls."""


class Walls(NetworkEffect):
    """A share of every path to the ambient leads to walls (or a bench) instead, which follow the air with a lag.

    A surface gives heat to the air, and by radiation to what surrounds it, and through its feet to what it stands on
    (Incropera et al., Fundamentals of Heat and Mass Transfer, 1.2.3: T_sur is not T_infinity). The walls are a node of
    their own between the motor and the ambient, which is how a file holds them.
    """

    name = "ambient"
    title = "walls that lag behind the ambient"
    component = WHOLE
    nodes = 1

    def __init__(self, motor: Motor) -> None:
        self._acts = tuple((q, motor.paths[q][0]) for q in motor.outer)
        self._from = tuple(dict.fromkeys(motor.names[motor.paths[q][0]] for q in motor.outer))
        self._columns = motor.columns
        self._to_air = STIFF * motor.typical_W_per_K
        capacity = self._to_air * 7200.0
        self.acts_by = {"through": "walls"}
        self.numbers = (
            Number("lag_s", 7200.0, float(np.log(capacity)), 1.0, 1e-9, 1e9, log=True, unit=self._to_air),
            Number("to_walls_over_to_air", 0.5, 0.0, 1.5, LEAST_RATIO, np.inf, log=True),
        )

    @property
    def paths(self) -> tuple[tuple[int, int], ...]:  # noqa: D102
        return ((OWN, -1), *((OWN, node) for _, node in self._acts))

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        later = self._columns.later(levels)
        share = _share(float(np.exp(np.clip(values[1], -60.0, 60.0))))
        slope = later * share * (1.0 - share)  # by the logarithm of the ratio
        draft.conductance.add(place.path, np.full(levels.count, self._to_air), [])
        (column,) = place.columns[1:].tolist()
        for k, (q, _) in enumerate(self._acts, 1):
            whole, slopes = draft.conductance.value[:, q].copy(), draft.conductance.slopes(q)
            inherited = [(by, share * later * own) for by, own in slopes]
            draft.conductance.add(place.path + k, share * later * whole, [*inherited, (column, slope * whole)])
            draft.conductance.scale(q, 1.0 - share * later, [(column, -slope)])

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        if FASTEST_S < values[0] < SLOWEST_S:
            return []
        return [f"walls that follow the air within {values[0]:.0f} s: such runs do not show that"]

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        lag, ratio = values
        walls = entry.node(lag * self._to_air)
        entry.path(walls, "ambient", self._to_air)
        for node in self._from:
            entry.lead_away(node, walls, _share(ratio))


def _share(ratio: float) -> float:
    """Of what goes to walls and air, what goes to walls."""
    return ratio / (1.0 + ratio)


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """On all paths to the ambient, where a measured one moves."""
    if data.room_moves and motor.outer:
        yield Walls(motor)
