"""What an effect is in a network: numbers that are fitted, what they do to it, and how they are written down."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.inputs import Levels
from gen.refinement.network.changing.columns import Columns
from gen.refinement.network.changing.draft import Draft, Slope
from gen.refinement.network.changing.writer import NetworkWriter, PathAt, ends

WHOLE = "motor"
"""The component of an effect that acts on the whole motor."""
GROWN = 1.03
"""Heat that has grown by more than this at every speed that was run is a fault's pattern: no curve errs like that."""
SPEEDS = np.linspace(0.1, 1.0, 19)
"""At which powers of speed are told."""
OWN = -2
"""The effect's own node, in its paths."""


@dataclass(frozen=True)
class Number:
    """A number that is fitted, with what is known of it before any run.

    Parameters
    ----------
    name
        With its unit.
    start
        Where the search begins.
    mean, deviation
        A normal distribution, of the logarithm where `log`.
    low, high
        Physical limits, of the number itself.
    log
        Fitted by its logarithm.
    unit
        What is fitted over what is told: of a time constant, where a capacity is fitted, the conductance.
    """

    name: str
    start: float
    mean: float
    deviation: float
    low: float
    high: float
    log: bool = False
    unit: float = 1.0

    def fitted(self, value: float) -> float:
        """Give the number as it is fitted."""
        return float(np.log(value * self.unit)) if self.log else value * self.unit

    def value(self, fitted: float) -> float:
        """Give the number from what was fitted, within what can be computed."""
        return float(np.exp(np.clip(fitted, -60.0, 60.0)) if self.log else fitted) / self.unit


@dataclass(frozen=True)
class Motor:
    """What an effect needs to know of the network that it is put on.

    Attributes
    ----------
    names
        Of the file's nodes, the sensed ones first.
    sensed
        How many are sensed.
    paths
        Pairs of nodes, the ambient as -1 second.
    outer
        Those to the ambient that conduct, without a law.
    heated
        Nodes with heat.
    heat_W
        Of each of these: its heat at each of `SPEEDS`.
    heat_powers
        Of each of these: the power of speed that its heat goes with, at each of `SPEEDS`.
    outer_powers
        Of each path in `outer`: that of its conductance, in the middle.
    with_speed
        Of each path: what share of its conductance has come with speed, at each of `SPEEDS`.
    lawless
        Paths whose heat goes with the difference of their ends, without a law.
    multiplied
        Of each path: the channels that multiply it.
    columns
        What else drives the motor.
    typical_W, typical_W_per_K, typical_J_per_K
        Whole heat at full speed, median conductance, median capacity.
    whole_J_per_K
        Capacity of all nodes.
    usual_degC
        Of each node: where it settles at half speed.
    radiates
        Of each node: which excess is that of its radiation.
    """

    names: tuple[str, ...]
    sensed: int
    paths: tuple[tuple[int, int], ...]
    outer: tuple[int, ...]
    heated: tuple[int, ...]
    heat_W: tuple[FloatArray, ...]
    heat_powers: tuple[FloatArray, ...]
    outer_powers: tuple[float, ...]
    with_speed: tuple[FloatArray, ...]
    lawless: tuple[int, ...]
    multiplied: tuple[frozenset[str], ...]
    columns: Columns
    typical_W: float
    typical_W_per_K: float
    typical_J_per_K: float
    whole_J_per_K: float
    usual_degC: tuple[float, ...]
    radiates: tuple[int, ...]

    def path_at(self, q: int) -> PathAt:
        """Say where the file has a path without a law."""
        return PathAt(*ends(self.paths[q], self.names), self._alike(q).index(q))

    def has_beside(self, q: int, channel: str) -> bool:
        """Say whether there is a path between the same ends that a channel alone multiplies: a file holds one."""
        return any(self.multiplied[k] == {channel} for k in self._alike(q))

    def _alike(self, q: int) -> list[int]:
        return [k for k in self.lawless if set(self.paths[k]) == set(self.paths[q])]


