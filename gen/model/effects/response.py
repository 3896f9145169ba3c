"""How a component of higher order answers to heat: through all of its own poles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.model.dynamics import Component
from gen.model.effects.base import Lanes


@dataclass(frozen=True)
class Response:
    """Steps of ``A(d/dt) E = A'(0) q``, whose steady E is q over the component's own rate; R runs, order n.

    Parameters
    ----------
    transition
        Shape (K, R, n, n), for the state (E, E', ..).
    forced
        What a q held over the step adds, shape (K, R, n).
    """

    transition: FloatArray
    forced: FloatArray


def response(component: Component, counts: IntArray, step: FloatArray) -> Response:
    """Make the steps.

    Parameters
    ----------
    component
        Of any order.
    counts, step
        |PWM| and length (s) of each step, shape (K, R).
    """
    from scipy.linalg import expm  # slow to import: reading and checking a file does without

    n = component.order
    pairs, index = np.unique(np.stack([counts.ravel().astype(np.float64), step.ravel()]), axis=1, return_inverse=True)
    known = pairs[0].astype(np.int64)
    a, b = component.state_matrices(known)
    b[:, -1] = component.denominator(known)[:, -2]
    augmented = np.zeros((known.size, n + 1, n + 1))
    augmented[:, :n, :n] = a * pairs[1][:, None, None]
    augmented[:, :n, n] = b * pairs[1][:, None]
    solved = np.asarray(expm(augmented))[index.ravel()].reshape(*counts.shape, n + 1, n + 1)
    return Response(np.ascontiguousarray(solved[..., :n, :n]), np.ascontiguousarray(solved[..., :n, n]))


def answer(own: Response, heat: Lanes, share: Lanes, base: FloatArray, start: Lanes) -> FloatArray:
    """E for q = heat + share (base + E).

    Parameters
    ----------
    own
        The component's steps.
    heat, share
        K/s and 1/s, shape (K, .., lanes, R) or numbers.
    base
        Rise without E, means of the steps, as `heat`.
    start
        E at the start.

    Returns
    -------
    FloatArray
        At the ends of the steps, shape (K + 1, .., lanes, R).
    """
    length, runs, n = own.forced.shape
    drive = np.asarray(heat + share * base)
    shape = np.broadcast_shapes(drive.shape[1:], np.shape(share)[1:], np.shape(start))
    drive = np.broadcast_to(drive, (length, *shape)).reshape(length, -1, runs)
    back = np.broadcast_to(share, (length, *shape)).reshape(length, -1, runs)
    feeds = bool(np.any(back != 0.0))
    lanes = drive.shape[1]
    state = np.zeros((runs, n, lanes))
    state[:, 0] = np.broadcast_to(start, shape).reshape(lanes, runs).T
    out = np.empty((length + 1, runs, lanes))
    out[0] = state[:, 0]
    drive, back = np.moveaxis(drive, 1, 2), np.moveaxis(back, 1, 2)  # (K, R, lanes)
    for k in range(length):
        free = own.transition[k] @ state
        pushed = own.forced[k][:, :, None]
        q = drive[k]
        if feeds:
            # the mean of E over the step, from a first guess of its end
            guess = free[:, 0] + pushed[:, 0] * (q + back[k] * state[:, 0])
            q = q + back[k] * (0.5 * (state[:, 0] + guess))
        state = free + pushed * q[:, None, :]
        out[k + 1] = state[:, 0]
    return np.moveaxis(out, 1, 2).reshape(length + 1, *shape)
