"""Drawn to its limit an offset stands for something else; it is no calibration, and effects must do without it."""

from __future__ import annotations

from dataclasses import replace

from gen.refinement.parts.hypotheses import terms_of
from gen.refinement.parts.simulation_fit import fit
from gen.refinement.parts.steps.judge_again import together_pass
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState

NEAR_LIMIT = 0.95
"""From this share of the tolerance on, an offset counts as at its limit."""


def refuse_offsets(state: TraceState, say: Say) -> TraceState:
    """Fit effects beside such an offset again without any, and drop those that do not pass so."""

    def refused(component: ComponentState) -> ComponentState:
        limit_K = NEAR_LIMIT * component.runs.tolerance_K
        if not component.final.terms or abs(float(component.final.offset[0])) <= limit_K:
            return component
        say(component.name)
        exact = replace(component.runs, tolerance_K=0.0)
        made = fit(exact, terms_of(component.final))
        if together_pass(component, exact, fit(exact, []), made, state.tried):
            return replace(component, final=made)
        return component.with_nothing_found()

    return state.each(refused)
