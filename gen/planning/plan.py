"""`gen plan`: from a network and its runs to the run that tells most."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import numpy as np

from gen.arrays import IntArray
from gen.coefficients import Coefficients
from gen.identification.network.fitting.inputs import held
from gen.planning.expected import Expected
from gen.planning.hypotheses import Remaining, remaining
from gen.planning.intervals import intervals
from gen.planning.limits import Limits, Wishes, limits_of
from gen.planning.planned_run import Plan, Told
from gen.planning.search import BINS, Search, grid_of, time_constants
from gen.planning.stage import Stage
from gen.refinement.network.prepared import prepared
from gen.refinement.network.tracing.trace import trace

TIGHT = 2.0
"""Noise floors within which all predicted readings of the one hypothesis that is left must be known (95 %) for nothing
to be decided."""


def plan_run(
    coefficients: Coefficients,
    paths: Sequence[Path],
    wishes: Wishes,
    progress: Callable[[str], None],
) -> Plan:
    """Plan the run that tells most.

    Parameters
    ----------
    coefficients
        A file with a network (another is refused before).
    paths
        The runs that there are.
    wishes
        Length and limits.
    progress
        Called with what is being done.

    Raises
    ------
    InputError
        For files that are no runs, a network that cannot be refined, or limits that no run can keep.
    """
    _, data, shape, warnings = prepared(coefficients, paths, progress)
    traced = trace(data, shape, progress)
    progress("what remains")
    left = remaining(traced)
    limits = limits_of(coefficients, wishes, data, left)
    later = data.inputs.ambient[data.is_later]
    ambient = float(np.mean(later)) if wishes.ambient_degC is None else wishes.ambient_degC
    full_scale = coefficients.document.input.full_scale
    half = held(np.array([0.5 * max(limits.levels)]), full_scale)
    further = data.inputs.levels.further[:1]
    times = time_constants(left.hypotheses[0], replace(half, further=further))
    grid = grid_of(times, 3600.0 * wishes.hours)
    noise = np.mean([run.noise_K for run in data.inputs.runs[: data.later]], axis=0)
    expected = Expected(left, Stage(data, full_scale, ambient, grid.bin_s, noise), limits.levels)
    progress(f"runs that tell {len(left.hypotheses)} hypotheses apart")
    sought = Search(expected, limits, grid, wishes.seed).run()
    progress("what the run is expected to tell")
    return _plan(expected, limits, grid.block_s, (sought.best, sought.plain), warnings)


def _plan(
    expected: Expected, limits: Limits, block_s: float, runs: tuple[IntArray, IntArray], warnings: Sequence[str]
) -> Plan:
    best, plain = runs
    left: Remaining = expected.remaining
    bins = np.repeat(best, BINS)
    planned_K, plain_K = (expected.whole(np.repeat(run, BINS)).left_K for run in runs)
    told = [Told(i, j, float(a), float(b)) for (i, j), a, b in zip(expected.pairs, planned_K, plain_K, strict=True)]
    readings = expected.readings_95_K(bins)
    shape = left.hypotheses[0].shape
    return Plan(
        holds=_holds(expected.levels[best], block_s),
        plain=_holds(expected.levels[plain], block_s),
        hypotheses=left.hypotheses,
        beside=left.beside,
        told=tuple(told),
        intervals=intervals(left.hypotheses[0], *expected.deviations(bins)),
        readings_95_K=readings,
        hottest=expected.hottest(bins[None])[0],
        limits=limits.hottest,
        names=shape.names[: shape.base_nodes],
        noise_K=left.noise_K,
        decided=len(left.hypotheses) == 1 and readings[0] <= TIGHT * left.noise_K,
        warnings=tuple(warnings),
    )


def _holds(blocks: IntArray, block_s: float) -> tuple[tuple[int, float], ...]:
    """What is held for how long; times in whole seconds."""
    ends, made, begin, at = block_s * np.arange(1, blocks.size + 1), [], 0.0, 0
    for level, group in groupby(blocks.tolist()):
        at += len(list(group))
        end = float(round(ends[at - 1]))
        made.append((int(level), end - begin))
        begin = end
    return tuple(made)
