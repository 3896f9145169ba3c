"""Where parts without a sensor probably are when a motor is switched on: what its likely pasts let expect.

A motor that is switched on has run before, at some speed and for some while, and has rested since. Along all such
pasts a hidden node's rise h goes with those of the sensed nodes, s, as E[h s'] E[s s']^-1: the linear estimate of
least mean square error (Kay, Fundamentals of Statistical Signal Processing, vol. 1, 12.3). A heavy part that cools
slowly is warmer than what surrounds it, and a mass that was never reached is colder; where it would rest between its
neighbours (:attr:`gen.model.network.Network.rest_of_hidden`) is neither. Weights below 0 would let a warmer motor begin
colder inside, and nothing of what is proven from ordered starts would hold: the best weights that are not are found.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import nnls

from gen.arrays import FloatArray
from gen.model.network import Network

SPEEDS = 5
SLOWEST = 0.2
"""Of the full scale, that it ran at, where it was identified so slowly."""
RAN, RESTED = np.geomspace(0.02, 2.0, 5), np.geomspace(0.004, 1.5, 8)
"""For how long it ran and has rested, over the slowest time constant at rest: minutes to hours, of a motor of two."""
LONGEST_S = 14_400.0
"""That a time constant counts for: a wall that takes a day is as its room."""
READING_K, ROOM_K = 0.4, 0.5
"""What single readings, and the room's together, are off by (standard deviations)."""
ROOM_DEGC = 25.0
"""From which rises count, where heat goes with temperature."""
MOST = 7.9
"""Sum of a node's weights: a file holds less than 8."""


class Dynamics(NamedTuple):
    """Rises over the ambient at one speed: dx/dt = M x + f.

    Attributes
    ----------
    matrix
        1/s, shape (n, n).
    heating
        K/s, shape (n,).
    """

    matrix: FloatArray
    heating: FloatArray


def start_weights(resting: Dynamics, running: Sequence[Dynamics], sensed: Sequence[int]) -> FloatArray | None:
    """Give what share of each sensed node's rise each hidden node has when it is switched on.

    Parameters
    ----------
    resting
        At rest, from where everything is as warm as the ambient in the end.
    running
        At speeds, each of which is as likely as the others; one that warms without end tells nothing.
    sensed
        Which nodes have a sensor.

    Returns
    -------
    FloatArray or None
        Shape (hidden, sensed), the nodes in their order, none below 0; None where nothing heats it.
    """
    count = resting.heating.size
    hidden = [node for node in range(count) if node not in set(sensed)]
    rates = np.linalg.eigvals(resting.matrix).real
    if not hidden or rates.max() >= 0.0:
        return None
    slowest_s = min(-1.0 / float(rates.max()), LONGEST_S)
    ran = [_warmed(one, slowest_s * RAN) for one in running if np.linalg.eigvals(one.matrix).real.max() < 0.0]
    if not ran:
        return None
    rises = np.concatenate([warm @ step.T for warm in ran for step in _steps(resting.matrix, slowest_s * RESTED)])
    second = rises.T @ rises / len(rises)
    of_sensed = second[np.ix_(sensed, sensed)]
    if float(np.trace(of_sensed)) < READING_K**2:
        return None
    factor = np.linalg.cholesky(of_sensed + READING_K**2 * np.eye(len(sensed)) + ROOM_K**2)
    # |factor' w - factor^-1 E[h s']|^2 is w' E[s s'] w - 2 w' E[h s'], but for what no weight changes.
    each = [nnls(factor.T, np.linalg.solve(factor, second[node, list(sensed)]))[0] for node in hidden]
    made = np.array(each)
    return np.asarray(made * np.minimum(1.0, MOST / np.maximum(made.sum(axis=1), 1e-9))[:, None])


def speeds_of_pasts(slowest: float, fastest: float) -> FloatArray:
    """Give the speeds that it ran at, where it was identified from one to another, in any unit, shape (SPEEDS,)."""
    return np.linspace(max(slowest, SLOWEST * fastest), fastest, SPEEDS)


def network_start_weights(network: Network, slowest: int, fastest: int) -> FloatArray | None:
    """Give the same of a file's network, channels neutral, at |PWM| from one to another."""
    pwm = np.rint(np.concatenate([[0.0], speeds_of_pasts(slowest, fastest)])).astype(np.int64)
    matrices, to_ambient, heat = network.matrices(pwm)
    # M x + a T + f of x = r + T: what rises over the room heats as it does in that room.
    in_room = heat + ROOM_DEGC * (matrices.sum(axis=2) + to_ambient)
    each = [Dynamics(m, f) for m, f in zip(matrices, in_room, strict=True)]
    resting = Dynamics(each[0].matrix, np.zeros(len(network.nodes)))
    return start_weights(resting, each[1:], [network.index(node.name) for node in network.sensed])


def _warmed(of: Dynamics, times_s: FloatArray) -> FloatArray:
    """Rises after some times from cold, shape (T, n), K."""
    settled = np.linalg.solve(of.matrix, -of.heating)
    return np.array([settled - step @ settled for step in _steps(of.matrix, times_s)])


def _steps(matrix: FloatArray, times_s: FloatArray) -> list[FloatArray]:
    """exp(M t) at some times."""
    return [expm(matrix * time) for time in times_s]
