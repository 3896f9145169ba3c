"""The network along all runs: exact over each bin, with exact derivatives by all parameters.

With z = C^(1/2) T the network is z' = A z + C^(-1/2) (g T_ambient + P), A symmetric, so A = V diag(l) V^T and over a
bin of length h the solution is z -> e^(Ah) z + phi(A) q, phi(l) = (e^(lh) - 1) / l. A change dA adds
V ((V^T dA V) o D) V^T, D the divided differences of e^(lh) (Daleckii and Krein; Higham, Functions of Matrices, 3.3).
A path changes A by a matrix of rank one, so its derivative is a heat that flows from one node to the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray, SingleArray
from gen.identification.network.fitting.divided import divided_differences
from gen.identification.network.fitting.inputs import Inputs, Levels
from gen.identification.network.fitting.marching import march, march_in_still_air, march_slopes, units
from gen.identification.network.fitting.natural import Natural
from gen.identification.network.fitting.physics import Physical, Shape


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
    kinds, kind = _kinds(found)
    matrix = -(scaled.T * found.conductance[kinds][:, None, :]) @ scaled
    if found.growth is not None:
        nodes = np.arange(structure.nodes)
        matrix[:, nodes, nodes] += found.growth[kinds] / found.capacity
    rates, vectors = np.linalg.eigh(matrix)
    rates, vectors = np.minimum(rates, -1e-12)[kind], vectors[kind]
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


def _kinds(found: Physical) -> tuple[IntArray, IntArray]:
    """One place of each kind of network among the inputs, shape (K,), and which kind each is of, shape (L,).

    Inputs differ by the lengths of bins and by heats as well, which modes do not depend on.
    """
    whole = found.conductance if found.growth is None else np.hstack([found.conductance, found.growth])
    rows = np.ascontiguousarray(whole).view(np.dtype((np.void, whole.itemsize * whole.shape[1]))).ravel()
    _, kinds, kind = np.unique(rows, return_index=True, return_inverse=True)
    return kinds, kind.ravel()


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
    ambient = inputs.ambient + room
    driven = from_ambient[level] * ambient[:, None] + from_heat[level]
    before, after = np.empty_like(driven), np.empty_like(driven)
    fixed = (inputs.first, level, steps.matrix, driven, start[inputs.order])
    if found.natural is None:
        march(*fixed, before, after)
    else:
        warm = found.natural
        march_in_still_air(*fixed, steps.gain, warm.conductance, ambient, warm.factors, warm.limit, before, after)
    return before, after


class _Further:
    """What natural convection takes within each bin beside conductances that do not depend on temperature.

    It is a heat that goes with the mean of the temperatures at both ends of the bin.
    """

    def __init__(self, steps: Steps, natural: Natural, level: IntArray, ambient: FloatArray) -> None:
        self._natural, self._ambient = natural, ambient
        self._gain, self._conductance = steps.gain[level], natural.conductance[level]

    def heat(self, before: FloatArray, after: FloatArray) -> FloatArray:
        """At each node, shape (N, n), W."""
        difference = 0.5 * (before + after) - self._ambient[:, None]
        return np.asarray(-self._conductance * self._natural.excess(difference))

    def answered(
        self,
        structure: Shape,
        inputs: Inputs,
        path: tuple[FloatArray, FloatArray],
        matrix: SingleArray,
        sources: SingleArray,
    ) -> tuple[SingleArray, SingleArray]:
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
) -> tuple[SingleArray, SingleArray]:
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
    more = None if further is None else further.heat(*path)
    sources = sources_of(structure, inputs, found, steps, path[0], room, more)
    nodes, sensors = structure.nodes, structure.sensors
    made = np.empty((inputs.level.size, sensors, sources.shape[-1]), dtype=np.float32)
    start = np.zeros((len(inputs.runs), nodes, sources.shape[-1]), dtype=np.float32)
    start[:, :, structure.size : structure.size + nodes] = np.eye(nodes)
    level, matrix = inputs.level, steps.matrix.astype(np.float32)
    if further is not None:
        matrix, sources = further.answered(structure, inputs, path, matrix[level], sources)
        level = np.arange(level.size)
    lagging = np.array(structure.lagging, dtype=np.int64)
    changes = np.empty((level.size, lagging.size, sources.shape[-1]), dtype=np.float32)
    march_slopes(inputs.first, level, matrix, sources, inputs.share.astype(np.float32), lagging, start, made, changes)
    if lagging.size:
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
) -> SingleArray:
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
    first, second = np.empty(steps.vectors.shape, dtype=single), np.empty(steps.vectors.shape, dtype=single)
    divided_differences(steps.rates, inputs.levels.width, steps.decay, steps.phi, first, second)
    size, bins = structure.size, level.size
    sources = np.zeros((bins, nodes, size + nodes + inputs.room.shape[-1]), dtype=single)
    flow = np.empty((bins, nodes, len(structure.incidence)), dtype=single)
    stored, warmed = np.empty((bins, nodes, nodes), dtype=single), np.empty((bins, nodes, nodes), dtype=single)
    warmth = np.empty((bins if found.by_growth is not None else 0, nodes, nodes), dtype=single)
    units(
        level,
        steps.vectors.astype(single),
        first,
        second,
        steps.phi.astype(single),
        root.astype(single),
        _ends(structure),
        modal.astype(single),
        forced.astype(single),
        rate.astype(single),
        ambient.astype(single),
        stored,
        flow,
        warmed,
        warmth,
    )
    sources[..., :nodes] = stored
    found.by_path.add_to(sources, flow, level)
    found.by_heat.add_to(sources, warmed, level)
    if found.by_growth is not None:
        # Heat by temperature is a path to 0 degC that gives instead of taking.
        found.by_growth.add_to(sources, warmth, level)
    if inputs.room.shape[-1]:
        reach = np.einsum("lij,lj->li", steps.gain, steps.outside)[level]
        sources[..., size + nodes :] = reach[..., None] * inputs.room[:, None, :]
    return sources


def _ends(structure: Shape) -> IntArray:
    """Both nodes of each path, -1 for the ambient, which stands second, shape (Q, 2)."""
    own = structure.incidence
    return np.column_stack([np.argmax(own, axis=1), np.where(structure.outer > 0.0, -1, np.argmin(own, axis=1))])
