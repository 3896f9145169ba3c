"""What tracing gives: hypotheses with what the data say of them, accepted effects, and the whole story."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.model.effects import Effect, Variant
from gen.refinement.gains import LEVEL
from gen.refinement.parts.judgement import Judgement
from gen.refinement.parts.simulation_fit import HypothesisFit
from gen.refinement.parts.stacked_runs import StackedRuns


@dataclass(frozen=True)
class Candidate:
    """A hypothesis with what the data say of it."""

    effect: Effect
    variant: Variant
    fit: HypothesisFit
    at: int
    """Index of its component in the fit."""
    judgement: Judgement
    by_stretch: bool = False
    """Judged on left-out stretches of runs, as each speed was run once only."""

    @property
    def loss(self) -> float:
        """Left-out squared error, K^2."""
        return float(self.fit.loss[self.at])

    @property
    def label(self) -> str:
        """Name and what it acts through."""
        through = [name for _, name in self.effect.reads(self.variant.fixed)]
        name = f"{self.effect.name} ({', '.join(through)})" if through else self.effect.name
        return f"{name}, judged on stretches" if self.by_stretch else name


@dataclass
class Found:
    """An accepted effect."""

    component: str
    candidate: Candidate
    lookalikes: list[Candidate]


@dataclass
class Tracing:
    """Everything that was found and considered.

    Parameters
    ----------
    problem
        The data.
    found
        Accepted effects, most important first.
    final
        Last fit by component.
    null
        Fit without any effect by component.
    considered
        The first round's hypotheses by component, best first.
    tried
        How many hypotheses there were.
    """

    problem: StackedRuns
    found: list[Found]
    final: dict[str, HypothesisFit]
    null: dict[str, HypothesisFit]
    considered: dict[str, list[Candidate]]
    tried: int

    @property
    def level(self) -> float:
        """The level of each test, corrected for the number of hypotheses."""
        return LEVEL / max(self.tried, 1)

    def own_ratio(self, name: str, fits: dict[str, HypothesisFit]) -> float:
        """The same ratio as :meth:`ratio` at one component."""
        variance = float(self.problem.noise_K[self.problem.components.index(name)]) ** 2
        return float(np.sqrt((float(fits[name].loss[0]) + variance) / variance))

    def ratio(self, fits: dict[str, HypothesisFit]) -> float:
        """RMSE on left-out runs over the noise floor, all components together."""
        squares = []
        for c, name in enumerate(self.problem.components):
            variance = float(self.problem.noise_K[c]) ** 2
            squares.append((float(fits[name].loss[0]) + variance) / variance)
        return float(np.sqrt(np.mean(squares)))
