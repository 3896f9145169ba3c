"""Where hidden nodes start: at a multiple of the rise at which they would rest between the sensed ones and the ambient.

That is what a coefficient file says of them and what the board does, which sees no more than what its sensors read when
it is switched on. A fit in which hidden nodes start anywhere finds networks that the board cannot follow: a wall that
is 12 K colder than its room fits one run as well as a wall that is not.

At rest, no heat acting, what flows into each hidden node is 0: of K, the conductances as a Laplacian, K_hh t_h =
-K_hs t_s, t over the ambient. A path (i, j) of conductance g carries g d, d the difference at its ends, so
dt_h / dg = -K_hh^-1 b_h d, b its column of the incidence matrix. A node starts at e^f t_h.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.inputs import held
from gen.identification.network.fitting.physics import Begun, Physical, Shape

AT_REST = held(np.zeros(1), 1)
LEAST_W_PER_K = 1e-12
"""Of a hidden node, lest one that is tied to nothing divide by zero: it starts at the ambient."""


def begun(shape: Shape, factors: IntArray, vector: FloatArray, sensed: FloatArray, ambient: FloatArray) -> Begun:
    """Give the starts of hidden nodes.

    Parameters
    ----------
    shape, vector
        The network, and its parameters, shape (P,).
    factors
        Which of them are f, shape (h,).
    sensed
        Where the sensed nodes start, shape (R, S), degC.
    ambient
        Shape (R,), degC.
    """
    sensors, physics = shape.sensors, shape.physical(AT_REST, vector)
    rise = sensed - ambient[:, None]
    inverse, share = _balance(shape, physics)
    at_rest = rise @ share.T
    difference = np.hstack([rise, at_rest]) @ shape.incidence.T
    by_conductance = -(inverse @ shape.incidence[:, sensors:].T)[None] * difference[:, None, :]
    by_shared = np.zeros((*at_rest.shape, shape.size))
    physics.by_path.add_to(by_shared, by_conductance, np.zeros(ambient.size, dtype=np.int64))
    factor = np.exp(vector[factors])
    by_shared *= factor[:, None]
    by_shared[:, np.arange(factors.size), factors] += factor * at_rest
    by_sensed = np.broadcast_to(factor[:, None] * share, (ambient.size, *share.shape))
    return Begun(ambient[:, None] + factor * at_rest, by_shared, by_sensed, 1.0 - by_sensed.sum(axis=-1))


def begun_from(weights: FloatArray, size: int, sensed: FloatArray, ambient: FloatArray) -> Begun:
    """Give the starts of hidden nodes whose rises have known shares of the sensed ones', shape (h, S).

    Parameters
    ----------
    weights, size
        The shares, and how many parameters all runs share.
    sensed, ambient
        As `begun` has them.
    """
    runs = ambient.size
    by_sensed = np.broadcast_to(weights, (runs, *weights.shape))
    temperature = ambient[:, None] + (sensed - ambient[:, None]) @ weights.T
    return Begun(temperature, np.zeros((runs, len(weights), size)), by_sensed, 1.0 - by_sensed.sum(axis=-1))


def balance(shape: Shape, vector: FloatArray) -> FloatArray:
    """Give the share of each sensed node's rise that a hidden one rests at, shape (h, S)."""
    return _balance(shape, shape.physical(AT_REST, vector))[1]


def _balance(shape: Shape, physics: Physical) -> tuple[FloatArray, FloatArray]:
    """Invert K_hh, and give the share of each sensed node's rise that a hidden one rests at, shapes (h, h), (h, S)."""
    incidence, sensors = shape.incidence, shape.sensors
    laplacian = (incidence.T * physics.conductance[0]) @ incidence
    inner = laplacian[sensors:, sensors:] + LEAST_W_PER_K * np.eye(shape.nodes - sensors)
    inverse = np.linalg.inv(inner)
    return inverse, -inverse @ laplacian[sensors:, :sensors]
