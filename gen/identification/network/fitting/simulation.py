"""The network along all runs: exact over each bin, with exact derivatives by all parameters.

With z = C^(1/2) T the network is z' = A z + C^(-1/2) (g T_ambient + P), A symmetric, so A = V diag(l) V^T and over a
bin of length h the solution is z -> e^(Ah) z + phi(A) q, phi(l) = (e^(lh) - 1) / l. A change dA adds
V ((V^T dA V) o D) V^T, D the divided differences of e^(lh) (Daleckii and Krein; Higham, Functions of Matrices, 3.3).
A path changes A by a matrix of rank one, so its derivative is a heat that flows from one node to the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gen.identification.network.fitting.bins import FloatArray, IntArray
from gen.identification.network.fitting.inputs import Inputs, Levels
from gen.identification.network.fitting.natural import Natural
from gen.identification.network.fitting.physics import Physical, Shape

Slopes = NDArray[np.float32]

ROUNDS = 4
"""Of what natural convection takes within a bin: each leaves a quarter of the error of the one before, or less."""


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


def steps_of(structure: Shape, levels: Levels, found: Physical) -> Steps:
    """Discretise the network at each distinct input."""
    incidence, root = structure.incidence, np.sqrt(found.capacity)
    scaled = incidence / root
    matrix = -(scaled.T * found.conductance[:, None, :]) @ scaled
    if found.growth is not None:
        nodes = np.arange(structure.nodes)
        matrix[:, nodes, nodes] += found.growth / found.capacity
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


def simulate(
    inputs: Inputs, steps: Steps, found: Physical, start: FloatArray, room: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Temperatures at the beginning and at the end of each bin.

    Parameters
    ----------
    start
        Shape (R, n), degC.
    room
        Added to the ambient, shape (N,), K.

    Returns
    -------
    before, after
        Shape (N, n), degC.
    """
    level = inputs.level
    # The gain's rows times what comes from outside and from the heats, for each distinct input once.
    from_ambient = np.einsum("lij,lj->li", steps.gain, steps.outside)
    from_heat = np.einsum("lij,lj->li", steps.gain, found.heat)
    driven = (from_ambient[level] * (inputs.ambient + room)[:, None] + from_heat[level])[:, :, None]
    before, after = np.empty_like(driven), np.empty_like(driven)
    matrix = steps.matrix[level]
    further = _Further(steps, found.natural, level, inputs.ambient + room) if found.natural is not None else None
    current = start[inputs.order][:, :, None]
    for low, high in pairwise(inputs.first.tolist()):
        current = current[: high - low]
        before[low:high] = current
        current = np.matmul(matrix[low:high], current, out=after[low:high])
        current += driven[low:high]
        if further is not None:
            current = after[low:high] = further.added(before[low:high, :, 0], current[..., 0], low, high)[:, :, None]
    return before[..., 0], after[..., 0]


class _Further:
    """What natural convection takes within each bin beside conductances that do not depend on temperature.

    It is a heat that goes with the mean of the temperatures at both ends of the bin.
    """

    def __init__(self, steps: Steps, natural: Natural, level: IntArray, ambient: FloatArray) -> None:
        self._natural, self._ambient = natural, ambient
        self._gain, self._conductance = steps.gain[level], natural.conductance[level]

    def heat(self, before: FloatArray, after: FloatArray, rows: slice) -> FloatArray:
        """At each node, shape (rows, n), W."""
        difference = 0.5 * (before + after) - self._ambient[rows, None]
        return np.asarray(-self._conductance[rows] * self._natural.excess(difference))

    def added(self, before: FloatArray, without: FloatArray, low: int, high: int) -> FloatArray:
        """Temperatures at the end of bins from those without it, shape (rows, n), degC."""
        rows, after = slice(low, high), without
        for _ in range(ROUNDS):
            after = without + np.einsum("rij,rj->ri", self._gain[rows], self.heat(before, after, rows))
        return after

    def answered(
        self, structure: Shape, inputs: Inputs, path: tuple[FloatArray, FloatArray], matrix: Slopes, sources: Slopes
    ) -> tuple[Slopes, Slopes]:
        """Give each bin's step and what each parameter adds in it, with what that changes of this heat."""
        before, after = path
        difference = 0.5 * (before + after) - self._ambient[:, None]
        by_warmth = -self._gain * (self._conductance * self._natural.slope(difference))[:, None, :]
        unit = (-self._gain * self._natural.excess(difference)[:, None, :]).astype(np.float32)
        self._natural.by_conductance.add_to(sources, unit, inputs.level)
        if inputs.room.shape[-1]:
            reach = by_warmth.sum(axis=-1)[..., None]
            sources[..., structure.size + structure.nodes :] -= reach * inputs.room[:, None, :]
        # The heat goes with both ends of the bin, so the end stands on both sides.
        half = 0.5 * by_warmth
        inverse = np.linalg.inv(np.eye(structure.nodes) - half).astype(np.float32)
        return inverse @ (matrix + half.astype(np.float32)), inverse @ sources


