"""Judging by left-out stretches, where each speed was run once and no whole run can be left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.model.effects import Effect, Setting, Variant, registry
from gen.refinement.parts.candidates import Candidate
from gen.refinement.parts.judgement import judge
from gen.refinement.parts.simulation_fit import Term, fit
from gen.refinement.parts.stacked_runs import StackedRuns

STRETCHES = 18
"""Blocks of each run where only stretches can be left out."""


def by_stretch(single: StackedRuns, known: Setting, tried: int) -> Candidate | None:
    """The best effect of single speeds, by left-out stretches (thirds of each run): a weaker test, said to be one."""
    made = [
        _judged(single, effect, variant, tried)
        for effect in registry().values()
        if effect.of_single_speeds and (variant := effect.local(known)) is not None
    ]
    accepted = [candidate for candidate in made if candidate.judgement.accepted]
    return min(accepted, key=lambda candidate: candidate.loss, default=None)


def _judged(single: StackedRuns, effect: Effect, variant: Variant, tried: int) -> Candidate:
    length = single.blocks.shape[0]
    sizes = np.sum(single.blocks >= 0, axis=0)
    thirds = np.minimum(np.arange(length)[:, None] * 3 // np.maximum(sizes, 1), 2)
    number = np.arange(length)[:, None] * STRETCHES // np.maximum(sizes, 1) + STRETCHES * np.arange(sizes.size)
    blocks = np.where(single.blocks >= 0, number, -1)
    # A constant offset cannot be told from a schedule by steps from cold.
    cut = replace(single, left_out=np.stack([thirds == f for f in range(3)]), blocks=blocks, tolerance_K=0.0)
    fitted = fit(cut, [Term(effect, variant, tuple(f.start for f in variant.free))])
    verdict = judge(cut, 0, fit(cut, []), fitted, tried, 0)
    return Candidate(effect, variant, fitted, 0, verdict, by_stretch=True)
