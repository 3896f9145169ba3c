"""The best network of one structure: from loose to tight, so that the search does not end in the first hollow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.fit import Fit, approach, settle
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.fitting.priors import prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.structure import Structure
from gen.identification.network.fitting.weights import slow_density, weights
from gen.identification.network.starts import from_parts, in_roles, taken_over
from gen.side_by_side import side_by_side

LOOSE = (3000.0, 300.0, 80.0)
"""Densities of the errors with which the search begins, K^2 s: 2 K for ten minutes, and less each time."""
FIRST_AT = 20.0
AT_EACH, AT_FIRST, AT_LAST = 6, 14, 14
"""Linearisations."""
SAME = 0.25
"""Logarithm of the densities within which they agree with the residual's own."""


@dataclass(frozen=True, eq=False)
class Found:
    """One structure at its best.

    Attributes
    ----------
    problem
        With the weights that agree with the residual.
    fit
        The minimum.
    density
        Of the residual, shape (S,), K^2 s.
    """

    problem: Problem[Structure]
    fit: Fit
    density: FloatArray

    @property
    def structure(self) -> Structure:
        """What was fitted."""
        return self.problem.structure

    @property
    def vector(self) -> FloatArray:
        """Parameters, shape (P,)."""
        return self.fit.vector


@dataclass(frozen=True, eq=False)
class Search:
    """The search of the best network of a structure, in parts that can be done side by side.

    Attributes
    ----------
    problem
        What is free, and the runs; their weights are not used.
    scale
        What the parts do alone.
    """

    problem: Problem[Structure]
    scale: Scale

    @classmethod
    def of(cls, structure: Structure, inputs: Inputs, scale: Scale) -> Search:
        """Give the search of a structure."""
        return cls(Problem(structure, inputs, prior_of(structure, inputs, scale)), scale)

    def afresh(self) -> list[Callable[[], Fit]]:
        """Give the searches that begin with what each part does alone, from loose to firm."""
        alike = from_parts(self.problem, self.scale)
        starts = [alike, in_roles(self.problem, alike)] if self.problem.structure.hidden else [alike]
        return [partial(self._from_afar, start) for start in starts]

    def _from_afar(self, vector: FloatArray) -> Fit:
        for level in LOOSE:
            vector = approach(self._weighed(level), vector, AT_EACH).vector
        return settle(self._weighed(FIRST_AT), vector, AT_FIRST)

    def from_fewer(self, before: Found) -> Fit:
        """Search from where a network with fewer hidden nodes is."""
        start = taken_over(self.problem, before.problem, before.vector)
        return settle(self._weighed(FIRST_AT), start, AT_FIRST)

    def ended(self, fits: Sequence[Fit]) -> Found:
        """Go on from the best of all."""
        best = min(fits, key=lambda fit: fit.cost)
        first = np.full(len(self.problem.structure.sensed), FIRST_AT)
        return tightened(self.problem, best.vector, first, AT_LAST)

    def _weighed(self, level: float) -> Problem[Structure]:
        of = np.full(len(self.problem.structure.sensed), level)
        return self.problem.weighed(weights(self.problem.inputs, of))


def bent(stiff: Sequence[Found], bend: float, scale: Scale) -> list[Found]:
    """Let the curves over speed of networks bend, and go on from where each is, side by side.

    Parameters
    ----------
    stiff
        With curves that hardly bend.
    bend
        How far they may from now on (see :class:`Structure`).
    scale
        For the prior.
    """
    problems = []
    for one in stiff:
        inputs, structure = one.problem.inputs, replace(one.structure, bend=bend)
        problems.append(Problem(structure, inputs, prior_of(structure, inputs, scale)))
    return all_found(problems, [partial(_bent, *each) for each in zip(problems, stiff, strict=True)])


def _bent(problem: Problem[Structure], stiff: Found) -> Found:
    first = np.full(len(problem.structure.sensed), FIRST_AT)
    vector = approach(problem.weighed(weights(problem.inputs, first)), stiff.vector, AT_FIRST).vector
    return tightened(problem, vector, first, AT_LAST)


class Told(NamedTuple):
    """What a search that another process did has to tell: the rest is here, and parts are known by what they are.

    Attributes
    ----------
    weight
        Of the readings, shape (N, S).
    fit, density
        As in :class:`Found`.
    """

    weight: FloatArray
    fit: Fit
    density: FloatArray

    def of(self, problem: Problem[Structure]) -> Found:
        """What was found of this process's own problem."""
        return Found(problem.weighed(self.weight), self.fit, self.density)


def told(search: Callable[[], Found]) -> Told:
    """Search, and tell what was found."""
    found = search()
    return Told(found.problem.inputs.weight, found.fit, found.density)


def all_found(problems: Sequence[Problem[Structure]], searches: Sequence[Callable[[], Found]]) -> list[Found]:
    """Do searches side by side, one for each problem."""
    made = side_by_side([partial(told, search) for search in searches])
    return [one.of(problem) for problem, one in zip(problems, made, strict=True)]


def in_still_air(without: Found, widest: float, scale: Scale) -> Found:
    """Let natural convection take a share of what goes to the ambient, and go on from where a network is.

    Parameters
    ----------
    without
        With conductances that do not depend on temperature.
    widest
        The largest difference to the ambient that is described, K.
    scale
        For the prior.
    """
    return _gone_on(without, replace(without.structure, natural=widest), scale)


def with_warmth(without: Found, room_degC: float, scale: Scale) -> Found:
    """Let all heats grow with temperature, and go on from where a network is.

    Parameters
    ----------
    without
        With heats that do not.
    room_degC
        From which temperature on.
    scale
        For the prior.
    """
    return _gone_on(without, replace(without.structure, warmth=room_degC), scale)


def _gone_on(without: Found, structure: Structure, scale: Scale) -> Found:
    """Fit another structure from where a network is."""
    inputs = without.problem.inputs
    problem = Problem(structure, inputs, prior_of(structure, inputs, scale))
    start = taken_over(problem, without.problem, without.vector)
    return tightened(problem, start, without.density, AT_LAST)


def tightened(problem: Problem[Structure], start: FloatArray, of: FloatArray, most: int, rounds: int = 3) -> Found:
    """Fit until the weights agree with what is left.

    Parameters
    ----------
    problem, start
        What to fit, from where.
    of
        Density to begin with, shape (S,), K^2 s.
    most
        Linearisations in the first round; half as many in each further one.
    rounds
        At most.
    """
    for number in range(rounds):
        problem = problem.weighed(weights(problem.inputs, of))
        fit = settle(problem, start, most if number == 0 else max(most // 2, 4))
        start = fit.vector
        own, _ = slow_density(problem.inputs, fit.evaluated.residual)
        if np.all(np.abs(np.log(own / of)) < SAME):
            break
        of = own
    return Found(problem, fit, own)
