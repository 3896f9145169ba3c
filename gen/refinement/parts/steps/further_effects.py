"""A second and a third effect where something is left: pairs first, since two effects can hide each other."""

from __future__ import annotations

from dataclasses import replace

from gen.refinement.parts.candidates import Found
from gen.refinement.parts.pairs import pair, third
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState

MOST_EFFECTS = 3
"""Most effects at one component: what is left after three is said to be unexplained."""


def further_effects(state: TraceState, say: Say) -> TraceState:
    """Add effects one by one. Steps from cold at one speed each are too alike to tell two effects apart."""
    if state.each_speed_once:
        return state

    def grown(component: ComponentState) -> ComponentState:
        for _ in range(MOST_EFFECTS - 1):
            if component.considered is None or not component.worth_tracing():
                break
            say(component.name)
            more = _one_more(component, state.tried)
            if more is None:
                break
            component = more
        return component

    return state.each(grown)


def _one_more(component: ComponentState, tried: int) -> ComponentState | None:
    """The component with an effect more, or with two in place of one; None if none passes."""
    runs, hypotheses, final = component.runs, component.hypotheses, component.final
    if len(final.terms) <= 1 and not any(f.candidate.effect.everywhere for f in component.found):
        better = pair(runs, hypotheses, component.null, final, component.considered or (), tried)
    else:
        better = third(runs, hypotheses, final, tried)
    if not better:
        return None
    kept = () if len(better) == 2 else component.found
    added = [Found(component.name, candidate, ties) for candidate, ties in better]
    return replace(component, found=(*kept, *added), final=better[-1][0].fit)
