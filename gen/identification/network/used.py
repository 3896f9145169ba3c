"""What the coefficient file makes of its own runs.

A fit gives each run starts and, where nobody measured it, a room of its own. Whoever uses the file has no such choice:
sensed nodes start as first read, hidden ones where the file says, and a room that is not measured is the file's. What
a model errs by in its runs is said of that: `gen simulate` gives the same, and so would the board.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.past import past_weights
from gen.identification.network.fitting.problem import Evaluated
from gen.identification.network.search import Found


def as_used(found: Found, ambient_fixed: float | None) -> Evaluated:
    """Follow all runs as the file's user does.

    Parameters
    ----------
    found
        The network.
    ambient_fixed
        The file's ambient where none was measured, degC; None where it is the one that each run says.
    """
    problem, vector = found.problem, found.vector.copy()
    inputs, structure = problem.inputs, problem.structure
    sensors, nodes = structure.sensors, structure.nodes
    own = problem.per_run(vector)  # a view
    read = np.array([run.first for run in inputs.runs]) - vector[structure.offsets]
    own[:, :sensors] = np.where(np.isfinite(read), read - inputs.begin[:, :sensors], 0.0)
    own[:, sensors:] = 0.0
    for r, run in enumerate(inputs.runs):
        if not run.ambient_known:
            own[r, nodes:] = 0.0 if ambient_fixed is None else ambient_fixed - run.ambient[0]
    shares = start_from(found)
    if shares is not None and not structure.start:  # else the fit begins there, too
        ambient = np.array([run.ambient[0] for run in inputs.runs]) + (own[:, nodes] if own.shape[1] > nodes else 0.0)
        rises = inputs.begin[:, :sensors] + own[:, :sensors] - ambient[:, None]
        own[:, sensors:nodes] = ambient[:, None] + rises @ shares.T - inputs.begin[:, -1:]
    return problem.evaluate(vector)


def start_from(found: Found) -> FloatArray | None:
    """Give the share of each sensed node's rise that each hidden one begins with in the file, shape (h, S).

    None where the file says a multiple of what is between the sensed ones at rest, or nothing is hidden.
    """
    structure = found.structure
    if structure.start:
        return np.array(structure.start)
    return None if structure.factors.size else past_weights(structure, found.vector, found.problem.inputs)


def rms_K(found: Found, residual: FloatArray) -> FloatArray:
    """Give the root mean square by run and part, shape (R, S), K; NaN where nothing was read."""
    inputs = found.problem.inputs
    total = np.array([inputs.covered[row].sum(axis=0) for row in inputs.rows])
    square = np.array([np.sum(inputs.covered[row] * residual[row] ** 2, axis=0) for row in inputs.rows])
    return np.where(total > 0.0, np.sqrt(square / np.maximum(total, 1e-9)), np.nan)
