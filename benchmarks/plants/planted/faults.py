"""Wear that nobody declared: what learns it into the healthy model without a word has hidden it from the alarms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.plants.plant import Plant
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
