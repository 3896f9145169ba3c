"""What the runs have left open: the name that was found, what may stand in its place, and none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen.arrays import FloatArray
from gen.refinement.gains import LEAST_GAIN, LEVEL
from gen.refinement.network.effects import NetworkEffect
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data
from gen.refinement.network.fitting.fit import AT_EACH, GOOD, Bench, Fitted
from gen.refinement.network.planned import NONE
from gen.refinement.network.tracing.judged import doubts, p_better
from gen.refinement.network.tracing.search import IN_DOUBT, Considered, Step
from gen.refinement.network.tracing.trace import Traced

MOST = 5
"""Hypotheses that a run is planned for."""
EXCLUDED = 50.0
"""Weighed squares by which the runs speak against none from which on it needs no further run to be excluded."""
HALF = 0.5
"""p-value up to which a name that was not accepted predicts rather better than none."""


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """What the motor may be, fitted to all runs.

    Attributes
    ----------
    effect
        What tells it from the others; None for no such effect.
    fitted
        The network with it, and with what was found beside it.
    """

    effect: NetworkEffect | None
    fitted: Fitted

    @property
    def name(self) -> str:
        """The effect's name in the library, or none."""
        return NONE if self.effect is None else self.effect.name

    @property
    def at(self) -> str:
        """Where it acts, and by what."""
        if self.effect is None:
            return ""
        return " ".join([self.effect.component, *self.effect.acts_by.values()])

    @property
    def label(self) -> str:
        """For people."""
        return f"{self.name} at {self.at}" if self.at else self.name

    @property
    def shape(self) -> Anchored:
        """What was fitted."""
        return self.fitted.shape

    @property
    def shared(self) -> FloatArray:
        """The numbers that all runs share, shape (size,)."""
        return self.fitted.vector[: self.shape.size]

    @cached_property
    def precision(self) -> FloatArray:
        """Of the same, from the runs, the file and what is known before; shape (size, size).

        The runs' own numbers are taken out of the last linearised problem (Schur's complement).
        """
        matrix, _ = self.fitted.problem.assembled(self.fitted.fit.normal, self.fitted.vector)
        size = self.shape.size
        across = matrix[:size, size:]
        made = matrix[:size, :size] - across @ np.linalg.solve(matrix[size:, size:], across.T)
        return np.asarray(0.5 * (made + made.T))

    @cached_property
    def truths(self) -> FloatArray:
        """What the motor may be if this is so, as changes of the numbers, shape (M, size).

        Nothing; and, for each of the effect's numbers, one standard deviation of it away from none, the others moved
        along as they are known to go with it. A first run may show an effect hardly at all: what is best by it is then
        near none, however large the effect may be.
        """
        made = [np.zeros(self.shape.size)]
        if self.effect is not None:
            place = next(k for k, effect in enumerate(self.shape.effects) if effect is self.effect)
            covariance = np.linalg.inv(self.precision)
            for at, number in zip(self.shape.places[place].columns.tolist(), self.effect.numbers, strict=True):
                sign = 1.0 if number.log or self.shared[at] >= 0.0 else -1.0
                made.append(sign * covariance[:, at] / np.sqrt(covariance[at, at]))
        return np.array(made)


@dataclass(frozen=True, eq=False)
class Remaining:
    """All hypotheses that remain.

    Attributes
    ----------
    hypotheses
        The one that refinement names comes first; one at least.
    density
        Of the errors of a good model, shape (S,), K^2 s: what a reading counts.
    noise_K
        Of single readings, root mean square over the sensors.
    beside
        Names of the effects that were found before the open question.
    """

    hypotheses: tuple[Hypothesis, ...]
    density: FloatArray
    noise_K: float
    beside: tuple[str, ...]


def remaining(traced: Traced) -> Remaining:
    """Fit what remains to all runs, with the same weights."""
    data, final = traced.data, traced.final.fitted
    bench = Bench(data)
    density = np.minimum(bench.density(final.fit), GOOD)
    bench.weigh(density)
    number = _open(traced)
    step = traced.steps[number]
    place = number  # each search before it has added one
    found = final.shape.effects
    others = [one for one in _alike(step, data) if one.effect not in found]
    kept = [Hypothesis(step.added.effect if step.added else None, bench.fit(final.shape, final, AT_EACH))]
    for one in others[: MOST - 2]:
        effects = (*found[:place], one.effect, *found[place + 1 :])
        kept.append(_fitted(bench, one.effect, effects, one.judged.fitted, final.shape))
    if step.added is not None:
        none = _fitted(bench, None, (*found[:place], *found[place + 1 :]), step.without.fitted, final.shape)
        if none.fitted.fit.cost - kept[0].fitted.fit.cost < EXCLUDED:
            kept.append(none)
    beside = tuple(effect.name for effect in found[:place])
    return Remaining(tuple(kept), density, traced.final.noise_K, beside)


def _fitted(
    bench: Bench, effect: NetworkEffect | None, effects: Sequence[NetworkEffect], base: Fitted, shape: Anchored
) -> Hypothesis:
    return Hypothesis(effect, bench.fit(shape.with_effects(*effects), base, AT_EACH))


def _open(traced: Traced) -> int:
    """The first search that left a choice, else the last that added something, else the only one."""
    for number, step in enumerate(traced.steps):
        if step.added is not None and _alike(step, traced.data):
            return number
    added = [number for number, step in enumerate(traced.steps) if step.added is not None]
    last = len(traced.steps) - 1
    if traced.steps[last].added is None and _alike(traced.steps[last], traced.data):
        return last
    return added[-1] if added else last


def _alike(step: Step, data: Data) -> list[Considered]:
    """What may stand in the place of what was added, the best first; where nothing was, what may yet be there."""
    sound = [one for one in step.considered if one is not step.added and not doubts(one.judged.fitted)]
    if step.added is None:
        worth = (1.0 - LEAST_GAIN) * step.without.score_K
        return [one for one in sound if one.p_value < HALF and one.judged.score_K < worth]
    chosen = step.added.judged
    return [
        one
        for one in sound
        if one in step.lookalikes
        or (one.judged.score_K <= IN_DOUBT * chosen.score_K and p_better(data, chosen, one.judged) > LEVEL)
    ]
