"""A component that is heated by another follows that one's effects as well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.arrays import FloatArray
from gen.model.effects.integrate import readings
from gen.refinement.parts.hypotheses import terms_of
from gen.refinement.parts.simulation_fit import fit
from gen.refinement.parts.trace_state import ComponentState, Say, TraceState


def couple(state: TraceState, say: Say) -> TraceState:
    """Fit once more where a component's source is another one whose own effects were found meanwhile."""
    rises = {c.name: _rise(c) for c in state.components.values() if c.final.terms}

    def refitted(component: ComponentState) -> ComponentState:
        named = [term.effect.reads(term.variant.fixed, "component") for term in component.final.terms]
        if not any(source in rises for term in named for _, source in term):
            return component
        say(component.name)
        runs = component.runs.with_others({name: rise for name, rise in rises.items() if name != component.name})
        return replace(component, runs=runs, final=fit(runs, terms_of(component.final)))

    return state.each(refitted)


def _rise(component: ComponentState) -> FloatArray:
    """The component's rise with its effects, K, shape (K + 1, R)."""
    fitted = component.final
    slots = [(term.effect, values) for term, values in zip(fitted.terms, fitted.values(0), strict=True)]
    rise = readings(slots, component.runs.track)[0]
    full = np.broadcast_to(rise, (rise.shape[0], 1, 1, component.runs.residual.shape[-1]))
    return np.asarray(full[:, 0, 0, :])
