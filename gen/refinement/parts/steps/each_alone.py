"""Each hypothesis is fitted and judged alone, at each component whose residual is over the sensor's noise."""

from __future__ import annotations

from dataclasses import replace

from gen.refinement.parts.hypotheses import first_round
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState


def each_alone(state: TraceState, say: Say) -> TraceState:
    """Consider all hypotheses."""

    def considered(component: ComponentState) -> ComponentState:
        if not component.worth_tracing():
            return component
        candidates = first_round(
            component.runs,
            component.hypotheses,
            component.null,
            state.tried,
            lambda effect: say(f"{component.name}, {effect}"),
        )
        return replace(component, considered=tuple(candidates))

    return state.each(considered)
