"""A room that nobody measured and nobody noted: one level, the same mistake for all runs, is estimated with the rest.

The room of run r at its hats is h_r = c + e_r, with c ~ N(0, W^2) common to all such runs and e_r each run's own (see
`priors`). With c integrated out, the precision Q0 of all e together becomes Q0 - Q0 1 1^T Q0 / (1/W^2 + 1^T Q0 1), and
given h the mean of c is W^2 1^T Q h.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.inputs import Inputs


def unsure_K(inputs: Inputs) -> float:
    """What the rooms may be off by together, standard deviation, K; 0 where each was measured or noted."""
    return max(run.room_K for run in inputs.runs)


def places_of(inputs: Inputs, shared: int, nodes: int) -> IntArray:
    """Where in the vector of parameters the hats of such rooms stand.

    Parameters
    ----------
    shared
        Parameters that all runs share.
    nodes
        Of the network: as many starts come before the hats of each run.
    """
    hats = int(inputs.room.shape[-1])
    first = [shared + r * (nodes + hats) + nodes for r, run in enumerate(inputs.runs) if run.room_K > 0.0]
    return np.array([place + b for place in first for b in range(hats)], dtype=np.int64)


def share_level(precision: FloatArray, places: IntArray, deviation: float) -> None:
    """Add to a prior, in place, what all rooms are off by together.

    Parameters
    ----------
    precision
        Shape (P, P).
    places
        Of the rooms.
    deviation
        W, K.
    """
    block = np.ix_(places, places)
    own = precision[block].sum(axis=1)
    precision[block] -= np.outer(own, own) / (deviation**-2 + own.sum())


def level_of(
    precision: FloatArray, places: IntArray, deviation: float, vector: FloatArray, covariance: FloatArray
) -> tuple[float, float]:
    """Give what the rooms are off by together, and its standard deviation, K.

    Parameters
    ----------
    precision
        The prior's, shape (P, P), with the common level in it.
    places, deviation
        As above.
    vector, covariance
        Parameters and their covariance, shapes (P,) and (P, P).
    """
    along = precision[np.ix_(places, places)].sum(axis=1)
    level = deviation**2 * float(along @ vector[places])
    # Var c = E Var(c | h) + Var E(c | h); 1^T Q 1 = 1 / (W^2 + 1/s), and Var(c | h) = 1 / (1/W^2 + s).
    inner = deviation**2 - deviation**4 * float(along.sum())
    return level, float(np.sqrt(inner + deviation**4 * float(along @ covariance[np.ix_(places, places)] @ along)))
