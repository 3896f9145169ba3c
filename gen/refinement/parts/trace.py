"""Tracing a residual: hypotheses fitted, compared on left-out runs, added one by one, named with their look-alikes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from gen.coefficients import Coefficients
from gen.refinement.condense import Condensed
from gen.refinement.parts.candidates import Tracing
from gen.refinement.parts.steps.by_stretches import by_stretches
from gen.refinement.parts.steps.choose_first import choose_first
from gen.refinement.parts.steps.couple import couple
from gen.refinement.parts.steps.each_alone import each_alone
from gen.refinement.parts.steps.extend_everywhere import extend_everywhere
from gen.refinement.parts.steps.further_effects import further_effects
from gen.refinement.parts.steps.judge_again import judge_again
from gen.refinement.parts.steps.prune import prune
from gen.refinement.parts.steps.refuse_offsets import refuse_offsets
from gen.refinement.parts.steps.refuse_runaway import refuse_runaway
from gen.refinement.parts.trace_state import Say, TraceState, beginning

Step = Callable[[TraceState, Say], TraceState]
"""Makes the next state and leaves the one before it as it is."""

STEPS: tuple[tuple[str, Step], ...] = (
    ("each effect alone", each_alone),
    ("the first effect", choose_first),
    ("an effect that acts everywhere", extend_everywhere),
    ("a further effect", further_effects),
    ("effects of the source", couple),
    ("effects that are not needed", prune),
    ("all effects together", judge_again),
    ("offsets at their limit", refuse_offsets),
    ("left-out stretches", by_stretches),
    ("effects that would run away", refuse_runaway),
)
"""What is done in which order; the names are for the user who waits."""


def trace(coefficients: Coefficients, runs: Sequence[Condensed], progress: Say = lambda _: None) -> Tracing:
    """Explain the residual of a baseline in some runs, by the steps of `STEPS` in their order.

    Parameters
    ----------
    coefficients
        The baseline.
    runs
        Runs to fit, condensed with it.
    progress
        Called with what is being done: the name of the step, and what it is at.
    """
    state = beginning(coefficients, runs)
    for name, step in STEPS:
        progress(name)
        state = step(state, _under(name, progress))
    return state.tracing()


def _under(step: str, progress: Say) -> Say:
    return lambda detail: progress(f"{step}: {detail}")
