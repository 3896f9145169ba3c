"""What a tracing knows between two of its steps. Nothing here is changed: a step makes a new state."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from gen.coefficients import Coefficients
from gen.model.effects import Setting
from gen.refinement.condense import Condensed
from gen.refinement.gains import LEAST_GAIN
from gen.refinement.parts.candidates import Candidate, Found, Tracing
from gen.refinement.parts.hypotheses import Hypothesis, hypotheses_for
from gen.refinement.parts.offered import each_speed_once, offered
from gen.refinement.parts.simulation_fit import HypothesisFit, fit
from gen.refinement.parts.stacked_runs import StackedRuns, stack_runs

Say = Callable[[str], None]
"""Called with what is being done."""


@dataclass(frozen=True)
class ComponentState:
    """One component's residual, and what explains it so far.

    Parameters
    ----------
    name
        The component's.
    runs
        The stacked runs with this component alone.
    offered
        What the runs offer to explain its residual with.
    hypotheses
        What is tried.
    null
        Fit without any effect.
    considered
        Each hypothesis alone, best first; None where the residual is not worth tracing.
    found
        Accepted effects.
    final
        Fit of all that was accepted.
    """

    name: str
    runs: StackedRuns
    offered: Setting
    hypotheses: tuple[Hypothesis, ...]
    null: HypothesisFit
    considered: tuple[Candidate, ...] | None
    found: tuple[Found, ...]
    final: HypothesisFit

    def worth_tracing(self) -> bool:
        """Whether an effect that explained all that is left could lower the RMSE by what an effect must at least."""
        variance = float(self.runs.noise_K[0]) ** 2
        w = self.runs.weight[:, 0, 0, :]
        of_noise = variance * np.count_nonzero(w) / max(float(w.sum()), 1.0)
        left = max(float(self.final.loss[0]) - of_noise, 0.0)
        return float(np.sqrt(variance / (variance + left))) < 1.0 - LEAST_GAIN

    def with_nothing_found(self) -> ComponentState:
        """The same without effects."""
        return replace(self, found=(), final=self.null)


@dataclass(frozen=True)
class TraceState:
    """All components between two steps.

    Parameters
    ----------
    whole
        The stacked runs with all components.
    components
        By name, in the model's order; it cannot be written to.
    tried
        How many hypotheses there are, for the correction of each test's level.
    each_speed_once
        Each run has one speed of its own, so that leaving out a run leaves out its speed.
    """

    whole: StackedRuns
    components: Mapping[str, ComponentState]
    tried: int
    each_speed_once: bool

    def each(self, new: Callable[[ComponentState], ComponentState]) -> TraceState:
        """The same with a new state of each component, made from its old one."""
        made = {name: new(component) for name, component in self.components.items()}
        return replace(self, components=MappingProxyType(made))

    def tracing(self) -> Tracing:
        """The outcome, the most important effect first."""
        parts = self.components.values()
        found = [f for c in parts for f in c.found]
        return Tracing(
            problem=self.whole,
            found=sorted(found, key=self._importance, reverse=True),
            final={c.name: c.final for c in parts},
            null={c.name: c.null for c in parts},
            considered={c.name: list(c.considered) for c in parts if c.considered is not None},
            tried=self.tried,
        )

    def _importance(self, entry: Found) -> float:
        """By how many squared noise floors it lowers the squared error."""
        j = entry.candidate.judgement
        noise_K = float(self.whole.noise_K[self.whole.components.index(entry.component)])
        return (j.before_K**2 - j.after_K**2) / noise_K**2


def beginning(coefficients: Coefficients, runs: Sequence[Condensed]) -> TraceState:
    """The state before the first step: nothing is considered, nothing found."""
    whole = stack_runs(coefficients, runs)
    settings = {name: offered(coefficients, runs, whole, name) for name in whole.components}
    hypotheses = {name: hypotheses_for(setting) for name, setting in settings.items()}
    once = each_speed_once(runs)
    components = {}
    for name in whole.components:
        alone = whole.only(name)
        null = fit(alone, [])
        # A left-out run says nothing of its speed where no other has that speed: the last step judges such effects.
        tried = [h for h in hypotheses[name] if not (once and h[0].of_single_speeds)]
        components[name] = ComponentState(
            name=name,
            runs=alone,
            offered=settings[name],
            hypotheses=tuple(tried),
            null=null,
            considered=None,
            found=(),
            final=null,
        )
    return TraceState(whole, MappingProxyType(components), sum(map(len, hypotheses.values())), once)
