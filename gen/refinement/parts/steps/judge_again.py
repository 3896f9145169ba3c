"""All of a component's effects together must pass the test against none, whatever the way to them was."""

from __future__ import annotations

from gen.refinement.parts.judgement import judge
from gen.refinement.parts.simulation_fit import HypothesisFit
from gen.refinement.parts.stacked_runs import StackedRuns
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState


def judge_again(state: TraceState, say: Say) -> TraceState:
    """Drop the effects of each component at which they do not pass together."""

    def judged(component: ComponentState) -> ComponentState:
        good = together_pass(component, component.runs, component.null, component.final, state.tried)
        return component if good else component.with_nothing_found()

    return state.each(judged)


def together_pass(
    component: ComponentState, runs: StackedRuns, without: HypothesisFit, together: HypothesisFit, tried: int
) -> bool:
    """Whether a fit of all of a component's effects passes against one without.

    What acts everywhere passes, as it is there for all components' sake; a single run that gets worse does not count.
    """
    if not component.found or any(f.candidate.effect.everywhere for f in component.found):
        return True
    return all("worse" in reason for reason in judge(runs, 0, without, together, tried, 0).reasons)