def sensitivities(
    structure: Shape,
    inputs: Inputs,
    found: Physical,
    steps: Steps,
    path: tuple[FloatArray, FloatArray],
    room: FloatArray,
) -> tuple[Slopes, Slopes]:
    """Derivatives of the sensed nodes' temperatures at the readings' time.

    Parameters
    ----------
    path
        Temperatures at the beginning and at the end of each bin, shape (N, n) each, degC.

    Returns
    -------
    slopes
        Shape (N, S, p): by the parameters that all runs share, in the structure's order, then by each node's start and
        by the hats of the room. Single precision: they only point the way.
    changes
        The same of the changes in each bin of what lagging sensors read, shape (N, lagging, p), 1/s.
    """
    further = _Further(steps, found.natural, inputs.level, inputs.ambient + room) if found.natural is not None else None
    more = None if further is None else further.heat(*path, slice(None))
    sources = sources_of(structure, inputs, found, steps, path[0], room, more)
    nodes, sensors = structure.nodes, structure.sensors
    made = np.empty((inputs.level.size, sensors, sources.shape[-1]), dtype=np.float32)
    current = np.zeros((len(inputs.runs), nodes, sources.shape[-1]), dtype=np.float32)
    current[:, :, structure.size : structure.size + nodes] = np.eye(nodes)
    matrix = steps.matrix.astype(np.float32)[inputs.level]
    if further is not None:
        matrix, sources = further.answered(structure, inputs, path, matrix, sources)
    lagging = list(structure.lagging)
    changes = np.empty((inputs.level.size, len(lagging), sources.shape[-1]), dtype=np.float32)
    late = inputs.share.astype(np.float32)[:, :, None]
    early = np.float32(1.0) - late
    for low, high in pairwise(inputs.first.tolist()):
        shown = made[low:high]
        earlier = current[: high - low]
        np.multiply(early[low:high], earlier[:, :sensors], out=shown)
        current = np.matmul(matrix[low:high], earlier)
        current += sources[low:high]
        shown += late[low:high] * current[:, :sensors]
        if lagging:
            changes[low:high] = current[:, lagging] - earlier[:, lagging]
    if lagging:
        changes /= inputs.width.astype(np.float32)[:, None, None]
    return made, changes


def sources_of(
    structure: Shape,
    inputs: Inputs,
    found: Physical,
    steps: Steps,
    before: FloatArray,
    room: FloatArray,
    further: FloatArray | None = None,
) -> Slopes:
    """Give what each parameter adds to the temperatures within one bin, shape (N, n, p).

    It is affine in `before`, and in `further`: heat at each node that does not go with the input, shape (N, n), W.
    """
    level = inputs.level
    nodes = structure.nodes
    root = np.sqrt(found.capacity)
    ambient = inputs.ambient + room
    turned = np.swapaxes(steps.vectors, 1, 2)
    outside = steps.outside[level] * ambient[:, None] + found.heat[level]
    if further is not None:
        outside = outside + further
    own = turned[level]
    modal = (own @ (before * root)[..., None])[..., 0]
    forced = (own @ (outside / root)[..., None])[..., 0]
    rate = steps.rates[level] * modal + forced
    single = np.float32
    first, second = (part.astype(single)[level] for part in _divided(steps, inputs.levels.width))
    by_path = ((structure.incidence / root) @ steps.vectors).astype(single)[level]
    by_node = steps.vectors.astype(single)[level]
    phi = steps.phi.astype(single)[level]
    state, drive, change = (part.astype(single)[:, None, :] for part in (modal, forced, rate))
    # A path takes heat where it is warmer: -v (D (v z) + D' (v q)), and from the ambient gives back v phi T_ambient.
    inner = (by_path * state) @ first
    inner += (by_path * drive) @ second
    back = structure.outer.astype(single)[:, None] * (phi * ambient.astype(single)[:, None])[:, None, :]
    flow = by_path * (back - inner)
    stored = -by_node * ((by_node * change) @ first)
    warmed = by_node * phi[:, None, :] / root.astype(single)[:, None]
    size = structure.size
    sources = np.zeros((level.size, nodes, size + nodes + inputs.room.shape[-1]), dtype=single)
    to_nodes = np.swapaxes(turned, 1, 2).astype(single)[level] / root.astype(single)[:, None]

    def temperatures(columns: Slopes | FloatArray) -> Slopes:
        return np.asarray(to_nodes @ np.swapaxes(columns, 1, 2), dtype=single)

    sources[..., :nodes] = temperatures(stored)
    found.by_path.add_to(sources, temperatures(flow), level)
    found.by_heat.add_to(sources, temperatures(warmed), level)
    if found.by_growth is not None:
        # Heat by temperature is a path to 0 degC that gives instead of taking.
        warmth = (by_node * state) @ first
        warmth += (by_node * drive) @ second
        found.by_growth.add_to(sources, temperatures(by_node / root.astype(single)[:, None] ** 2 * warmth), level)
    if inputs.room.shape[-1]:
        reach = np.einsum("lij,lj->li", steps.gain, steps.outside)[level]
        sources[..., size + nodes :] = reach[..., None] * inputs.room[:, None, :]
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
    series = h * h * (0.5 + x * (1.0 / 3.0 + x * (1.0 / 8.0 + x / 30.0)))
    return np.where(np.abs(x) < 1e-3, series, by_product)
