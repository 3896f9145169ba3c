"""A path that conducts otherwise than the file says: a joint that came loose, vents that are blocked, thinner air."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.model.network_parts import AMBIENT
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.writer import NetworkWriter, Scale, ends
from gen.refinement.network.effects.base import SPEEDS, WHOLE, Motor, NetworkEffect, Number, Place
from gen.refinement.network.effects.offered import Offered

LEAST_FACTOR, MOST_FACTOR = 1e-6, 10.0
"""A way that was lost altogether is no doubtful one, however little of it is said to be left."""
NONE_LEFT = 0.05
"""Below this share runs hardly tell how little is left: that is called next to nothing."""
LEAST_CHANGE, LEAST_OF_ALL = 0.25, 0.1
"""Of a conductance, and of all to the ambient together: what a file is off by, its own numbers are there for."""
BY_SPEED = 0.2
"""Share of a conductance at full speed that has come with speed, below which there is no such share to lose."""


class PathChange(NetworkEffect):
    """Conductances times one factor, or what of them has come with speed times one: a fan's share, without it at rest.

    Parameters
    ----------
    motor
        What it is put on.
    paths, component
        Which paths, and where they begin.
    by_speed
        Only what they conduct beyond what they do at rest.
    """

    name = "path_change"
    goes_with_speed = True

    def __init__(self, motor: Motor, paths: Sequence[int], component: str, *, by_speed: bool = False) -> None:
        self.component = component
        self.other = _other(motor, paths)
        self.acts_by = {"other": self.other}
        self._paths, self._by_speed, self._columns = tuple(paths), by_speed, motor.columns
        self._places = [motor.path_at(q) for q in paths]
        self._with_speed = [motor.with_speed[q] for q in paths]
        self.title = "cooling by speed that has changed" if by_speed else "a path that has changed"
        name = "factor_of_what_speed_adds" if by_speed else "factor"
        # More between two parts is a coupling.
        most = MOST_FACTOR if self.other == AMBIENT else 1.0
        self.numbers = (Number(name, 0.8, 0.0, 1.0, LEAST_FACTOR, most, log=True),)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        factor = float(np.exp(np.clip(values[0], -60.0, 60.0)))
        later = self._columns.later(levels)
        for q, share in zip(self._paths, self._with_speed, strict=True):
            moved = later * (1.0 - levels.rest) * np.interp(levels.speed, SPEEDS, share) if self._by_speed else later
            draft.conductance.scale(q, 1.0 + moved * (factor - 1.0), place.slopes(moved * factor))

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        if abs(values[0] - 1.0) < (LEAST_OF_ALL if len(self._paths) > 1 else LEAST_CHANGE):
            return ["a conductance that has changed by so little is what the file may be off by"]
        return []

    def change(self, values: Sequence[float]) -> str:
        """Say what has changed, and what does that."""
        conducts = f"conducts {_times(values[0])} what it did"
        if self.other != AMBIENT:
            return (
                f"{self.component} to {self.other} {conducts}, as a joint that came loose does (a screw, a mount, glue)"
            )
        where = "what leads to the ambient" if self.component == WHOLE else f"{self.component} to the ambient"
        if values[0] > 1.0:
            return f"{where} {conducts}, as a motor that is blown at, was cleaned, or is mounted otherwise does"
        if self._by_speed:
            less = f"{_times(values[0])} what it was"
            return f"what speed adds to {where} is {less}, as with blocked vents or a lost fan"
        return f"{where} {conducts}, as below dust or a cover, in thin air, or on another mount"

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for at, share in zip(self._places, self._with_speed, strict=True):
            if self._by_speed:
                entry.scale_path(at, self._scale(share, values[0]), 1.0)
            else:
                entry.scale_path(at, lambda w: np.full_like(w, values[0]), values[0])

    @staticmethod
    def _scale(share: FloatArray, factor: float) -> Scale:
        return lambda w: np.asarray(1.0 + (factor - 1.0) * np.interp(w, SPEEDS, share))


def _times(factor: float) -> str:
    return "next to nothing of" if factor < NONE_LEFT else f"{factor:.2g} times"


def _other(motor: Motor, paths: Sequence[int]) -> str:
    """Where they all end."""
    (other,) = {ends(motor.paths[q], motor.names)[1] for q in paths}
    return other


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """On each path, on all to the ambient, and on what speed adds to these."""
    outer = motor.outer
    by_speed = [q for q in outer if motor.with_speed[q][-1] > BY_SPEED]
    if len(outer) > 1:
        yield PathChange(motor, outer, WHOLE)
    if len(by_speed) > 1:
        yield PathChange(motor, by_speed, WHOLE, by_speed=True)
    for q in by_speed:
        yield PathChange(motor, [q], motor.names[motor.paths[q][0]], by_speed=True)
    for q in motor.lawless:
        yield PathChange(motor, [q], motor.names[motor.paths[q][0]])
