"""At which speeds a transfer function can be identified: held ones, if the runs say enough about each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import IntArray
from gen.identification.logs.data import held_speeds, quantile_speeds
from gen.identification.logs.records import Record
from gen.identification.parts.orders import StructureCandidate, beats, candidate_of, folds_of
from gen.identification.parts.output_error import OutputErrorProblem
from gen.identification.parts.start import first_order

PLENTY = 1.5
"""Held speeds are taken without more ado when each is held for this many time constants in all .."""
AT_ONCE = 0.8
""".. or for this many at once, or when every run holds one speed only (a step from cold, perhaps with its cooling)."""
ENOUGH = 0.7
"""A speed that is held for less cannot tell its steady rise from its time constant."""
SEEN = 2.0
"""A gain has to be this many standard deviations above zero."""


@dataclass(frozen=True, eq=False)
class Speeds:
    """The chosen nodes.

    Attributes
    ----------
    nodes
        |PWM|, increasing, with 0 where cooling was seen.
    range
        |PWM| range above 0 that the runs cover.
    held
        Whether the nodes are held speeds; else they span what occurs.
    """

    nodes: IntArray
    range: tuple[int, int]
    held: bool


def choose_speeds(records: Sequence[Record], fastest: float) -> Speeds:
    """Choose the nodes of one component.

    Parameters
    ----------
    records
        Its records.
    fastest
        Shortest time constant, s.
    """
    low, middle, high = (int(quantile_speeds(records, (q,))[0]) for q in (0.02, 0.5, 0.98))
    held = held_speeds(records)
    total, longest = _holds(records)
    single = np.array([middle], dtype=np.int64)
    rough = OutputErrorProblem(records, single, fastest)
    tau = float(np.exp(first_order(rough).theta[0, 0]))
    if held.size:
        steps = all(np.unique(r.segments.pwm[r.segments.pwm != 0]).size <= 1 for r in records)
        if steps or all(total[int(p)] >= PLENTY * tau or longest[int(p)] >= AT_ONCE * tau for p in held):
            return Speeds(held, _range(held), held=True)
        held = np.array([p for p in held if total[int(p)] >= ENOUGH * tau], dtype=np.int64)
    options = [(single, (low, high), False)]
    spanning = quantile_speeds(records, (0.02, 0.5, 0.98))
    if len(spanning) > 1:
        options.append((spanning, (low, high), False))
    if np.count_nonzero(held):
        options.append((held, _range(held), True))
    chosen, best = options[0], _judged(records, options[0][0], fastest)
    for option in options[1:]:
        candidate = _judged(records, option[0], fastest)
        if not candidate.rejected and not without_gain(candidate).size and beats(candidate, best):
            chosen, best = option, candidate
    return Speeds(*chosen)


def _holds(records: Sequence[Record]) -> tuple[dict[int, float], dict[int, float]]:
    """Total and longest time at each held |PWM|, s."""
    total: dict[int, float] = {}
    longest: dict[int, float] = {}
    for record in records:
        for pwm, length in record.segments.dwell().items():
            total[pwm] = total.get(pwm, 0.0) + length
        for pwm, length in zip(record.segments.pwm.tolist(), record.segments.length.tolist(), strict=True):
            longest[pwm] = max(longest.get(pwm, 0.0), length)
    return total, longest


def _range(nodes: IntArray) -> tuple[int, int]:
    positive = nodes[nodes > 0]
    return int(positive[0]), int(positive[-1])


def _judged(records: Sequence[Record], nodes: IntArray, fastest: float) -> StructureCandidate:
    problem = OutputErrorProblem(records, nodes, fastest)
    return candidate_of(problem, first_order(problem), *folds_of(problem)[:2])


def without_gain(candidate: StructureCandidate) -> IntArray:
    """Give the speeds at which the gain is not seen to be above zero."""
    layout = candidate.fit.layout
    deviation = candidate.uncertainty.deviation[layout.thetas : layout.thetas + len(layout.positive)]
    return layout.positive[candidate.fit.steady <= SEEN * deviation]