@dataclass(frozen=True, eq=False)
class Place:
    """Where an effect stands in the fit.

    Attributes
    ----------
    columns
        Places of its numbers in the vector, shape (k,).
    node
        Its own node, where it has one.
    path
        The first of its own paths.
    """

    columns: IntArray
    node: int
    path: int

    def slopes(self, *each: FloatArray) -> list[Slope]:
        """Give derivatives by its numbers in their order, shape (L,) each, their places."""
        return list(zip(self.columns.tolist(), each, strict=False))


@dataclass(frozen=True, eq=False)
class Seen:
    """What sensors stand before, bin by bin.

    Attributes
    ----------
    temperature
        Of the sensed nodes, degC, shape (N, S).
    ambient
        degC, shape (N,).
    hours
        Since the run began, shape (N,).
    """

    temperature: FloatArray
    ambient: FloatArray
    hours: FloatArray


class Added(NamedTuple):
    """What an effect adds to a sensor's readings.

    Attributes
    ----------
    sensor
        Which.
    kelvin
        How much, K, shape (N,).
    slopes
        Derivatives of that by each of its numbers as they are fitted, shape (N,) each.
    """

    sensor: int
    kelvin: FloatArray
    slopes: tuple[FloatArray, ...]


class NetworkEffect(ABC):
    """An effect with what it acts on; everything that it does is in later runs only.

    Attributes
    ----------
    name
        In the library.
    component
        A node, or the whole motor.
    numbers
        What is fitted.
    """

    name: str
    component: str
    numbers: tuple[Number, ...]
    precision: FloatArray | None = None
    """Of the numbers together, as they are fitted, shape (k, k); None where each has a deviation of its own."""
    acts_by: Mapping[str, str] = MappingProxyType({})
    """What else it takes to say what it is: the channel, the other node."""
    title = ""
    """What a report calls it; empty where that is what the library calls the effect of its name."""
    note = ""
    """What to say beside it wherever it is named."""
    bends_the_file = False
    """Whether it is what the file's own numbers may be off by as well: that they are is no sign of it."""
    goes_with_speed = False
    """Whether it heats or cools alike whenever a speed is run again: then it is not what comes and goes, or differs
    between runs."""
    of_the_motor = True
    """Whether what it says by `change` is of the motor; else of what stands beside it, and no file may hold it."""
    lagging: int | None = None
    """The sensor to whose lag its one number adds."""
    nodes = 0
    """Nodes of its own: none or one, whose capacity (J/K) is then its first number."""

    @property
    def paths(self) -> tuple[tuple[int, int], ...]:
        """Paths of its own; its own node is -2."""
        return ()

    @property
    def freedom(self) -> int:
        """How many numbers it is as good as: fewer than it has, where these go together."""
        return len(self.numbers)

    def act(self, draft: Draft, levels: Levels, values: FloatArray, place: Place) -> None:  # noqa: B027
        """Put it on the network.

        Parameters
        ----------
        draft
            The network.
        levels
            Distinct inputs.
        values
            Its numbers as they are fitted, shape (k,).
        place
            Where it stands.
        """

    def read(self, seen: Seen, values: FloatArray) -> tuple[Added, ...]:
        """Say what it adds to sensors' readings with its numbers as they are fitted; none for one on the network."""
        return ()

    def by_temperature(self, values: FloatArray) -> tuple[tuple[int, int, float], ...]:
        """Say by how much that changes with sensed nodes' temperatures: sensor, node and kelvin for each kelvin."""
        return ()

    def unmoved(self) -> NetworkEffect | None:
        """Give the same effect with what it acts by held at its median; None where there is no such thing."""
        return None

    def title_of(self, values: Sequence[float]) -> str:
        """Say what a report calls it with its numbers; empty where that is what the library calls it."""
        return self.title

    def doubts(self, values: Sequence[float]) -> list[str]:
        """Say what is not as it would be if this were the reason, for numbers within their limits."""
        return []

    def change(self, values: Sequence[float]) -> str:
        """Say what has changed, and what does that, where it is no healthy motor's; empty where it may be one's."""
        return ""

    @abstractmethod
    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:
        """Write it into a coefficient file's network.

        Parameters
        ----------
        entry
            The network.
        values
            Its numbers, not their logarithms.
        """
