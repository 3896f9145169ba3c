"""What the parameters of a network mean at each distinct input, and how that changes with each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Inputs, Levels
from gen.identification.network.fitting.natural import Natural
from gen.identification.network.fitting.partial import Partial


@dataclass(frozen=True, eq=False)
class Physical:
    """Capacities, conductances and heats at L distinct inputs.

    Attributes
    ----------
    capacity
        Shape (n,), J/K.
    conductance
        Shape (L, Q), W/K.
    heat
        Shape (L, n), W, of nodes at 0 degC.
    by_path, by_heat
        Derivatives of conductances (W/K) and heats (W).
    growth
        What each node's heat grows by with its temperature, shape (L, n), W/K; None for nowhere.
    by_growth
        Its derivatives, W/K.
    natural
        What natural convection changes; None where conductances do not depend on temperature.
    room_degC
        The ambient for which it is told where the network settles, where that depends on it.
    """

    capacity: FloatArray
    conductance: FloatArray
    heat: FloatArray
    by_path: Partial
    by_heat: Partial
    growth: FloatArray | None = None
    by_growth: Partial | None = None
    natural: Natural | None = None
    room_degC: float = 0.0

    @property
    def heat_in_room(self) -> FloatArray:
        """Heats of nodes that are as warm as the room, shape (L, n), W."""
        return self.heat if self.growth is None else self.heat + self.room_degC * self.growth


@dataclass(frozen=True, eq=False)
class Begun:
    """Starts of the hidden nodes of R runs.

    Attributes
    ----------
    temperature
        Shape (R, h), degC.
    by_shared
        Derivatives by the parameters that all runs share, shape (R, h, p).
    by_sensed
        By the sensed nodes' starts, shape (R, h, S).
    by_ambient
        By the ambient at the start, shape (R, h).
    """

    temperature: FloatArray
    by_shared: FloatArray
    by_sensed: FloatArray
    by_ambient: FloatArray


def incidence_of(paths: Sequence[tuple[int, int]], nodes: int) -> FloatArray:
    """For each path +1 at its first and -1 at its second node, shape (Q, n); the ambient, second, is -1 as a node."""
    made = np.zeros((len(paths), nodes))
    for q, (i, j) in enumerate(paths):
        made[q, i] = 1.0
        if j >= 0:
            made[q, j] = -1.0
    return made


def outer_of(paths: Sequence[tuple[int, int]]) -> FloatArray:
    """1 for each path to the ambient, shape (Q,)."""
    return np.array([1.0 if j < 0 else 0.0 for _, j in paths])


class Shape(Protocol):
    """Which numbers of a network are free.

    The vector of shared parameters begins with the logarithms of the capacities.
    """

    def __hash__(self) -> int:
        """Alike for shapes in which the same is free."""

    @property
    def nodes(self) -> int:
        """How many nodes."""

    @property
    def sensors(self) -> int:
        """How many of them, the first ones, are sensed."""

    @property
    def size(self) -> int:
        """Parameters that all runs share."""

    @property
    def incidence(self) -> FloatArray:
        """For each path +1 at its first and -1 at its second node, shape (Q, n)."""

    @property
    def outer(self) -> FloatArray:
        """1 for each path to the ambient, shape (Q,)."""

    def physical(self, levels: Levels, vector: FloatArray) -> Physical:
        """Evaluate capacities, conductances and heats at each distinct input."""

    def begun(self, vector: FloatArray, sensed: FloatArray, ambient: FloatArray) -> Begun | None:
        """Where hidden nodes start, if that follows from the sensed ones, shape (R, S), and the ambient, shape (R,)."""

    def shown(self, inputs: Inputs, vector: FloatArray, temperature: FloatArray, change: FloatArray) -> FloatArray:
        """What sensors show.

        Parameters
        ----------
        inputs, vector
            The bins, and the parameters that all runs share and then others.
        temperature, change
            Of the sensed nodes at the readings' time, degC and K/s, shape (N, S).
        """

    def by_reading(
        self, inputs: Inputs, vector: FloatArray, temperature: FloatArray, change: FloatArray
    ) -> Sequence[tuple[int, int, FloatArray | float]]:
        """Derivatives of what sensors show by their own parameters: sensor, place of the parameter, shape (N,)."""

    @property
    def lagging(self) -> tuple[int, ...]:
        """Sensors that lag, or may."""

    def through_sensors(self, inputs: Inputs, vector: FloatArray, slopes: NDArray[Any], changes: NDArray[Any]) -> None:
        """Turn derivatives of temperatures into those of what sensors show.

        Parameters
        ----------
        inputs, vector
            As for `shown`.
        slopes
            Of the sensed nodes' temperatures at the readings' time, shape (N, S, p); turned in place.
        changes
            Of the lagging sensors' temperatures, of their changes in each bin, shape (N, lagging, p).
        """

    def implausible(self, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
        """How far off what is known of the whole, in standard deviations, shape (k,), and derivatives, shape (k, p)."""
