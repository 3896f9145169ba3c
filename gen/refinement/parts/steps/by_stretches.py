"""Effects of single speeds where each was run once: judged on left-out stretches, where nothing else was found."""

from __future__ import annotations

from dataclasses import replace

from gen.refinement.parts.candidates import Found
from gen.refinement.parts.judged_on_stretches import by_stretch
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState


def by_stretches(state: TraceState, say: Say) -> TraceState:
    """Try these effects at each component that is worth it and has no effect."""
    if not state.each_speed_once:
        return state

    def tried(component: ComponentState) -> ComponentState:
        if component.considered is None or component.final.terms:
            return component
        say(component.name)
        entry = by_stretch(component.runs, component.offered, state.tried)
        if entry is None:
            return component
        return replace(
            component,
            considered=(entry, *component.considered),
            found=(Found(component.name, entry, []),),
            final=entry.fit,
        )

    return state.each(tried)
