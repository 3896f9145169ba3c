"""Judging by left-out stretches, where each speed was run once and no whole run can be left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.model.effects import Setting, registry
from gen.model.effects.catalogue.schedule_error import ScheduleError
from gen.refinement.candidates import Candidate
from gen.refinement.judgement import judge
from gen.refinement.simulation_fit import Term, fit
from gen.refinement.stacked_runs import StackedRuns

STRETCHES = 18
"""Blocks of each run where only stretches can be left out."""


def by_stretch(single: StackedRuns, known: Setting, tried: int) -> Candidate | None:
    """A wrong schedule, judged on left-out stretches (thirds of each run): a weaker test, and said to be one."""
    effect = registry()["schedule_error"]
    variant = effect.local(known) if isinstance(effect, ScheduleError) else None
    if variant is None:
        return None
    length = single.blocks.shape[0]
    sizes = np.sum(single.blocks >= 0, axis=0)
    thirds = np.minimum(np.arange(length)[:, None] * 3 // np.maximum(sizes, 1), 2)
    number = np.arange(length)[:, None] * STRETCHES // np.maximum(sizes, 1) + STRETCHES * np.arange(sizes.size)
    blocks = np.where(single.blocks >= 0, number, -1)
    # A constant offset cannot be told from a schedule by steps from cold.
    cut = replace(single, left_out=np.stack([thirds == f for f in range(3)]), blocks=blocks, tolerance_K=0.0)
    fitted = fit(cut, [Term(effect, variant, tuple(f.start for f in variant.free))])
    verdict = judge(cut, 0, fit(cut, []), fitted, tried, 0)
    candidate = Candidate(effect, variant, fitted, 0, verdict, by_stretch=True)
    return candidate if verdict.accepted else None
