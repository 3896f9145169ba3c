"""Cooling at rest that is not what the model says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.refinement.network.draft import Draft
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.writer import NetworkWriter, ends


class StandstillCooling(NetworkEffect):
    """Conductances to the ambient at rest, times a factor."""

    name = "standstill_cooling"

    def __init__(self, motor: Motor, paths: Sequence[int], component: str) -> None:
        self.component = component
        self._acts = tuple(paths)
        self._between = [ends(motor.paths[q], motor.names) for q in paths]
        self._columns = motor.columns
        self.numbers = (Number("factor_at_rest", 1.0, 0.0, 0.7, 0.05, 20.0, log=True),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        share = self._columns.later(levels) * levels.rest
        more = np.expm1(values[0])
        for q in self._acts:
            draft.conductance.scale(q, 1.0 + share * more, place.slopes(share * (1.0 + more)))

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for between in self._between:
            entry.scale_path(between, np.ones_like, values[0])


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """On all paths to the ambient, or on one, where the motor stood still."""
    if not data.rests:
        return
    yield StandstillCooling(motor, motor.outer, WHOLE)
    if len(motor.outer) > 1:
        for q in motor.outer:
            yield StandstillCooling(motor, [q], motor.names[motor.paths[q][0]])
