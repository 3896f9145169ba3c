"""Effects with which temperatures would grow without end are no finding: a file with them is refused when it is read.

Each hypothesis was asked that by itself. What is left are parts whose effects were found apart from each other, or
fitted anew since, and close a loop together.
"""

from __future__ import annotations

from collections.abc import Iterable

from gen.model.effects import Applied
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState


def refuse_runaway(state: TraceState, say: Say) -> TraceState:
    """Drop the effects of the component that they help least, until what is left does not run away."""
    parts = list(state.components.values())
    while state.whole.runs_away(_effects(parts)):
        alone = [part for part in parts if state.whole.runs_away(_effects([part]))]
        looped = [part for part in parts if _takes_heat(part)]
        dropped = min(alone or looped or [part for part in parts if part.found], key=_helped)
        say(dropped.name)
        state = _without(state, dropped.name)
        parts = list(state.components.values())
    return state


def _without(state: TraceState, name: str) -> TraceState:
    return state.each(lambda component: component.with_nothing_found() if component.name == name else component)


def _effects(parts: Iterable[ComponentState]) -> list[Applied]:
    return [
        Applied(term.effect, part.name, values)
        for part in parts
        for term, values in zip(part.final.terms, part.final.values(0), strict=True)
    ]


def _takes_heat(part: ComponentState) -> bool:
    """Whether an effect of the part reads another component."""
    return any(term.effect.reads(term.variant.fixed, "component") for term in part.final.terms)


def _helped(part: ComponentState) -> float:
    """By how many squared noise floors the effects lower the squared error."""
    return (float(part.null.loss[0]) - float(part.final.loss[0])) / float(part.runs.noise_K[0]) ** 2
