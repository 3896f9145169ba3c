"""A motor as a network of heat capacities: its parameters, and the rates at which its temperatures change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from benchmarks.plants.laws import Law
from benchmarks.plants.losses import COPPER_PER_K, COPPER_REFERENCE, Losses

FloatArray = NDArray[np.float64]
FollowedRates = Callable[[FloatArray, float], FloatArray]
"""How a state changes, by itself and the room's temperature in degC; temperatures in K/s."""
FULL_PWM = 255
STEFAN_BOLTZMANN = 5.670374419e-8
"""W/m2 K4"""
ZERO_C = 273.15
"""K"""
CALM_K = 0.05
"""Below this difference natural convection is no longer a power of it: its slope stays finite."""


@dataclass(frozen=True)
class Link:
    """A path of heat between two nodes."""

    first: int
    second: int
    law: Law


@dataclass(frozen=True)
class Surface:
    """A node's way to the room.

    Parameters
    ----------
    node
        Which node.
    law
        Forced convection and conduction.
    natural
        Natural convection at a difference of 1 K, W/K; its conductance grows with the difference's fourth root (laminar
        flow along a wall, any text on heat transfer).
    radiating
        Emissivity times area, m2.
    """

    node: int
    law: Law
    natural: float = 0.0
    radiating: float = 0.0


@dataclass(frozen=True)
class Source:
    """Heat at a node.

    Parameters
    ----------
    node
        Which node.
    kind
        Which of the motor's losses: `friction`, `windage`, `iron`, `copper` or `brush`.
    share
        Watts per unit of that loss.
    per_K
        How much it grows with the node's own temperature, from 25 degC on, 1/K.
    """

    node: int
    kind: str
    share: float
    per_K: float = 0.0


@dataclass(frozen=True)
class Plant:
    """A motor.

    Parameters
    ----------
    names
        Of the nodes.
    capacity
        J/K, shape (N,).
    links, surfaces, sources
        Between the nodes, to the room, and what heats them.
    losses
        The motor's losses.
    sensed
        Nodes with a sensor.
    """

    names: tuple[str, ...]
    capacity: tuple[float, ...]
    links: tuple[Link, ...]
    surfaces: tuple[Surface, ...]
    sources: tuple[Source, ...]
    losses: Losses
    sensed: tuple[int, ...]

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.capacity)

    def at(self, pwm: int) -> Running:
        """The plant at a PWM of -255..255 counts; it turns the same in both directions."""
        return Running(self, abs(pwm) / FULL_PWM)

    @property
    def changes(self) -> tuple[float, ...]:
        """Nothing of it jumps beside PWM."""
        return ()

    @property
    def longest_s(self) -> float:
        """A quarter of an hour: nothing of it happens at one temperature alone."""
        return 900.0

    def rest(self, ambient: float) -> FloatArray:
        """Temperatures after a long rest in a room, degC, shape (N,)."""
        return np.full(self.size, ambient)

    def rates(self, pwm: int, begin: float) -> FollowedRates:
        """How its temperatures change at a PWM of -255..255 counts, K/s."""
        return self.at(pwm).rates

    def steady(self, pwm: int, ambient: float) -> FloatArray:
        """Temperatures that it settles at, degC, shape (N,).

        Raises
        ------
        ValueError
            If it does not settle.
        """
        running = self.at(pwm)
        guess = np.linalg.solve(running.matrix, -(running.power + running.outlet * ambient))
        found = root(running.flows, guess, args=(ambient,), tol=1e-10)
        flows = running.flows(found.x, ambient)
        if np.max(np.abs(flows)) > 1e-6 * (1.0 + float(np.sum(running.power))) or np.max(found.x) > 400.0:
            raise ValueError(f"no steady temperature at PWM {pwm}")
        return np.asarray(found.x, dtype=np.float64)

    def slowest(self, pwm: int) -> tuple[float, float]:
        """Smallest and largest time constant in s, without what depends on temperature."""
        running = self.at(pwm)
        rates = -np.linalg.eigvals(running.matrix / np.array(self.capacity)[:, None]).real
        return float(1.0 / rates.max()), float(1.0 / rates.min())


class Running:
    """A plant at one PWM: everything that does not depend on temperature, computed once.

    Attributes
    ----------
    matrix
        Heat flow into each node for each node's temperature, W/K, shape (N, N); what goes to the room is on its
        diagonal.
    outlet
        Conductance to the room, W/K, shape (N,).
    power
        Heat at 25 degC, W, shape (N,).
    """

    def __init__(self, plant: Plant, duty: float) -> None:
        speed = plant.losses.speed(duty)
        size = plant.size
        self.matrix, self.outlet, self.power = np.zeros((size, size)), np.zeros(size), np.zeros(size)
        self.growth, self.natural, self.radiating = np.zeros(size), np.zeros(size), np.zeros(size)
        self.capacity = np.array(plant.capacity)
        for link in plant.links:
            conductance = link.law(speed)
            for a, b in ((link.first, link.second), (link.second, link.first)):
                self.matrix[a, b] += conductance
                self.matrix[a, a] -= conductance
        for surface in plant.surfaces:
            self.outlet[surface.node] += surface.law(speed)
            self.natural[surface.node] += surface.natural / (1.0 + 4.0 * speed)  # a fan's flow takes over
            self.radiating[surface.node] += surface.radiating * STEFAN_BOLTZMANN
        self.matrix -= np.diag(self.outlet)
        for source in plant.sources:
            watts = source.share * float(getattr(plant.losses, source.kind)(duty))
            self.power[source.node] += watts
            self.growth[source.node] += watts * source.per_K

    def heat(self, temperature: FloatArray) -> FloatArray:
        """Heat that arises in each node, W."""
        return np.asarray(self.power + self.growth * (temperature - COPPER_REFERENCE))

    def lost(self, temperature: FloatArray, ambient: float) -> FloatArray:
        """Heat that each node gives to the room, W."""
        over = temperature - ambient
        calm = self.natural * (over * over + CALM_K * CALM_K) ** 0.125
        kelvin, room = temperature + ZERO_C, ambient + ZERO_C
        return np.asarray((self.outlet + calm) * over + self.radiating * (kelvin**4 - room**4))

    def flows(self, temperature: FloatArray, ambient: float) -> FloatArray:
        """Heat that stays in each node, W."""
        between = self.matrix @ temperature + self.outlet * temperature
        return np.asarray(between + self.heat(temperature) - self.lost(temperature, ambient))

    def rates(self, temperature: FloatArray, ambient: float) -> FloatArray:
        """How fast each node's temperature changes, K/s."""
        return np.asarray(self.flows(temperature, ambient) / self.capacity)


def copper(node: int, share: float) -> Source:
    """A winding's loss, which grows as copper's resistance does."""
    return Source(node, "copper", share, COPPER_PER_K)
