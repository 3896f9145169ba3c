"""What the refinement of a network comes to, from what was left out of its fits."""

from __future__ import annotations

import numpy as np

from gen.refinement.network.effects.warm_start import WarmStart
from gen.refinement.network.trace import Traced
from gen.refinement.verdict import EXPLAINED, NOTHING, Verdict


def network_verdict(traced: Traced, start: WarmStart, *, anything: bool, holds: bool) -> Verdict:
    """Give the verdict from what was left out of the fits alone.

    Parameters
    ----------
    traced
        What was found.
    start
        And what starts are wrong by.
    anything
        Whether anything was.
    holds
        Whether the file may hold all of it: what it does not hold it does not explain.
    """
    worst = _worst_sensor(traced)
    if not anything:
        return "nothing missing" if max(traced.null.floors, start.floors, worst) <= NOTHING else "unexplained"
    near = max(traced.final.floors, start.floors) <= EXPLAINED and worst <= NOTHING
    return "explained" if near and holds else "partly explained"


def _worst_sensor(traced: Traced) -> float:
    """The largest left-out error of one sensor in its noise floors."""
    data, error = traced.data, traced.final.error
    cover = np.where(np.isfinite(error), data.inputs.covered, 0.0)
    square = np.sum(cover * np.nan_to_num(error) ** 2, axis=0) / np.maximum(cover.sum(axis=0), 1e-9)
    noise = np.maximum(np.mean([run.noise_K**2 for run in data.inputs.runs[: data.later]], axis=0), 0.05**2)
    return float(np.sqrt(np.max((square + noise) / noise)))
