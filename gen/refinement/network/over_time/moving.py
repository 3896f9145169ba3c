"""A heat, or a conductance to the ambient, that is another one in each block of a run, as a term of the network."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Inputs, Levels
from gen.refinement.network.changing.draft import Draft
from gen.refinement.network.changing.draft import Quantity as Drafted
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import NetworkEffect, Place
from gen.refinement.network.over_time.courses import Quantity

LEAST = 0.1
"""Share of its conductance that a path keeps: a cover does not insulate it entirely."""
_TINY = 1e-9


class Moving(NetworkEffect):
    """c times what the network has of the same on average while the motor turns; c is the last column of the inputs.

    It has no number of its own: c is given (:func:`with_course`), and found by what it changes. It goes with what the
    network has: were it W or W/K, it would pay to make all capacities, conductances and heats less by the same factor,
    which no reading of a temperature tells, so that the course is less too.
    """

    quantity: ClassVar[Quantity]
    #: The network's paths to the ambient of which it changes the conductance.
    acts_on: tuple[int, ...] = ()

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        raise NotImplementedError("no file holds a course over time")


class MovingCooling(Moving):
    """G + c G', G' the mean conductance of some paths to the ambient while the motor turns.

    Parameters
    ----------
    component
        A node, or the whole motor.
    paths
        On which of the network's paths it acts.
    like
        For each of them, whose conductance one unit of c is like.
    """

    name = "moving_cooling"
    quantity = "conductance"

    def __init__(self, component: str, paths: Sequence[int], like: Sequence[Sequence[int]]) -> None:
        self.component, self.acts_on = component, tuple(paths)
        self._like = tuple(tuple(own) for own in like)
        self.numbers = ()

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        course, mean = levels.further[:, -1], _turning_mean(levels)
        units = [_mean_of(draft.conductance, mean, like) for like in self._like]
        for q, (unit, slopes) in zip(self.acts_on, units, strict=True):
            least = (LEAST - 1.0) * draft.conductance.value[:, q]
            added = course * unit
            free = np.where(added > least, course, 0.0)
            draft.conductance.add(q, np.maximum(added, least), [(at, free * slope) for at, slope in slopes])


class MovingHeat(Moving):
    """P + c P', P' the mean heat of the whole motor while it turns.

    Parameters
    ----------
    component
        A node, or the whole motor.
    node
        Which; None for all, in the proportions of their heats at each speed.
    """

    name = "moving_heat"
    quantity = "heat"

    def __init__(self, component: str, node: int | None) -> None:
        self.component, self._node = component, node
        self.numbers = ()

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: D102
        course, heat = levels.further[:, -1], draft.heat
        nodes = range(heat.value.shape[1])
        unit, by_unit = _mean_of(heat, _turning_mean(levels), nodes)
        every = [heat.slopes(at) for at in nodes]
        before = heat.value.copy()
        share, over = self._shares(before)
        for at in nodes if self._node is None else (self._node,):
            own = [(by, course * share[:, at] * slope) for by, slope in by_unit]
            if self._node is None:
                own += [(by, course * unit * over * slope) for by, slope in every[at]]
                own += [(by, -course * unit * over * share[:, at] * slope) for one in every for by, slope in one]
            heat.add(at, course * unit * share[:, at], own)

    def _shares(self, heat: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where one watt is, shape (L, n), and one over the heat of which it is a share where there is any, 1/W."""
        if self._node is not None:
            made = np.zeros_like(heat)
            made[:, self._node] = 1.0
            return made, np.zeros(len(heat))
        total = heat.sum(axis=1)
        over = np.where(total > _TINY, 1.0 / np.maximum(total, _TINY), 0.0)
        return heat * over[:, None], over


def _mean_of(drafted: Drafted, mean: FloatArray, which: Sequence[int]) -> tuple[float, list[tuple[int, float]]]:
    """The mean of what some entries come to together, and its derivatives."""
    value = float(sum(mean @ drafted.value[:, at] for at in which))
    return value, [(by, float(mean @ slope)) for at in which for by, slope in drafted.slopes(at)]


def _turning_mean(levels: Levels) -> FloatArray:
    """Weights of a mean over distinct inputs by the time that they turn in one bin each, shape (L,)."""
    weight = (1.0 - levels.rest) * levels.width
    return np.asarray(weight / max(float(weight.sum()), _TINY))


def with_course(inputs: Inputs, course: FloatArray) -> Inputs:
    """Add a column to the inputs.

    Parameters
    ----------
    inputs
        The bins.
    course
        Its value in each of them, shape (N,).
    """
    value, which = np.unique(np.round(course, 9), return_inverse=True)
    pair, level = np.unique(inputs.level * value.size + np.ravel(which), return_inverse=True)
    old, own = inputs.levels, pair // value.size
    further = np.column_stack([old.further[own], value[pair % value.size]])
    levels = Levels(old.width[own], old.rest[own], old.speed[own], old.square[own], further)
    return replace(inputs, level=np.ravel(level), levels=levels)


def given(levels: Levels, course: float) -> Levels:
    """Let the course be the same at all distinct inputs."""
    further = levels.further.copy()
    further[:, -1] = course
    return replace(levels, further=further)
