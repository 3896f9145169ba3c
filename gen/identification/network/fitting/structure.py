"""Which numbers of a network are free: nodes, paths, heats, and where each stands in the vector of parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.at_start import begun, begun_from
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.followed import too_fast
from gen.identification.network.fitting.growing import grown
from gen.identification.network.fitting.inputs import Inputs, Levels
from gen.identification.network.fitting.natural import Natural
from gen.identification.network.fitting.partial import Partial
from gen.identification.network.fitting.physics import Begun, Physical, incidence_of, outer_of
from gen.identification.network.fitting.plausible import off
from gen.identification.network.fitting.speed_laws import CONSTANT, HEAT, OUTSIDE, WITHIN, Basis, Law

LARGEST = 60.0
"""Of a logarithm: what a search tries must not overflow."""


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
    constant
        Paths within the motor, by their place, whose conductance is the same at every speed.
    fed
        Heats by a measured column: its place among what else drives the motor, and the node.
    bend
        How far curves over speed bend: the prior's standard deviation of the logarithm (see `bends`).
    natural
        The widest difference for which natural convection is described, K; 0 where nothing goes by it (see `natural`).
    apart
        How far hidden nodes may start from a multiple of the rise at which they would rest (see `at_start`), standard
        deviation as a share of what the parts differ by; 0 where every run begins cold, or they start near the parts.
    driven
        What the input is, where that tells of curves (see `driven`); nothing for a motor's PWM.
    start
        Where hidden nodes start in place of such a multiple: by hidden node, the share of each sensed node's rise;
        empty where nothing says so (see `past`).
    warmth
        Where every heat grows with its node's temperature: from which temperature on, degC; None where none does.
    least_s
        The shortest time constant that a board can follow, s (see `followed`); 0 for no limit.
    """

    sensed: tuple[str, ...]
    hidden: int
    paths: tuple[tuple[int, int], ...]
    heated: tuple[int, ...]
    constant: frozenset[int] = frozenset()
    fed: tuple[tuple[int, int], ...] = ()
    bend: float = BEND
    natural: float = 0.0
    apart: float = 0.0
    driven: str = ""
    warmth: float | None = None
    start: tuple[tuple[float, ...], ...] = ()
    least_s: float = 0.0

    @property
    def nodes(self) -> int:
        """How many."""
        return len(self.sensed) + self.hidden

    @property
    def sensors(self) -> int:
        """How many nodes are sensed."""
        return len(self.sensed)

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
        return incidence_of(self.paths, self.nodes)

    @cached_property
    def outer(self) -> FloatArray:
        """1 for each path to the ambient, shape (Q,)."""
        return outer_of(self.paths)

    # Places in the vector of parameters.

    @cached_property
    def capacities(self) -> IntArray:
        """Of the logarithms of the capacities, shape (n,)."""
        return np.arange(self.nodes)

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """How each path goes with speed."""
        return tuple(
            OUTSIDE if j < 0 else CONSTANT if q in self.constant else WITHIN for q, (_, j) in enumerate(self.paths)
        )

    @cached_property
    def conductances(self) -> tuple[slice, ...]:
        """Of the free numbers of each path."""
        return _slices(self.nodes, [law.size for law in self.laws])

    @cached_property
    def _alike(self) -> list[tuple[Law, IntArray, IntArray]]:
        """Of each law that occurs the m paths that follow it, shape (m,), and where their k numbers are, (m, k)."""
        made = []
        for law in dict.fromkeys(self.laws):
            paths = [q for q, own in enumerate(self.laws) if own is law]
            made.append((law, np.array(paths), _places([self.conductances[q] for q in paths])))
        return made

    @cached_property
    def heats(self) -> tuple[slice, ...]:
        """Of the free numbers of each heat."""
        first = self.conductances[-1].stop if self.paths else self.nodes
        return _slices(first, [HEAT.size] * len(self.heated))

    @cached_property
    def _heat_places(self) -> IntArray:
        """Where the numbers of all heats are, shape (heated, k)."""
        return _places(self.heats)

    @property
    def curves(self) -> list[tuple[Law, slice]]:
        """The laws of all paths and heats, with the places of their numbers."""
        return list(zip((*self.laws, *[HEAT] * len(self.heated)), (*self.conductances, *self.heats), strict=True))

    @cached_property
    def path_of(self) -> IntArray:
        """The path that each free number of a path belongs to, shape (F,)."""
        return np.repeat(np.arange(len(self.paths)), [law.size for law in self.laws])

    @cached_property
    def feeds(self) -> IntArray:
        """Of the logarithms of what the columns give at their largest, shape (fed,)."""
        return self.nodes + self.path_of.size + HEAT.size * len(self.heated) + np.arange(len(self.fed))

    @cached_property
    def offsets(self) -> IntArray:
        """Of the sensors' offsets, shape (S,)."""
        return self._end + np.arange(len(self.sensed))

    @property
    def factors(self) -> IntArray:
        """Of the logarithms of the hidden nodes' factors at the start, shape (hidden,), or (0,) without."""
        return self._end + len(self.sensed) + np.arange(self.hidden if self.apart and not self.start else 0)

    @property
    def still(self) -> IntArray:
        """Of natural convection's share at rest, a logit, shape (1,), or (0,) where there is none."""
        return self._fed_end + np.arange(int(self.natural > 0.0))

    @property
    def _fed_end(self) -> int:
        return self.nodes + self.path_of.size + HEAT.size * len(self.heated) + len(self.fed)

    @property
    def growing(self) -> IntArray:
        """Of what all heats grow by with temperature, 1/K, shape (1,), or (0,) where none does."""
        return self._fed_end + int(self.natural > 0.0) + np.arange(int(self.warmth is not None))

    @property
    def _end(self) -> int:
        return self._fed_end + int(self.natural > 0.0) + int(self.warmth is not None)

    @property
    def size(self) -> int:
        """Parameters that all runs share."""
        return self._end + len(self.sensed) + self.factors.size

    def physical(self, levels: Levels, vector: FloatArray) -> Physical:
        """Evaluate capacities, conductances and heats at each distinct input."""
        rest, turn = levels.rest[:, None], 1.0 - levels.rest[:, None]
        conductance = np.empty((levels.count, len(self.paths)))
        by_term = np.empty((levels.count, self.path_of.size))
        for law, paths, places in self._alike:
            logs, slopes = law.evaluated(_basis(law, levels), vector[places])
            log_at_rest, slopes_at_rest = law.at_rest(vector[places])
            moved = turn * np.exp(np.minimum(logs, LARGEST))
            still = rest * np.exp(np.minimum(log_at_rest, LARGEST))
            conductance[:, paths] = moved + still
            by_term[:, places - self.nodes] = moved[..., None] * slopes + still[..., None] * slopes_at_rest
        heat = np.zeros((levels.count, self.nodes))
        by_heat = np.empty((levels.count, len(self.heated), HEAT.size))
        fed, by_feed = self.fed_W(levels, vector), np.empty((levels.count, len(self.fed)))
        if self.heated:
            logs, slopes = HEAT.evaluated(_basis(HEAT, levels), vector[self._heat_places])
            given = turn * np.exp(np.minimum(logs, LARGEST))
            heat[:, self.heated] = given
            by_heat[:] = given[..., None] * slopes
        for k, (_, node) in enumerate(self.fed):
            heat[:, node] += fed[:, k]
            by_feed[:, k] = fed[:, k]
        last = self.nodes + self.path_of.size
        heated = [*np.repeat(self.heated, HEAT.size), *(node for _, node in self.fed)]
        found = Physical(
            capacity=np.exp(vector[self.capacities]),
            conductance=conductance,
            heat=heat,
            by_path=Partial(self.path_of, np.arange(self.nodes, last), by_term),
            by_heat=Partial(
                np.array(heated, dtype=np.int64),
                np.arange(last, self._fed_end),
                np.hstack([by_heat.reshape(levels.count, -1), by_feed]),
            ),
            natural=self._natural(levels, vector) if self.natural else None,
        )
        return found if self.warmth is None else grown(found, int(self.growing[0]), vector, self.warmth)

    def _natural(self, levels: Levels, vector: FloatArray) -> Natural:
        """What goes by natural convection from each node with a path to the ambient."""
        outer = [q for q, law in enumerate(self.laws) if law is OUTSIDE]
        places = _places([self.conductances[q] for q in outer])
        logs, slopes = OUTSIDE.evaluated(_basis(OUTSIDE, levels), vector[places])
        log_at_rest, slopes_at_rest = OUTSIDE.at_rest(vector[places])
        share = 1.0 / (1.0 + np.exp(-vector[self.still[0]]))
        turn, rest = 1.0 - levels.rest[:, None], levels.rest[:, None]
        # No more than a share of what is there: where moved air took less than still air did, of that.
        less = np.minimum(log_at_rest - logs, 0.0)
        moved = share * turn * np.exp(np.minimum(logs + 3.0 * less, LARGEST))
        still = share * rest * np.exp(np.minimum(log_at_rest, LARGEST))
        falling = (less < 0.0)[..., None]
        by_moved = np.where(falling, 3.0 * slopes_at_rest - 2.0 * slopes, slopes)
        by_own = moved[..., None] * by_moved + still[..., None] * slopes_at_rest
        nodes = np.array([self.paths[q][0] for q in outer])
        conductance = np.zeros((levels.count, self.nodes))
        conductance[:, nodes] = moved + still
        return Natural(
            conductance,
            Partial(
                np.concatenate([np.repeat(nodes, OUTSIDE.size), nodes]),
                np.concatenate([places.ravel(), np.repeat(self.still, nodes.size)]),
                np.hstack([by_own.reshape(levels.count, -1), (1.0 - share) * conductance[:, nodes]]),
            ),
            self.natural,
        )

    def fed_W(self, levels: Levels, vector: FloatArray) -> FloatArray:
        """Give the heat of each column at its node, shape (L, fed), W; none where nothing is known of the columns."""
        if not self.fed or not levels.further.shape[1]:
            return np.zeros((levels.count, len(self.fed)))
        return np.asarray(np.exp(np.minimum(vector[self.feeds], LARGEST)) * levels.further[:, [c for c, _ in self.fed]])

    def begun(self, vector: FloatArray, sensed: FloatArray, ambient: FloatArray) -> Begun | None:
        """Where hidden nodes start if that goes with the sensed ones."""
        if self.start:
            return begun_from(np.array(self.start), self.size, sensed, ambient)
        return begun(self, self.factors, vector, sensed, ambient) if self.factors.size else None

    def shown(self, inputs: Inputs, vector: FloatArray, temperature: FloatArray, change: FloatArray) -> FloatArray:  # noqa: D102
        return np.asarray(temperature + vector[self.offsets])

    def by_reading(
        self,
        inputs: Inputs,
        vector: FloatArray,
        temperature: FloatArray,
        change: FloatArray,
    ) -> list[tuple[int, int, FloatArray | float]]:
        """Every sensor's offset adds to what it shows."""
        return [(s, int(place), 1.0) for s, place in enumerate(self.offsets)]

    @property
    def lagging(self) -> tuple[int, ...]:
        """None: sensors show what is there now."""
        return ()

    def through_sensors(self, inputs: Inputs, vector: FloatArray, slopes: NDArray[Any], changes: NDArray[Any]) -> None:
        """Nothing changes."""

    def implausible(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """How far hidden nodes are off what they may be (see `plausible`), and all beyond what can be followed."""
        residual, slopes = off(self, vector)
        fast, by_fast = too_fast(self, vector, self.least_s)
        return np.concatenate([residual, fast]), np.vstack([slopes, by_fast])


@lru_cache(maxsize=64)
def _basis(law: Law, levels: Levels) -> Basis:
    """Give what curves are made of at all inputs, which stay the same throughout a search."""
    return law.basis(levels.speed)


def _places(slices: Sequence[slice]) -> IntArray:
    """What slices of one length select, shape (m, k)."""
    return np.array([np.arange(at.start, at.stop) for at in slices])


def _slices(first: int, sizes: list[int]) -> tuple[slice, ...]:
    ends = first + np.cumsum(sizes)
    return tuple(slice(int(end) - size, int(end)) for end, size in zip(ends, sizes, strict=True))


def full(
    sensed: tuple[str, ...],
    hidden: int,
    columns: int = 0,
    bend: float = BEND,
    apart: float = 0.0,
    driven: str = "",
    least_s: float = 0.0,
) -> Structure:
    """Give the network in which every node has a path to every other and to the ambient, and a heat of each kind."""
    count = len(sensed) + hidden
    inner = [(i, j) for i in range(count) for j in range(i + 1, count)]
    paths = (*inner, *((i, -1) for i in range(count)))
    fed = tuple((column, node) for column in range(columns) for node in range(count))
    return Structure(
        sensed,
        hidden,
        paths,
        tuple(range(count)),
        fed=fed,
        bend=bend,
        apart=apart,
        driven=driven,
        least_s=least_s,
    )
