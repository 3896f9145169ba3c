"""What the refinement of a network comes to, from what was left out of its fits."""

from __future__ import annotations

from gen.refinement.network.tracing.judged import worst_sensor
from gen.refinement.network.tracing.trace import Traced
from gen.refinement.network.tracing.warm_start import WarmStart
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
    worst = worst_sensor(traced.data, traced.final)
    if not anything:
        return "nothing missing" if max(traced.null.floors, start.floors, worst) <= NOTHING else "unexplained"
    near = max(traced.final.floors, start.floors) <= EXPLAINED and worst <= NOTHING
    return "explained" if near and holds else "partly explained"
