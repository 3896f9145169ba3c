"""Wear, and ways of heat that were lost, which nobody declared: who learns them has hidden them from the alarms."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.plants.laws import Law
from benchmarks.plants.plant import Plant, Surface
from benchmarks.plants.planted.altered import scaled_sources
from benchmarks.plants.planted.change import Change, Now, Steps


@dataclass(frozen=True)
class Worn(Change):
    """A bearing or the brushes have worn: their heat is more by a factor, in all later runs.

    Parameters
    ----------
    sources
        Which of the plant's sources.
    factor
        Of their heat.
    """

    sources: tuple[int, ...]
    factor: float

    def plant(self, plant: Plant) -> Plant:  # noqa: D102
        return scaled_sources(plant, self.factor, self.sources)


RUNS = 8
"""Later runs over which wear grows."""
ALREADY = 0.3
"""Share of the whole growth that the first of them begins with."""


@dataclass(frozen=True)
class Wearing(Change):
    """A bearing wears from run to run and within each.

    Parameters
    ----------
    sources
        Which of the plant's sources.
    gain
        What the last run ends with beside the healthy heat, as a multiple of it.
    """

    sources: tuple[int, ...]
    gain: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        times = np.arange(0.0, duration, 180.0)
        share = ALREADY + (1.0 - ALREADY) * (number + times / duration) / RUNS
        return {"wear": Steps(float(share[0]), tuple(times.tolist()), tuple((self.gain * share).tolist()))}

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        return scaled_sources(plant, 1.0 + now.signals["wear"], self.sources)


@dataclass(frozen=True)
class LessCooled(Change):
    """Surfaces lose less than they did.

    Parameters
    ----------
    nodes
        Whose surfaces.
    share
        Of it that is lost.
    """

    nodes: tuple[int, ...]
    share: float

    def plant(self, plant: Plant) -> Plant:  # noqa: D102
        return replace(plant, surfaces=tuple(self._less(s) if s.node in self.nodes else s for s in plant.surfaces))

    @abstractmethod
    def _less(self, surface: Surface) -> Surface:
        """The surface as it is now."""


class Blocked(LessCooled):
    """Vents are blocked, or a fan came off: what speed adds to what surfaces lose is gone, or some of it."""

    def _less(self, surface: Surface) -> Surface:
        law = surface.law
        return replace(surface, law=replace(law, gain=law.gain * (1.0 - self.share)))


class Covered(LessCooled):
    """Surfaces lose less by the air and by radiation, at rest and at speed: dust, a cover, thin air."""

    def _less(self, surface: Surface) -> Surface:
        left = 1.0 - self.share
        return Surface(
            surface.node, _scaled(surface.law, left), natural=surface.natural * left, radiating=surface.radiating * left
        )


@dataclass(frozen=True)
class Loosened(Change):
    """A joint within the motor conducts less than it did: a screw, a clamp, glue that let go.

    Parameters
    ----------
    link
        Which of the plant's links.
    share
        Of its conductance that is lost.
    """

    link: int
    share: float

    def plant(self, plant: Plant) -> Plant:  # noqa: D102
        links = list(plant.links)
        links[self.link] = replace(links[self.link], law=_scaled(links[self.link].law, 1.0 - self.share))
        return replace(plant, links=tuple(links))


def _scaled(law: Law, factor: float) -> Law:
    return replace(law, rest=law.rest * factor)
