"""Exact simulation of K/A(s) for a PWM that is held in segments, for many parameter sets at once.

Within a segment the deviation z from the steady rise obeys A(d/dt) z = 0. In Newton's form over the poles p1 .. pn,

    z(t) = sum over k of d_k * exp[p1 .. pk](t),

with divided differences of p -> exp(p t) and d_k = (D - p1) .. (D - p[k-1]) z(0), D = d/dt. That needs no
eigenvectors, holds for real and complex poles, and gives the derivatives at the segment's end, which pass over to the
next segment: rise and derivatives are continuous when PWM changes, as in `gen.model.exact`.
"""

from __future__ import annotations

import numpy as np

from gen.loop.identify.structure import ComplexArray, FloatArray, PoleArray, separated


def divided_differences(poles: PoleArray, time: FloatArray) -> PoleArray:
    """Give exp[p1 .. pk](t) for k = 1 .. n.

    Parameters
    ----------
    poles
        Shape (B, n), rad/s, no two equal.
    time
        Shape (m,), s.

    Returns
    -------
    array
        Shape (B, n, m), in s^(k-1).
    """
    table = np.exp(poles[:, :, None] * time)
    result = np.empty_like(table)
    result[:, 0] = table[:, 0]
    for k in range(1, poles.shape[1]):
        gap = poles[:, k:] - poles[:, :-k]
        table = (table[:, 1:] - table[:, :-1]) / gap[:, :, None]
        result[:, k] = table[:, 0]
    return result


def simulate(
    poles: PoleArray,
    steady: FloatArray,
    start: FloatArray,
    length: FloatArray,
    offsets: list[FloatArray],
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
    offsets
        Per segment the times since its beginning at which the rise is wanted, s.

    Returns
    -------
    array
        Rise at all wanted times in order, shape (B, M), K.
    """
    apart = separated(poles)
    state = start.astype(apart.dtype)
    parts = []
    for j, wanted in enumerate(offsets):
        p = apart[:, j]
        basis = divided_differences(p, np.append(wanted, length[j]))
        deviation = state.copy()
        deviation[:, 0] -= steady[:, j]
        weights = newton_weights(p, deviation)
        if wanted.size:
            parts.append(np.real(np.einsum("bk,bkm->bm", weights, basis[:, :, :-1])) + steady[:, j, None])
        state = _derivatives(p, weights, basis[:, :, -1])
        state[:, 0] += steady[:, j]
    return np.concatenate(parts, axis=1) if parts else np.empty((len(start), 0))


def newton_weights(poles: PoleArray, state: PoleArray) -> PoleArray:
    """Give d_k from z and its derivatives, shape (B, n)."""
    rest = state
    weights = np.empty_like(state)
    for k in range(poles.shape[1]):
        weights[:, k] = rest[:, 0]
        rest = rest[:, 1:] - poles[:, k, None] * rest[:, :-1]
    return weights


def _derivatives(poles: PoleArray, weights: PoleArray, basis: PoleArray) -> PoleArray:
    """Rise and derivatives from the basis' values: d/dt exp[p1..pk] = pk exp[p1..pk] + exp[p1..p(k-1)]."""
    state = np.empty_like(weights)
    for k in range(poles.shape[1]):
        state[:, k] = np.sum(weights * basis, axis=1)
        shifted = np.zeros_like(weights)
        shifted[:, :-1] = weights[:, 1:]
        weights = weights * poles + shifted
    return np.real(state).astype(weights.dtype)


def mixed_poles(poles: PoleArray, share: FloatArray) -> ComplexArray:
    """Average systems that take turns faster than any of them reacts: the roots of their mean A.

    Parameters
    ----------
    poles
        Shape (B, L, n), of L levels.
    share
        Share of time of each level, shape (L,), sum 1.

    Returns
    -------
    array
        Shape (B, n).
    """
    count, _, order = poles.shape
    mean = np.zeros((count, order + 1))
    for level in np.flatnonzero(share):
        a = np.ones((count, 1), dtype=np.complex128)
        for k in range(order):
            root = poles[:, level, k, None]
            a = np.pad(a, ((0, 0), (0, 1))) - root * np.pad(a, ((0, 0), (1, 0)))
        mean += share[level] * a.real
    companion = np.zeros((count, order, order))
    companion[:, np.arange(order - 1), np.arange(1, order)] = 1.0
    companion[:, -1, :] = -mean[:, :0:-1]
    # Balance, so that the smallest root keeps its digits.
    rate = np.abs(mean[:, -1]) ** (1.0 / order)
    scale = rate[:, None] ** np.arange(order)
    return np.asarray(np.linalg.eigvals(companion * (scale[:, None, :] / scale[:, :, None])), dtype=np.complex128)
