"""How fast a network may be: a board has to follow each node, so the fit looks for no network that it cannot.

Runs tell nodes that are together within seconds from one only by chance. What is then found has to be slowed before a
file can hold it, and a network that is slowed after it was fitted is no longer the one that was judged.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients.checks.model_checks import FASTEST as FASTEST_OF_A_FILE
from gen.identification.network.fitting.inputs import held
from gen.identification.network.fitting.physics import Shape

FASTEST = 2.0 / FASTEST_OF_A_FILE
"""No node follows its neighbours, and no two nodes each other, within fewer steps of the board: twice what a file must
keep to, since this is looked at for `SPEEDS` alone, and in a file at every |PWM|."""
MARGIN = 1.02
"""Times as slow as that is what is looked for: a penalty gives way a little."""
UNIT = 0.01
"""Logarithm of a rate beyond it that counts as a standard deviation."""
SPEEDS = held(np.array([0.0, 0.25, 0.5, 0.75, 1.0]), 1)


def too_fast(structure: Shape, vector: FloatArray, least_s: float) -> tuple[FloatArray, FloatArray]:
    """How far nodes and paths are beyond what can be followed, in standard deviations; 0 for those that are not.

    A node with a capacity C follows its neighbours with the time constant C / (sum of its G); two capacities C and D
    with a conductance G between them come together with C D / ((C + D) G).

    Parameters
    ----------
    structure, vector
        The network.
    least_s
        The shortest time constant, s; 0 for no limit.

    Returns
    -------
    residual, slopes
        Shapes (k,) and (k, p): by the parameters that all runs share.
    """
    if least_s <= 0.0:
        return np.zeros(0), np.zeros((0, structure.size))
    return _too_fast(structure, vector[: structure.size].tobytes(), least_s)


@lru_cache(maxsize=4)
def _too_fast(structure: Shape, shared: bytes, least_s: float) -> tuple[FloatArray, FloatArray]:
    """The same where there is a limit, kept as in `plausible`."""
    physics = structure.physical(SPEEDS, np.frombuffer(shared))
    nodes, ends = structure.nodes, np.abs(structure.incidence)
    inverse = 1.0 / physics.capacity
    # Of each node, then of each path: what carries its temperature off, W/K, and what that is over capacities, 1/s.
    carrying = np.vstack([ends.T, np.eye(len(ends))])
    between = ends @ inverse
    share = np.concatenate([inverse, between])
    conductance = physics.conductance @ carrying.T
    logs = np.log(np.maximum(conductance * share * (MARGIN * least_s), 1e-300))
    slopes = np.zeros((SPEEDS.count, nodes + len(ends), structure.size))
    physics.by_path.add_to(slopes, carrying[None] / np.maximum(conductance, 1e-300)[..., None])
    places = np.arange(nodes)  # capacities stand first among the parameters, as logarithms
    slopes[:, :nodes, :nodes] -= np.eye(nodes)
    slopes[:, nodes:, places] -= ends * inverse / between[:, None]
    beyond = logs > 0.0
    return logs[beyond] / UNIT, slopes[beyond] / UNIT
