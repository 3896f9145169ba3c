"""The best network of one structure: from loose to tight, so that the search does not end in the first hollow."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.identification.network.fitting.bins import FloatArray
from gen.identification.network.fitting.fit import Fit, approach, settle
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.fitting.priors import prior_of
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.structure import Structure
from gen.identification.network.fitting.weights import density, weights
from gen.identification.network.starts import from_parts, in_roles, taken_over

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


def search(structure: Structure, inputs: Inputs, scale: Scale, before: Found | None = None) -> Found:
    """Find the best network of a structure.

    Parameters
    ----------
    structure
        What is free.
    inputs
        The runs; their weights are not used.
    scale
        What the parts do alone.
    before
        What was found with fewer hidden nodes: one more place to begin from.
    """
    problem = Problem(structure, inputs, prior_of(structure, inputs, scale))
    sensors = len(structure.sensed)
    alike = from_parts(problem, scale)
    starts = [alike, in_roles(problem, alike)] if structure.hidden else [alike]
    firm = problem.weighed(weights(inputs, np.full(sensors, FIRST_AT)))
    found = []
    for vector in starts:
        for level in LOOSE:
            loose = problem.weighed(weights(inputs, np.full(sensors, level)))
            vector = approach(loose, vector, AT_EACH).vector
        found.append(settle(firm, vector, AT_FIRST))
    if before is not None:
        found.append(settle(firm, taken_over(problem, before.problem, before.vector), AT_FIRST))
    best = min(found, key=lambda fit: fit.cost)
    return tightened(problem, best.vector, np.full(sensors, FIRST_AT), AT_LAST)


def bent(stiff: Found, bend: float, scale: Scale) -> Found:
    """Let the curves over speed of a network bend, and go on from where it is.

    Parameters
    ----------
    stiff
        With curves that hardly bend.
    bend
        How far they may from now on (see :class:`Structure`).
    scale
        For the prior.
    """
    inputs, structure = stiff.problem.inputs, replace(stiff.structure, bend=bend)
    problem = Problem(structure, inputs, prior_of(structure, inputs, scale))
    first = np.full(len(structure.sensed), FIRST_AT)
    vector = approach(problem.weighed(weights(inputs, first)), stiff.vector, AT_FIRST).vector
    return tightened(problem, vector, first, AT_LAST)


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
    inputs, structure = without.problem.inputs, replace(without.structure, natural=widest)
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
        own = density(problem.inputs, fit.evaluated.residual)
        if np.all(np.abs(np.log(own / of)) < SAME):
            break
        of = own
    return Found(problem, fit, own)
