"""Changes of the ways of heat: added masses, paths between nodes, and what a surface loses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.laws import Law
from benchmarks.plants.plant import Link, Plant, Source, Surface
from benchmarks.plants.planted.change import Change, Now, Steps, jumps

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class HiddenNode(Change):
    """Something bolted on, without a sensor; it heats itself, or only takes up heat.

    Parameters
    ----------
    node
        To which node.
    capacity
        J/K.
    conductance, outlet
        To that node and to the room, W/K.
    kind, share
        What heats it, as `Source`; none where the share is 0.
    """

    node: int
    capacity: float
    conductance: float
    outlet: float
    kind: str
    share: float

    def plant(self, plant: Plant) -> Plant:  # noqa: D102
        new = plant.size
        surfaces = (Surface(new, Law(self.outlet)),) if self.outlet else ()
        sources = (Source(new, self.kind, self.share),) if self.share else ()
        return replace(
            plant,
            names=(*plant.names, f"added_{new}"),
            capacity=(*plant.capacity, self.capacity),
            links=(*plant.links, Link(self.node, new, Law(self.conductance))),
            surfaces=(*plant.surfaces, *surfaces),
            sources=(*plant.sources, *sources),
        )


@dataclass(frozen=True)
class Coupling(Change):
    """A path between two nodes that was not there, or a better one where there was.

    Parameters
    ----------
    first, second
        Which nodes.
    conductance
        That it adds, W/K.
    """

    first: int
    second: int
    conductance: float

    def plant(self, plant: Plant) -> Plant:  # noqa: D102
        return replace(plant, links=(*plant.links, Link(self.first, self.second, Law(self.conductance))))


@dataclass(frozen=True)
class StandstillCooling(Change):
    """At rest, surfaces lose heat otherwise: a flap shuts, or the machine's own fan starts.

    Parameters
    ----------
    nodes
        Whose surfaces.
    factor
        Of what they lose at rest by the air.
    """

    nodes: tuple[int, ...]
    factor: float

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        if now.pwm:
            return plant
        return replace(plant, surfaces=tuple(self._still(s) if s.node in self.nodes else s for s in plant.surfaces))

    def _still(self, surface: Surface) -> Surface:
        law = replace(surface.law, rest=surface.law.rest * self.factor)
        return replace(surface, law=law, natural=surface.natural * self.factor)


AIR_CONDUCTIVITY, AIR_VISCOSITY, PRANDTL = 0.027, 1.7e-5, 0.71
"""Of air at 40 degC: W/m K, m2/s, and without a unit."""


def cross_flow(speed: float, diameter: float) -> float:
    """Heat transfer from a cylinder in cross flow, W/m2 K (Churchill and Bernstein, J. Heat Transfer 99, 1977).

    Parameters
    ----------
    speed, diameter
        Of the air in m/s, and of the cylinder in m.
    """
    reynolds = speed * diameter / AIR_VISCOSITY
    slender = 0.62 * reynolds**0.5 * PRANDTL ** (1 / 3) / (1.0 + (0.4 / PRANDTL) ** (2 / 3)) ** 0.25
    nusselt = 0.3 + slender * (1.0 + (reynolds / 282000.0) ** (5 / 8)) ** 0.8
    return float(nusselt * AIR_CONDUCTIVITY / diameter)


def fan(rng: np.random.Generator, duration: float) -> Steps:
    """Speed of the air in a run, m/s; sometimes the fan stands."""
    return jumps(
        rng, duration, (5.0, 40.0), lambda: 0.0 if rng.random() < 0.3 else float(rng.uniform(0.5, 6.0)), before=0.0
    )


def metered(rng: np.random.Generator, speed: FloatArray) -> FloatArray:
    """What an anemometer tells of the air's speed, m/s."""
    return np.asarray(np.maximum(speed * (1.0 + rng.normal(0.0, 0.03, speed.size)) + rng.normal(0.0, 0.03), 0.0))


@dataclass(frozen=True)
class Airflow(Change):
    """A fan blows at the motor, and not always as fast.

    Parameters
    ----------
    nodes
        At which.
    area, diameter
        Of each of them that the air meets, m2, and m.
    """

    needs: ClassVar[tuple[str, ...]] = ("airflow_mps",)
    nodes: tuple[int, ...]
    area: float
    diameter: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        return {"air": fan(rng, duration)}

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        speed = now.signals["air"]
        moved = self.area * (cross_flow(speed, self.diameter) - cross_flow(0.0, self.diameter))
        return replace(plant, surfaces=(*plant.surfaces, *(Surface(node, Law(moved)) for node in self.nodes)))

    def columns(self, rng: np.random.Generator, signals: Mapping[str, FloatArray]) -> dict[str, FloatArray]:  # noqa: D102
        return {"airflow_mps": metered(rng, signals["air"])}


@dataclass(frozen=True)
class Radiation(Change):
    """A surface painted black.

    Parameters
    ----------
    node
        Which node's.
    area
        Emissivity times area that this adds, m2.
    """

    node: int
    area: float

    def plant(self, plant: Plant) -> Plant:  # noqa: D102
        return replace(plant, surfaces=(*plant.surfaces, Surface(self.node, Law(0.0), radiating=self.area)))
