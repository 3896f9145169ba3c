"""Tracing a residual: hypotheses fitted, compared on left-out runs, added one by one, named with their look-alikes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from gen.coefficients import Coefficients
from gen.model.effects.integrate import readings
from gen.refinement.candidates import Candidate, Found, Tracing
from gen.refinement.condense import Condensed
from gen.refinement.hypotheses import choose, first_round, hypotheses_for, terms_of
from gen.refinement.judged_on_stretches import by_stretch
from gen.refinement.judgement import LEAST_GAIN, TIE_LEVEL, judge, p_better, told_from_none
from gen.refinement.offered import each_speed_once, offered
from gen.refinement.pairs import pair, third
from gen.refinement.simulation_fit import HypothesisFit, Term, fit
from gen.refinement.stacked_runs import StackedRuns, stack_runs

MOST_EFFECTS = 3
"""Most effects at one component: what is left after three is said to be unexplained."""


def trace(
    coefficients: Coefficients, runs: Sequence[Condensed], progress: Callable[[str], None] = lambda _: None
) -> Tracing:
    """Explain the residual of a baseline in some runs.

    Each hypothesis is fitted to each component whose residual is over the sensor's noise. Of those that the
    left-out runs cannot tell from the best, the one that other components support as well is taken. Where a
    rest is left, the three best are each tried with every second effect, which finds pairs that hide each
    other, then a third is tried.

    Parameters
    ----------
    coefficients
        The baseline.
    runs
        Runs to fit, condensed with it.
    progress
        Called with what is being done.
    """
    whole = stack_runs(coefficients, runs)
    singles = {name: whole.only(name) for name in whole.components}
    null = {name: fit(one, []) for name, one in singles.items()}
    hypotheses = {name: hypotheses_for(offered(coefficients, runs, whole, name)) for name in whole.components}
    tried = sum(len(h) for h in hypotheses.values())
    if each_speed_once(runs):  # then a left-out run says nothing of its speed's schedule: judged by stretches, below
        hypotheses = {n: [h for h in all_ if not h[0].of_single_speeds] for n, all_ in hypotheses.items()}
    final = dict(null)
    found: list[Found] = []
    considered: dict[str, list[Candidate]] = {}
    for name, one in singles.items():
        if worth_tracing(one, null[name]):
            considered[name] = first_round(one, hypotheses[name], null[name], tried, partial(_say, progress, name))
    for name, chosen in choose(singles, considered).items():
        found.append(Found(name, chosen[0], chosen[1]))
        final[name] = chosen[0].fit
    _extend_everywhere(singles, found, final, null, tried)
    for name, one in singles.items():
        # Steps from cold at one speed each are too alike to tell two effects apart.
        for _ in range(0 if each_speed_once(runs) else MOST_EFFECTS - 1):
            if name not in considered or not worth_tracing(one, final[name]):
                break
            progress(f"{name}: a further effect?")
            before = len(final[name].terms)
            own = [f for f in found if f.component == name]
            if before <= 1 and not any(f.candidate.effect.everywhere for f in own):
                better = pair(one, hypotheses[name], null[name], final[name], considered[name], tried)
            else:
                better = third(one, hypotheses[name], final[name], tried)
            if not better:
                break
            if len(better) == 2:
                found = [f for f in found if f.component != name]
            found += [Found(name, candidate, ties) for candidate, ties in better]
            final[name] = better[-1][0].fit
    _couple(whole, singles, final)
    _prune(singles, final, found)
    _judge_again(singles, final, null, found, tried)
    _refuse_offsets_at_their_limit(singles, final, null, found, tried)
    if each_speed_once(runs):
        for name, one in singles.items():
            if name in considered and not final[name].terms:
                entry = by_stretch(one, offered(coefficients, runs, whole, name), tried)
                if entry is not None:
                    considered[name].insert(0, entry)
                    found.append(Found(name, entry, []))
                    final[name] = entry.fit
    found.sort(key=lambda f: -_importance(whole, f))
    return Tracing(whole, found, final, null, considered, tried)


def worth_tracing(single: StackedRuns, fitted: HypothesisFit) -> bool:
    """Whether an effect that explained all that is left could lower the RMSE by what an effect must at least."""
    variance = float(single.noise_K[0]) ** 2
    w = single.weight[:, 0, 0, :]
    of_noise = variance * np.count_nonzero(w) / max(float(w.sum()), 1.0)
    left = max(float(fitted.loss[0]) - of_noise, 0.0)
    return float(np.sqrt(variance / (variance + left))) < 1.0 - LEAST_GAIN


def _say(progress: Callable[[str], None], component: str, effect: str) -> None:
    progress(f"{component}: {effect}?")


def _judge_again(
    singles: dict[str, StackedRuns],
    final: dict[str, HypothesisFit],
    null: dict[str, HypothesisFit],
    found: list[Found],
    tried: int,
) -> None:
    """All of a component's effects together must pass the test against none, whatever the way to them was."""
    for name, single in singles.items():
        if not _passes(single, name, null[name], final[name], found, tried):
            found[:] = [f for f in found if f.component != name]
            final[name] = null[name]


