"""The first effect at each component: of those that the data cannot tell apart, the one that others support as well."""

from __future__ import annotations

from dataclasses import replace

from gen.refinement.parts.candidates import Found
from gen.refinement.parts.hypotheses import choose
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState


def choose_first(state: TraceState, say: Say) -> TraceState:
    """Take the best accepted hypothesis of each component."""
    parts = state.components.values()
    chosen = choose(
        {c.name: c.runs for c in parts}, {c.name: list(c.considered) for c in parts if c.considered is not None}
    )

    def taken(component: ComponentState) -> ComponentState:
        if component.name not in chosen:
            return component
        best, lookalikes = chosen[component.name]
        return replace(component, found=(Found(component.name, best, lookalikes),), final=best.fit)

    return state.each(taken)
