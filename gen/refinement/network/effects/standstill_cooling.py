"""Cooling at rest that is not what the model says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

LEAST_FACTOR = 0.01
"""A flap that shuts leaves next to nothing of what a surface lost by the air."""


class StandstillCooling(NetworkEffect):
    """Conductances to the ambient at rest, times a factor: one for all of them, or one for each."""

    name = "standstill_cooling"
    goes_with_speed = True

    def __init__(self, motor: Motor, paths: Sequence[int], component: str, *, alike: bool = True) -> None:
        self.component = component
        self._acts = tuple(paths)
        self._places = [motor.path_at(q) for q in paths]
        self._columns = motor.columns
        each = [f"{at.first}_{at.place + 1}" if at.place else at.first for at in self._places]
        names = ["factor_at_rest"] if alike else [f"factor_at_rest_of_{name}" for name in each]
        self._number = [0 if alike else k for k in range(len(self._acts))]
        self.numbers = tuple(Number(name, 1.0, 0.0, 0.7, LEAST_FACTOR, 20.0, log=True) for name in names)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        share = self._columns.later(levels) * levels.rest
        for q, k in zip(self._acts, self._number, strict=True):
            more = np.expm1(values[k])
            slope = (int(place.columns[k]), share * (1.0 + more))
            draft.conductance.scale(q, 1.0 + share * more, [slope])

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for at, k in zip(self._places, self._number, strict=True):
            entry.scale_path(at, np.ones_like, values[k])


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """On all paths to the ambient, alike or each by its own factor, or on one, where the motor stood still."""
    if not data.rests:
        return
    yield StandstillCooling(motor, motor.outer, WHOLE)
    if len(motor.outer) > 1:
        yield StandstillCooling(motor, motor.outer, WHOLE, alike=False)
        for q in motor.outer:
            yield StandstillCooling(motor, [q], motor.names[motor.paths[q][0]])