def _refuse_offsets_at_their_limit(
    singles: dict[str, StackedRuns],
    final: dict[str, HypothesisFit],
    null: dict[str, HypothesisFit],
    found: list[Found],
    tried: int,
) -> None:
    """Drawn to its limit an offset stands for something else; it is no calibration, and effects must do without it."""
    for name, single in singles.items():
        if not final[name].terms or abs(float(final[name].offset[0])) <= 0.95 * single.tolerance_K:
            continue
        exact = replace(single, tolerance_K=0.0)
        made = fit(exact, terms_of(final[name]))
        if _passes(exact, name, fit(exact, []), made, found, tried):
            final[name] = made
        else:
            found[:] = [f for f in found if f.component != name]
            final[name] = null[name]


def _passes(
    single: StackedRuns, name: str, without: HypothesisFit, together: HypothesisFit, found: list[Found], tried: int
) -> bool:
    own = [f for f in found if f.component == name]
    if not own or any(f.candidate.effect.everywhere for f in own):
        return True
    return all("worse" in r for r in judge(single, 0, without, together, tried, 0).reasons)


def _extend_everywhere(
    singles: dict[str, StackedRuns],
    found: list[Found],
    final: dict[str, HypothesisFit],
    null: dict[str, HypothesisFit],
    tried: int,
) -> None:
    """What acts on most components by its nature acts on the others, too, even where another effect hides it."""
    for name in {f.candidate.effect.name for f in found if f.candidate.effect.everywhere}:
        own = [f for f in found if f.candidate.effect.name == name]
        if 2 * len(own) < len(singles):
            continue
        pattern = own[0].candidate
        for component, one in singles.items():
            if any(f.component == component for f in own):
                continue
            start = tuple(f.start for f in pattern.variant.free)
            made = fit(one, [Term(pattern.effect, pattern.variant, start)])
            verdict = judge(one, 0, null[component], made, tried, 0)
            found[:] = [f for f in found if f.component != component]
            found.append(Found(component, Candidate(pattern.effect, pattern.variant, made, 0, verdict), []))
            final[component] = made


def _couple(whole: StackedRuns, singles: dict[str, StackedRuns], final: dict[str, HypothesisFit]) -> None:
    """Fit once more where a component's source is another one whose own effects were found meanwhile."""
    changed = {name: _rise(singles[name], f) for name, f in final.items() if f.terms}
    for name, f in list(final.items()):
        sources = {part for term in f.terms for _, part in term.effect.reads(term.variant.fixed, "component")}
        if sources & set(changed):
            singles[name] = singles[name].with_others({k: v for k, v in changed.items() if k != name})
            final[name] = fit(singles[name], terms_of(f))


def _rise(single: StackedRuns, fitted: HypothesisFit) -> np.ndarray:
    slots = [(term.effect, values) for term, values in zip(fitted.terms, fitted.values(0), strict=True)]
    rise = readings(slots, single.track)[0]
    return np.asarray(np.broadcast_to(rise, (rise.shape[0], 1, 1, single.residual.shape[-1]))[:, 0, 0, :])


def _prune(singles: dict[str, StackedRuns], final: dict[str, HypothesisFit], found: list[Found]) -> None:
    """Drop an effect that a later one has made needless (without it the left-out error is no larger) or unknowable."""
    for name, single in singles.items():
        at = 0
        while len(final[name].terms) > 1 and at < len(final[name].terms):
            terms = terms_of(final[name])
            without = fit(single, [term for i, term in enumerate(terms) if i != at])
            variance = float(single.noise_K[0]) ** 2
            grows = (float(without.loss[0]) + variance) > 1.05**2 * (float(final[name].loss[0]) + variance)
            known = _known(final[name], at)
            if known and grows and p_better(single, 0, without, final[name]) < TIE_LEVEL:
                at += 1
                continue
            dropped = terms[at].effect.name
            final[name] = without
            found[:] = [f for f in found if (f.component, f.candidate.effect.name) != (name, dropped)]
            at = 0


def _known(fitted: HypothesisFit, at: int) -> bool:
    """Whether the size of effect number `at` can be told from none beside the others."""
    size = fitted.size(at)
    return size is None or told_from_none(fitted, 0, size)


def _importance(whole: StackedRuns, entry: Found) -> float:
    j = entry.candidate.judgement
    c = whole.components.index(entry.component)
    return (j.before_K**2 - j.after_K**2) / float(whole.noise_K[c]) ** 2
