"""How warm hidden nodes are where a run may begin: as they were found while the motor rested in the runs.

Few runs begin warm, and one of them says how warm it began itself. All runs together say more of how a motor is found
that has run before: h, the rise of a hidden node, against b, that at which it would rest between the sensed ones and
the ambient, at every moment of rest. Their ratio by least squares is sum h b / sum b^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.at_start import balance
from gen.identification.network.fitting.problem import Evaluated, Problem
from gen.identification.network.fitting.structure import Structure

ENOUGH = 0.05
"""Share of all b^2 over time that rest has to have: else every moment counts."""
LEAST, MOST = 0.1, 3.0
"""A factor multiplies the error of a reading, too: at a cold start there is nothing else."""
UNSURE = 0.2
"""Standard deviation of a factor's logarithm beside what it varies by in the runs."""


@dataclass(frozen=True, eq=False)
class Usual:
    """Factors at the start, as the runs let expect them.

    Attributes
    ----------
    log, deviation
        Logarithm by hidden node, and its standard deviation, shape (h,) each.
    """

    log: FloatArray
    deviation: FloatArray


def usual(problem: Problem[Structure], vector: FloatArray, evaluated: Evaluated) -> Usual:
    """Compare hidden nodes with where they would rest.

    Parameters
    ----------
    problem, vector, evaluated
        The network, its parameters, shape (P,), and its temperatures along the runs.
    """
    structure, inputs = problem.structure, problem.inputs
    rise = evaluated.after - problem.ambient(vector)[:, None]
    share = balance(structure, vector)
    rested, hidden = rise[:, : structure.sensors] @ share.T, rise[:, structure.sensors :]
    weight = inputs.width[:, None] * rested**2
    resting = np.where(inputs.rest[:, None] > 0.99, weight, 0.0)
    weight = np.where(resting.sum(axis=0) > ENOUGH * weight.sum(axis=0), resting, weight)
    total = np.maximum(weight.sum(axis=0), 1e-12)
    ratio = hidden / np.where(rested == 0.0, 1.0, rested)
    mean = np.sum(weight * ratio, axis=0) / total
    scatter = np.sqrt(np.sum(weight * (ratio - mean) ** 2, axis=0) / total)
    held = np.clip(mean, LEAST, MOST)
    return Usual(np.log(held), np.hypot(UNSURE, np.minimum(scatter / held, 1.0)))
