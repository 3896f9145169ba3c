"""Exact simulation of K/A(s) for a PWM that is held in segments, for many parameter sets at once.

Within a segment the deviation z from the steady rise obeys A(d/dt) z = 0. In Newton's form over the poles p1 .. pn,

    z(t) = sum over k of d_k * exp[p1 .. pk](t),

with divided differences of p -> exp(p t) and d_k = (D - p1) .. (D - p[k-1]) z(0), D = d/dt. That needs no
eigenvectors, holds for real and complex poles, and gives the derivatives at the segment's end, which pass over to the
next segment: rise and derivatives are continuous when PWM changes, as in `gen.model.exact`.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.parts.structure import ComplexArray, PoleArray, separated


def divided_differences(poles: PoleArray, time: FloatArray) -> PoleArray:
    """Give `exp[p1 .. pk](t)` for k = 1 .. n.

    Parameters
    ----------
    poles
        Shape (..., n), rad/s, no two of a set equal.
    time
        Shape (...) or what broadcasts to it, s.

    Returns
    -------
    array
        Shape (n, ...), in s^(k-1).
    """
    # One contiguous array a pole: numpy is slow over a last axis of a few entries.
    each = [np.ascontiguousarray(poles[..., k]) for k in range(poles.shape[-1])]
    table = [np.exp(p * time) for p in each]
    result = [table[0]]
    for k in range(1, len(each)):
        table = [(table[i + 1] - table[i]) / (each[i + k] - each[i]) for i in range(len(each) - k)]
        result.append(table[0])
    return np.stack(result)


def simulate(
    poles: PoleArray,
    steady: FloatArray,
    start: FloatArray,
    length: FloatArray,
    segment: IntArray,
    since: FloatArray,
) -> FloatArray:
    """Solve over consecutive segments.

    Parameters
    ----------
    poles
        Shape (B, S, n): B parameter sets, S segments; rad/s.
    steady
        Steady rise of each segment, shape (B, S), K.
    start
        Rise and its derivatives at the beginning, shape (B, n), K/s^k.
    length
        Duration of each segment, shape (S,), s.
    segment, since
        Where the rise is wanted: the segment, and the time since its beginning, shape (M,), s.

    Returns
    -------
    array
        Rise, shape (B, M), K.
    """
    apart = separated(poles)
    deviation = _deviations(apart, steady, start, length)
    weights = newton_weights(apart, deviation)
    basis = divided_differences(apart[:, segment], since)
    rise = steady[:, segment]
    for k, part in enumerate(basis):
        rise = rise + (weights[..., k][:, segment] * part).real
    return rise


def _deviations(poles: PoleArray, steady: FloatArray, start: FloatArray, length: FloatArray) -> FloatArray:
    """Deviation from the steady rise, and its derivatives, at each segment's beginning, shape (B, S, n)."""
    order = poles.shape[-1]
    basis = np.moveaxis(divided_differences(poles, length), 0, -1)
    # Column i of the transition over a segment is what becomes of the i-th unit vector.
    columns = []
    for i in range(order):
        unit = np.zeros(poles.shape, dtype=poles.dtype)
        unit[..., i] = 1.0
        columns.append(_derivatives(poles, newton_weights(poles, unit), basis))
    transition = np.stack(columns, axis=-1)
    result = np.empty((*steady.shape, order))
    state = start.copy()
    for j in range(steady.shape[1]):
        state[:, 0] -= steady[:, j]
        result[:, j] = state
        state = (transition[:, j] @ state[:, :, None])[:, :, 0]
        state[:, 0] += steady[:, j]
    return result


def newton_weights(poles: PoleArray, state: PoleArray) -> PoleArray:
    """Give d_k from z and its derivatives, shape (..., n)."""
    rest = state.astype(poles.dtype)
    weights = np.empty_like(rest)
    for k in range(poles.shape[-1]):
        weights[..., k] = rest[..., 0]
        rest = rest[..., 1:] - poles[..., k, None] * rest[..., :-1]
    return weights


def _derivatives(poles: PoleArray, weights: PoleArray, basis: PoleArray) -> FloatArray:
    """Rise and derivatives from the basis' values: d/dt exp[p1..pk] = pk exp[p1..pk] + exp[p1..p(k-1)]."""
    state = np.empty(weights.shape)
    for k in range(poles.shape[-1]):
        state[..., k] = np.sum(weights * basis, axis=-1).real
        shifted = np.zeros_like(weights)
        shifted[..., :-1] = weights[..., 1:]
        weights = weights * poles + shifted
    return state


def mixed_poles(poles: PoleArray, share: FloatArray) -> ComplexArray:
    """Average systems that take turns faster than any of them reacts: the roots of their mean A.

    Parameters
    ----------
    poles
        Shape (B, L, n), of L levels.
    share
        Share of time of each level in each of J mixtures, shape (J, L), each sum 1.

    Returns
    -------
    array
        Shape (B, J, n).
    """
    count, levels, order = poles.shape
    a = np.ones((count, levels, 1), dtype=np.complex128)
    for k in range(order):
        longer = np.zeros((count, levels, k + 2), dtype=np.complex128)
        longer[..., :-1] = a
        longer[..., 1:] -= poles[..., k, None] * a
        a = longer
    mean = share @ a.real
    companion = np.zeros((*mean.shape[:2], order, order))
    companion[..., np.arange(order - 1), np.arange(1, order)] = 1.0
    companion[..., -1, :] = -mean[..., :0:-1]
    # Balance, so that the smallest root keeps its digits.
    rate = np.abs(mean[..., -1]) ** (1.0 / order)
    scale = rate[..., None] ** np.arange(order)
    return np.asarray(np.linalg.eigvals(companion * (scale[..., None, :] / scale[..., :, None])), dtype=np.complex128)
