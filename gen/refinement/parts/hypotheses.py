"""Hypotheses of one round: fitted, judged, ordered, and those that the left-out runs cannot tell apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from gen.model.effects import Effect, Setting, Variant, registry
from gen.refinement.parts.candidates import Candidate
from gen.refinement.parts.judgement import TIE_LEVEL, judge, p_better
from gen.refinement.parts.simulation_fit import HypothesisFit, Term, fit
from gen.refinement.parts.stacked_runs import StackedRuns

_NEAR = 1.02

Hypothesis = tuple[Effect, Variant]


def hypotheses_for(known: Setting) -> list[Hypothesis]:
    """All that the library has to say to these data."""
    return [(effect, variant) for effect in registry().values() for variant in effect.variants(known)]


def first_round(
    single: StackedRuns,
    hypotheses: Sequence[Hypothesis],
    null: HypothesisFit,
    tried: int,
    progress: Callable[[str], None],
) -> list[Candidate]:
    """Each hypothesis alone, best first."""
    made = []
    for effect, variant in hypotheses:
        progress(effect.name)
        best = min((fit(single, [Term(effect, variant, start)]) for start in _starts(variant)), key=_training)
        made.append(Candidate(effect, variant, best, 0, judge(single, 0, null, best, tried, 0)))
    return sorted(made, key=_penalised)


def further(
    single: StackedRuns, terms: list[Term], current: HypothesisFit, hypotheses: Sequence[Hypothesis], tried: int
) -> list[Candidate]:
    """Each hypothesis beside the terms that there are, all fitted together, best first."""
    have = {term.effect.name for term in terms}
    added = sum(len(term.variant.free) for term in terms)
    made = []
    for effect, variant in hypotheses:
        if effect.name in have:
            continue
        best = min((fit(single, [*terms, Term(effect, variant, start)]) for start in _starts(variant)), key=_training)
        made.append(Candidate(effect, variant, best, 0, judge(single, 0, current, best, tried, added)))
    return sorted(made, key=_penalised)


def material(candidate: Candidate) -> bool:
    """An error within the sensor's tolerance is its nature, not an effect."""
    size = candidate.fit.size(len(candidate.fit.terms) - 1)
    if candidate.effect.tolerance_K is None or size is None:
        return True
    return abs(float(candidate.fit.numbers[candidate.at, size])) > candidate.effect.tolerance_K


def choose(
    singles: dict[str, StackedRuns], results: dict[str, list[Candidate]]
) -> dict[str, tuple[Candidate, list[Candidate]]]:
    """For each component the best accepted hypothesis; of those tied, the one that most components share."""
    ties: dict[str, list[Candidate]] = {}
    for name, candidates in results.items():
        accepted = [c for c in candidates if c.judgement.accepted and material(c)]
        if accepted:
            ties[name] = tied(singles[name], accepted)

    def support(candidate: Candidate) -> int:
        return sum(any(_same(candidate, other) for other in near) for near in ties.values())

    chosen = {}
    for name, near in ties.items():
        best = max(near, key=support)  # the first of equals, so the best of the ties
        chosen[name] = (best, distinct([c for c in near if c.effect.name != best.effect.name]))
    return chosen


def tied(single: StackedRuns, accepted: Sequence[Candidate]) -> list[Candidate]:
    """Those that the left-out runs cannot tell from the best: first those as good, the simplest of them first."""
    best = accepted[0]
    variance = float(single.noise_K[0]) ** 2

    def near(candidate: Candidate) -> bool:
        return (candidate.loss + variance) <= _NEAR**2 * (best.loss + variance)

    tied = [c for c in accepted if near(c) or p_better(single, 0, c.fit, best.fit) > TIE_LEVEL]
    return sorted(tied, key=lambda c: (not near(c), len(c.variant.free) if near(c) else 0, c.loss))


def distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The first of each name."""
    best: dict[str, Candidate] = {}
    for candidate in candidates:
        best.setdefault(candidate.effect.name, candidate)
    return list(best.values())


def terms_of(fitted: HypothesisFit) -> list[Term]:
    """A fit's hypothesis, started where that fit ended."""
    made, at = [], 0
    for term in fitted.terms:
        count = len(term.variant.free)
        made.append(Term(term.effect, term.variant, tuple(float(x) for x in fitted.numbers[0, at : at + count])))
        at += count
    return made


def _starts(variant: Variant) -> list[tuple[float, ...]]:
    plain = tuple(f.start for f in variant.free)
    slow = [f.role == "time constant" for f in variant.free]
    if not any(slow):
        return [plain, *variant.also]
    return [plain, tuple(max(f.start * 0.2, f.low) if s else f.start for f, s in zip(variant.free, slow, strict=True))]


def _training(fitted: HypothesisFit) -> float:
    return float(np.mean(fitted.error**2))


def _penalised(candidate: Candidate) -> float:
    return candidate.loss * (1.0 + 0.02 * len(candidate.variant.free))


def _same(one: Candidate, other: Candidate) -> bool:
    """Whether two components have one effect, through the same channels: another component is another one for each."""
    through = [[name for _, name in c.effect.reads(c.variant.fixed, "channel")] for c in (one, other)]
    return one.effect is other.effect and through[0] == through[1]
