"""Which numbers of a network are free: nodes, paths, heats, and where each stands in the vector of parameters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen.identification.network.bins import FloatArray, IntArray

PATH_TERMS = ("at rest", "constant", "forced", "exponent")
"""Logarithms: conductance at rest over that at `SLOW`, W/K, W/K at full speed, power of the speed."""
FIXED_TERMS = (0.0, -30.0, -30.0, float(np.log(0.8)))
"""What holds for a term that is not free: at rest as slowly turning; none; none; forced convection's usual exponent."""
SLOW = 0.1
"""Speed over full scale to which the conductance at rest is compared."""
HEAT_TERMS = ("w", "w^2", "w (1 - w)")
"""Logarithms of the coefficients, W."""


@dataclass(frozen=True)
class Structure:
    """Nodes, paths and heats.

    Attributes
    ----------
    sensed
        Names of the sensed nodes: nodes 0..S-1.
    hidden
        How many follow.
    paths
        Pairs of nodes; the ambient is -1 and stands second.
    heated
        Nodes with a heat of their own.
    terms
        For each path which of its `PATH_TERMS` are free.
    """

    sensed: tuple[str, ...]
    hidden: int
    paths: tuple[tuple[int, int], ...]
    heated: tuple[int, ...]
    terms: tuple[tuple[bool, bool, bool, bool], ...]

    @property
    def nodes(self) -> int:
        """How many."""
        return len(self.sensed) + self.hidden

    @property
    def names(self) -> tuple[str, ...]:
        """Of all nodes."""
        taken = set(self.sensed)
        hidden: list[str] = []
        number = 1
        while len(hidden) < self.hidden:
            name = f"hidden{number}"
            if name not in taken:
                hidden.append(name)
            number += 1
        return (*self.sensed, *hidden)

    @cached_property
    def incidence(self) -> FloatArray:
        """For each path +1 at its first and -1 at its second node, shape (Q, n)."""
        made = np.zeros((len(self.paths), self.nodes))
        for q, (i, j) in enumerate(self.paths):
            made[q, i] = 1.0
            if j >= 0:
                made[q, j] = -1.0
        return made

    @cached_property
    def outer(self) -> FloatArray:
        """1 for each path to the ambient, shape (Q,)."""
        return np.array([1.0 if j < 0 else 0.0 for _, j in self.paths])

    # Places in the vector of parameters.

    @cached_property
    def capacities(self) -> IntArray:
        """Of the logarithms of the capacities, shape (n,)."""
        return np.arange(self.nodes)

    @cached_property
    def free(self) -> tuple[IntArray, IntArray]:
        """Path and term of each free term of a path, in the vector's order, shape (F,) each."""
        path, term = np.nonzero(np.array(self.terms, dtype=bool).reshape(-1, 4))
        return path.astype(np.int64), term.astype(np.int64)

    @cached_property
    def conductances(self) -> IntArray:
        """Of the terms of each path, shape (Q, 4); -1 where one is fixed."""
        made = np.full((len(self.paths), 4), -1, dtype=np.int64)
        made[self.free] = self.nodes + np.arange(self.free[0].size)
        return made

    @cached_property
    def heats(self) -> IntArray:
        """Of the terms of each heat, shape (heated, 3)."""
        first = self.nodes + self.free[0].size
        return first + np.arange(3 * len(self.heated)).reshape(-1, 3)

    @cached_property
    def offsets(self) -> IntArray:
        """Of the sensors' offsets, shape (S,)."""
        first = self.nodes + self.free[0].size + 3 * len(self.heated)
        return first + np.arange(len(self.sensed))

    @property
    def size(self) -> int:
        """Parameters that all runs share."""
        return self.nodes + self.free[0].size + 3 * len(self.heated) + len(self.sensed)

    def path_terms(self, vector: FloatArray) -> FloatArray:
        """Give the terms of each path, those that are fixed included, shape (Q, 4)."""
        made = np.tile(np.array(FIXED_TERMS), (len(self.paths), 1))
        made[self.free] = vector[self.nodes : self.nodes + self.free[0].size]
        return made


OUTER, INNER = (True, True, True, True), (False, True, True, False)
"""Free terms of paths to the ambient and of others: air around the motor, metal and the gap within it."""


def full(sensed: tuple[str, ...], hidden: int) -> Structure:
    """Give the network in which every node has a path to every other and to the ambient, and a heat."""
    count = len(sensed) + hidden
    inner = [(i, j) for i in range(count) for j in range(i + 1, count)]
    paths = (*inner, *((i, -1) for i in range(count)))
    terms = tuple(OUTER if j < 0 else INNER for _, j in paths)
    return Structure(sensed, hidden, paths, tuple(range(count)), terms)
