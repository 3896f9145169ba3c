"""Drop an effect that a later one has made needless (without it the left-out error is no larger) or unknowable."""

from __future__ import annotations

from dataclasses import replace

from gen.refinement.parts.hypotheses import terms_of
from gen.refinement.parts.judgement import TIE_LEVEL, p_better, told_from_none
from gen.refinement.parts.simulation_fit import HypothesisFit, fit
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState

LEAST_GROWTH = 1.05
"""An effect is needed if the left-out RMSE, the sensor's noise included, is larger without it by this factor."""


def prune(state: TraceState, say: Say) -> TraceState:
    """Drop what is not needed, of each component that has several effects."""
    return state.each(_pruned)


def _pruned(component: ComponentState) -> ComponentState:
    at = 0
    while 1 < len(component.final.terms) > at:
        less = _without(component, at)
        if _known(component.final, at) and _needed(component, less):
            at += 1
        else:
            component, at = less, 0
    return component


def _without(component: ComponentState, at: int) -> ComponentState:
    terms = terms_of(component.final)
    dropped = terms.pop(at).effect.name
    found = tuple(f for f in component.found if f.candidate.effect.name != dropped)
    return replace(component, found=found, final=fit(component.runs, terms))


def _known(fitted: HypothesisFit, at: int) -> bool:
    """Whether the size of effect number `at` can be told from none beside the others."""
    size = fitted.size(at)
    return size is None or told_from_none(fitted, 0, size)


def _needed(component: ComponentState, less: ComponentState) -> bool:
    variance = float(component.runs.noise_K[0]) ** 2
    old, new = (float(each.final.loss[0]) + variance for each in (component, less))
    return new > LEAST_GROWTH**2 * old and p_better(component.runs, 0, less.final, component.final) < TIE_LEVEL
