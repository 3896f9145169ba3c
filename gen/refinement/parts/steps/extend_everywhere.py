"""What acts on most components by its nature acts on the others, too, even where another effect hides it."""

from __future__ import annotations

from dataclasses import replace

from gen.refinement.parts.candidates import Candidate, Found
from gen.refinement.parts.judgement import judge
from gen.refinement.parts.simulation_fit import Term, fit
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState


def extend_everywhere(state: TraceState, say: Say) -> TraceState:
    """Take such an effect at every component where at least half of them have it."""
    found = [f for c in state.components.values() for f in c.found]
    for name in dict.fromkeys(f.candidate.effect.name for f in found if f.candidate.effect.everywhere):
        state = _extended(state, name)
    return state


def _extended(state: TraceState, name: str) -> TraceState:
    own = {
        component.name: f.candidate
        for component in state.components.values()
        for f in component.found
        if f.candidate.effect.name == name
    }
    if 2 * len(own) < len(state.components):
        return state
    pattern = next(iter(own.values()))
    return state.each(lambda c: c if c.name in own else _with(c, pattern, state.tried))


def _with(component: ComponentState, pattern: Candidate, tried: int) -> ComponentState:
    """The component with this effect in place of what it has."""
    effect, variant = pattern.effect, pattern.variant
    made = fit(component.runs, [Term(effect, variant, tuple(f.start for f in variant.free))])
    verdict = judge(component.runs, 0, component.null, made, tried, 0)
    found = Found(component.name, Candidate(effect, variant, made, 0, verdict), [])
    return replace(component, found=(found,), final=made)
