"""A second and a third effect at one component: two can hide each other, so pairs are tried together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gen.refinement.parts.candidates import Candidate
from gen.refinement.parts.hypotheses import Hypothesis, distinct, further, material, terms_of, tied
from gen.refinement.parts.judgement import TIE_LEVEL, judge, p_better
from gen.refinement.parts.simulation_fit import HypothesisFit
from gen.refinement.parts.stacked_runs import StackedRuns

SEEDS = 3
"""First effects that are each tried with every second one."""


def pair(
    single: StackedRuns,
    hypotheses: Sequence[Hypothesis],
    null: HypothesisFit,
    current: HypothesisFit,
    first: Sequence[Candidate],
    tried: int,
) -> list[tuple[Candidate, list[Candidate]]]:
    """The best two effects together, if they beat what there is."""
    seeds: dict[str, Candidate] = {}
    for candidate in first:
        if float(candidate.loss) < 0.9 * float(null.loss[0]) and len(seeds) < SEEDS:
            seeds.setdefault(candidate.label, candidate)
    pairs: list[tuple[Candidate, Candidate, list[Candidate]]] = []
    for seed in seeds.values():
        seconds = further(single, terms_of(seed.fit), seed.fit, hypotheses, tried * SEEDS)
        good = [c for c in seconds if c.judgement.accepted and material(c)]
        if good:
            ties = tied(single, good)
            pairs.append((seed, ties[0], ties[1:]))
    for seed, second, ties in sorted(pairs, key=lambda pair: pair[1].loss):
        together = judge(single, 0, null, second.fit, tried * SEEDS, 0)
        left = [r for r in together.reasons if "worse" not in r]
        gains = p_better(single, 0, current, second.fit) < TIE_LEVEL / SEEDS
        if left or not gains or float(second.fit.loss[0]) > 0.9 * float(current.loss[0]):
            continue
        alone = replace(seed, fit=second.fit, judgement=replace(seed.judgement, reasons=()))
        others = [c for c in ties if c.effect.name not in (seed.effect.name, second.effect.name)]
        return [(alone, []), (second, distinct(others))]
    return []


def third(
    single: StackedRuns, hypotheses: Sequence[Hypothesis], current: HypothesisFit, tried: int
) -> list[tuple[Candidate, list[Candidate]]]:
    """The best further effect beside those that there are, if it passes."""
    good = [
        c
        for c in further(single, terms_of(current), current, hypotheses, tried)
        if c.judgement.accepted and material(c)
    ]
    if not good:
        return []
    ties = tied(single, good)
    return [(ties[0], distinct([c for c in ties[1:] if c.effect.name != ties[0].effect.name]))]
