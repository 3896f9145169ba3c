"""The network along all runs: exact over each bin, with exact derivatives by all parameters.

With z = C^(1/2) T the network is z' = A z + C^(-1/2) (g T_ambient + P), A symmetric, so A = V diag(l) V^T and over a
bin of length h the solution is z -> e^(Ah) z + phi(A) q, phi(l) = (e^(lh) - 1) / l. A change dA adds
V ((V^T dA V) o D) V^T, D the divided differences of e^(lh) (Daleckii and Krein; Higham, Functions of Matrices, 3.3).
A path changes A by a matrix of rank one, so its derivative is a heat that flows from one node to the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Inputs, Levels
from gen.identification.network.structure import SLOW, Structure

Slopes = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Physical:
    """What the parameters mean at each distinct input.

    Attributes
    ----------
    capacity
        Shape (n,), J/K.
    conductance, by_term
        Shape (L, Q), W/K, and derivatives by the free terms, shape (L, F).
    heat, by_heat_term
        Shape (L, n), W, and derivatives, shape (L, heated, 3).
    """

    capacity: FloatArray
    conductance: FloatArray
    by_term: FloatArray
    heat: FloatArray
    by_heat_term: FloatArray


@dataclass(frozen=True, eq=False)
class Steps:
    """The exact step of each distinct input.

    Attributes
    ----------
    decay, phi
        Of each mode, shape (L, n).
    vectors
        Modes as columns, in z, shape (L, n, n).
    rates
        Shape (L, n), 1/s, negative.
    matrix
        T -> T, shape (L, n, n).
    gain
        Heat in W -> T, shape (L, n, n).
    outside
        Conductance of each node to the ambient, shape (L, n), W/K.
    """

    decay: FloatArray
    phi: FloatArray
    vectors: FloatArray
    rates: FloatArray
    matrix: FloatArray
    gain: FloatArray
    outside: FloatArray


def physical(structure: Structure, levels: Levels, vector: FloatArray) -> Physical:
    """Evaluate capacities, conductances and heats at each distinct input."""
    terms = structure.path_terms(vector)
    ratio, constant, forced, power = np.exp(terms).T
    rest, turn = levels.rest[:, None], 1.0 - levels.rest[:, None]
    speed = np.maximum(levels.speed[:, None], 1e-9)
    slow = forced * SLOW**power
    still, moved = rest * ratio, turn * forced * speed**power
    conductance = still * (constant + slow) + turn * constant + moved
    by_power = (still * slow * np.log(SLOW) + moved * np.log(speed)) * power
    by_term = [still * (constant + slow), (still + turn) * constant, still * slow + moved, by_power]
    path, term = structure.free
    by_free = np.stack(by_term, axis=-1)[:, path, term]
    base = turn[:, :, None] * heat_basis(levels.speed, levels.square)[:, None, :]
    by_heat = base * np.exp(vector[structure.heats])
    heat = np.zeros((levels.count, structure.nodes))
    heat[:, list(structure.heated)] = by_heat.sum(axis=-1)
    return Physical(np.exp(vector[structure.capacities]), conductance, by_free, heat, by_heat)


def heat_basis(speed: FloatArray, square: FloatArray) -> FloatArray:
    """Give w, w^2 and w (1 - w), shape (..., 3)."""
    return np.stack([speed, square, np.maximum(speed - square, 0.0)], axis=-1)


def steps_of(structure: Structure, levels: Levels, found: Physical) -> Steps:
    """Discretise the network at each distinct input."""
    incidence, root = structure.incidence, np.sqrt(found.capacity)
    scaled = incidence / root
    matrix = -np.einsum("lq,qi,qj->lij", found.conductance, scaled, scaled, optimize=True)
    rates, vectors = np.linalg.eigh(matrix)
    rates = np.minimum(rates, -1e-12)
    exponent = rates * levels.width[:, None]
    decay = np.exp(exponent)
    phi = np.expm1(exponent) / rates
    turned = np.swapaxes(vectors, 1, 2)
    step = (vectors * decay[:, None, :]) @ turned
    gain = (vectors * phi[:, None, :]) @ turned
    outside = found.conductance @ (structure.outer[:, None] * incidence)
    return Steps(
        decay=decay,
        phi=phi,
        vectors=vectors,
        rates=rates,
        matrix=step * (root / root[:, None]),
        gain=gain / (root * root[:, None]),
        outside=outside,
    )


def simulate(inputs: Inputs, steps: Steps, found: Physical, start: FloatArray, room: FloatArray) -> FloatArray:
    """Temperatures at the ends of the bins.

    Parameters
    ----------
    start
        Shape (R, n), degC.
    room
        Added to the ambient, shape (R, T), K.

    Returns
    -------
    array
        Shape (R, T + 1, n), degC.
    """
    level = inputs.level
    ambient = inputs.ambient + room
    # The gain's rows times what comes from outside and from the heats, for each distinct input once.
    from_ambient = np.einsum("lij,lj->li", steps.gain, steps.outside)
    from_heat = np.einsum("lij,lj->li", steps.gain, found.heat)
    driven = from_ambient[level] * ambient[..., None] + from_heat[level]
    runs, bins = level.shape
    states = np.empty((runs, bins + 1, start.shape[1]))
    states[:, 0] = start
    matrix = steps.matrix[level.T]
    driven = np.ascontiguousarray(np.swapaxes(driven, 0, 1))[..., None]
    current = start[:, :, None]
    for k in range(bins):
        current = matrix[k] @ current
        current += driven[k]
        states[:, k + 1] = current[..., 0]
    return states


def sensitivities(
    structure: Structure,
    inputs: Inputs,
    found: Physical,
    steps: Steps,
    states: FloatArray,
    room: FloatArray,
) -> Slopes:
    """Derivatives of the sensed temperatures at the ends of the bins.

    Returns
    -------
    array
        Shape (T + 1, R, S, p): by capacities, free path terms, heat terms (in the structure's order, without the
        offsets), each node's start and the hats of the room. Single precision: they point the way only.
    """
    runs, bins = inputs.level.shape
    sources = _sources(structure, inputs, found, steps, states, room)
    nodes, free, sensors = structure.nodes, sources.shape[-1], len(structure.sensed)
    shared = structure.size - sensors
    made = np.empty((bins + 1, runs, sensors, free), dtype=np.float32)
    current = np.zeros((runs, nodes, free), dtype=np.float32)
    current[:, :, shared : shared + nodes] = np.eye(nodes)
    made[0] = current[:, :sensors]
    matrix = steps.matrix.astype(np.float32)[inputs.level.T]
    for k in range(bins):
        current = np.matmul(matrix[k], current)
        current += sources[k]
        made[k + 1] = current[:, :sensors]
    return made


def _sources(
    structure: Structure, inputs: Inputs, found: Physical, steps: Steps, states: FloatArray, room: FloatArray
) -> Slopes:
    """What each parameter adds to the temperatures within one bin, shape (T, R, n, p)."""
    level = inputs.level.T
    bins, runs = level.shape
    nodes = structure.nodes
    root = np.sqrt(found.capacity)
    ambient = (inputs.ambient + room).T
    turned = np.swapaxes(steps.vectors, 1, 2)[level]
    outside = steps.outside[level] * ambient[..., None] + found.heat[level]
    before = np.swapaxes(states[:, :-1], 0, 1)
    modal = (turned @ (before * root)[..., None])[..., 0]
    forced = (turned @ (outside / root)[..., None])[..., 0]
    rate = steps.rates[level] * modal + forced
    single = np.float32
    first, second = (part.astype(single)[level] for part in _divided(steps, inputs.levels.width))
    by_path = ((structure.incidence / root) @ steps.vectors).astype(single)[level]
    by_node = steps.vectors.astype(single)[level]
    phi = steps.phi.astype(single)[level]
    # The ambient is taken out of the modes: at its own level nothing flows to it.
    modal, forced, rate = modal.astype(single), forced.astype(single), rate.astype(single)
    # A path takes heat where it is warmer: -v (D (v z) + D' (v q)), and from the ambient gives back v phi T_ambient.
    inner = (by_path * modal[:, :, None, :]) @ first
    inner += (by_path * forced[:, :, None, :]) @ second
    back = structure.outer.astype(single)[:, None] * (phi * ambient.astype(single)[..., None])[:, :, None, :]
    flow = by_path * (back - inner)
    stored = -by_node * ((by_node * rate[:, :, None, :]) @ first)
    heated = list(structure.heated)
    warmed = by_node[:, :, heated] * phi[:, :, None, :] / root.astype(single)[heated][:, None]
    count = structure.size - len(structure.sensed)
    sources = np.zeros((bins, runs, nodes, count + nodes + inputs.room.shape[-1]), dtype=single)
    to_nodes = np.swapaxes(turned, 2, 3).astype(single) / root.astype(single)[:, None]

    def temperatures(columns: Slopes | FloatArray) -> Slopes:
        return np.asarray(to_nodes @ np.swapaxes(columns, 2, 3), dtype=single)

    sources[..., :nodes] = temperatures(stored)
    path, _ = structure.free
    last = nodes + path.size
    by_term = found.by_term.astype(single)[level]
    np.multiply(temperatures(flow)[..., path], by_term[:, :, None], out=sources[..., nodes:last])
    if heated:
        by_heat = found.by_heat_term.astype(single)[level]
        each = temperatures(warmed)[..., None] * by_heat[:, :, None]
        sources[..., last:count] = each.reshape(bins, runs, nodes, -1)
    if inputs.room.shape[-1]:
        reach = np.einsum("lij,lj->li", steps.gain, steps.outside)[level]
        sources[..., count + nodes :] = reach[..., None] * np.swapaxes(inputs.room, 0, 1)[:, :, None, :]
    return sources


def _divided(steps: Steps, width: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Divided differences of e^(lh) and of phi over all pairs of rates, shape (L, n, n) each."""
    rates, h = steps.rates, width[:, None, None]
    a, b = rates[:, :, None], rates[:, None, :]
    gap = (a - b) * h
    near = np.abs(gap) < 1e-6
    safe = np.where(near, 1.0, a - b)
    middle = 0.5 * (a + b)
    # e^(ah) - e^(bh) = 2 e^(mh) sinh((a-b)h/2): no cancellation, and exact to second order where a = b.
    exponential = np.exp(middle * h)
    half = np.minimum(np.abs(0.5 * gap), 300.0)
    direct = (steps.decay[:, :, None] - steps.decay[:, None, :]) / safe
    smooth = exponential * h * np.where(half < 1e-3, 1.0 + half**2 / 6.0, np.sinh(half) / np.maximum(half, 1e-3))
    first = np.where(half < 1.0, smooth, direct)
    # phi(a) = int_0^h e^(at) dt; its divided difference is (first - phi(b)) / a.
    direct_phi = (steps.phi[:, :, None] - steps.phi[:, None, :]) / safe
    by_product = (first - steps.phi[:, None, :]) / a
    return first, np.where(half < 0.1, _confluent(middle, h, by_product), direct_phi)


def _confluent(rate: FloatArray, h: FloatArray, by_product: FloatArray) -> FloatArray:
    """phi'(l) = (h e^(lh) - phi(l)) / l, by its series where lh is small."""
    x = rate * h
    series = h**2 * (0.5 + x / 3.0 + x**2 / 8.0 + x**3 / 30.0)
    return np.where(np.abs(x) < 1e-3, series, by_product)
