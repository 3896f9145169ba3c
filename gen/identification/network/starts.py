"""Where the search begins: from the parts alone, then with one more hidden node each time."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.scale import Scale
from gen.identification.network.fitting.speed_laws import HEAT, OUTSIDE
from gen.identification.network.fitting.structure import Structure


def from_parts(problem: Problem[Structure], scale: Scale) -> FloatArray:
    """Begin with what each part does alone, all of them coupled as the prior has it."""
    structure = problem.structure
    vector = problem.prior.mean.copy()
    capacity = np.exp(vector[0])
    for (i, j), at in zip(structure.paths, structure.conductances, strict=True):
        if j < 0 and i < len(structure.sensed):
            vector[at.start + OUTSIDE.level] = np.log(capacity / scale.settling[i])
    for i, at in zip(structure.heated, structure.heats, strict=True):
        if i < len(structure.sensed):
            vector[at.start + HEAT.level] = np.log(capacity / scale.settling[i] * scale.rise[i])
    return vector


ROLES = {"source": (-1.0, 1.0, -1.5), "sink": (1.0, -2.0, 0.5)}
"""A small hot node within, and a large cold one outside: logarithms of the factors on a hidden node's capacity, heat
and path to the ambient."""


def in_roles(problem: Problem[Structure], start: FloatArray) -> FloatArray:
    """Give hidden nodes roles by turns: a source of heat, a sink.

    Parameters
    ----------
    start
        Parameters in which all are alike, shape (P,).
    """
    structure, vector = problem.structure, start.copy()
    roles = list(ROLES.values())
    for number, node in enumerate(range(len(structure.sensed), structure.nodes)):
        capacity, heat, loss = roles[number % len(roles)]
        vector[structure.capacities[node]] += capacity
        if node in structure.heated:
            vector[structure.heats[structure.heated.index(node)].start + HEAT.level] += heat
        if (node, -1) in structure.paths:
            vector[structure.conductances[structure.paths.index((node, -1))].start + OUTSIDE.level] += loss
    return vector


def taken_over(problem: Problem[Structure], before: Problem[Structure], found: FloatArray) -> FloatArray:
    """Give the parameters of another structure or other bins for what both have; the rest as the prior has it.

    Parameters
    ----------
    problem
        What is to begin.
    before, found
        What was fitted, and its parameters, shape (P,).
    """
    structure, old = problem.structure, before.structure
    vector = problem.prior.mean.copy()
    place = {name: i for i, name in enumerate(old.names)}
    nodes = [(i, place[name]) for i, name in enumerate(structure.names) if name in place]
    number = dict(nodes)
    for i, k in nodes:
        vector[structure.capacities[i]] = found[old.capacities[k]]
    paths = {frozenset(path): q for q, path in enumerate(old.paths)}
    for q, path in enumerate(structure.paths):
        same = frozenset(number.get(i, -2) if i >= 0 else -1 for i in path)
        if same in paths:
            there = paths[same]
            if structure.laws[q] is old.laws[there]:
                vector[structure.conductances[q]] = found[old.conductances[there]]
            else:
                level = found[old.conductances[there].start + old.laws[there].level]
                vector[structure.conductances[q].start + structure.laws[q].level] = level
    heats = {node: h for h, node in enumerate(old.heated)}
    for h, node in enumerate(structure.heated):
        if number.get(node, -2) in heats:
            vector[structure.heats[h]] = found[old.heats[heats[number[node]]]]
    feeds = dict(zip(old.fed, old.feeds.tolist(), strict=True))
    for (column, node), feed in zip(structure.fed, structure.feeds.tolist(), strict=True):
        if (column, number.get(node, -2)) in feeds:
            vector[feed] = found[feeds[column, number[node]]]
    if structure.natural and old.natural:
        vector[structure.still] = found[old.still]
    if structure.warmth is not None:
        # Where heats did not grow, what they were is what they are now at usual temperatures.
        vector[structure.growing] = found[old.growing] if old.warmth is not None else 0.0
    vector[structure.offsets] = found[old.offsets]
    if structure.factors.size and old.factors.size:
        for i, k in nodes:
            if i >= structure.sensors:
                vector[structure.factors[i - structure.sensors]] = found[old.factors[k - old.sensors]]
    own, mine = before.per_run(found), problem.per_run(vector)
    mine[:, [i for i, _ in nodes]] = own[:, [k for _, k in nodes]]
    mine[:, structure.nodes :] = own[:, old.nodes :]
    vector[structure.size :] = mine.ravel()
    return vector
