"""Tracing a residual: hypotheses fitted, compared on left-out runs, added one by one, named with their look-alikes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gen.coefficients import Coefficients
from gen.loop.evidence import LEAST_GAIN, LEVEL, TIE_LEVEL, Judgement, judge, p_better
from gen.loop.fit import Fit, Term, fit
from gen.loop.problem import Problem, problem
from gen.loop.residual import Condensed
from gen.loop.setting import each_speed_once, setting
from gen.model.effects import Effect, Setting, Variant, registry
from gen.model.effects.integrate import readings
from gen.model.effects.schedule_error import ScheduleError
from gen.model.effects.sensor_offset import SensorOffset

MOST_EFFECTS = 3
"""Most effects at one component: what is left after three is said to be unexplained."""
STRETCHES = 18
"""Blocks of each run where only stretches can be left out."""
SEEDS = 3
"""First effects that are each tried with every second one."""
_NEAR = 1.02


@dataclass(frozen=True)
class Candidate:
    """A hypothesis with what the data say of it."""

    effect: Effect
    variant: Variant
    fit: Fit
    at: int
    """Index of its component in the fit."""
    judgement: Judgement
    by_stretch: bool = False
    """Judged on left-out stretches of runs, as each speed was run once only."""

    @property
    def loss(self) -> float:
        """Left-out squared error, K^2."""
        return float(self.fit.loss[self.at])

    @property
    def label(self) -> str:
        """Name and what it acts through."""
        through = self.variant.fixed.get("channel") or self.variant.fixed.get("source")
        return f"{self.effect.name} ({through})" if through else self.effect.name


@dataclass
class Found:
    """An accepted effect."""

    component: str
    candidate: Candidate
    lookalikes: list[Candidate]


@dataclass
class Tracing:
    """Everything that was found and considered.

    Parameters
    ----------
    problem
        The data.
    found
        Accepted effects, most important first.
    final
        Last fit by component.
    null
        Fit without any effect by component.
    considered
        The first round's hypotheses by component, best first.
    tried
        How many hypotheses there were.
    """

    problem: Problem
    found: list[Found]
    final: dict[str, Fit]
    null: dict[str, Fit]
    considered: dict[str, list[Candidate]]
    tried: int

    @property
    def level(self) -> float:
        """The level of each test, corrected for the number of hypotheses."""
        return LEVEL / max(self.tried, 1)

    def own_ratio(self, name: str, fits: dict[str, Fit]) -> float:
        """The same ratio as :meth:`ratio` at one component."""
        variance = float(self.problem.noise_K[self.problem.components.index(name)]) ** 2
        return float(np.sqrt((float(fits[name].loss[0]) + variance) / variance))

    def ratio(self, fits: dict[str, Fit]) -> float:
        """RMSE on left-out runs over the noise floor, all components together."""
        squares = []
        for c, name in enumerate(self.problem.components):
            variance = float(self.problem.noise_K[c]) ** 2
            squares.append((float(fits[name].loss[0]) + variance) / variance)
        return float(np.sqrt(np.mean(squares)))


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
    whole = problem(coefficients, runs)
    singles = {name: whole.only(name) for name in whole.components}
    null = {name: fit(one, []) for name, one in singles.items()}
    hypotheses = {name: _hypotheses(setting(coefficients, runs, whole, name)) for name in whole.components}
    tried = sum(len(h) for h in hypotheses.values())
    if each_speed_once(runs):  # then a left-out run says nothing of its speed's schedule: judged by stretches, below
        hypotheses = {n: [h for h in all_ if h[0].name != "schedule_error"] for n, all_ in hypotheses.items()}
    final = dict(null)
    found: list[Found] = []
    considered: dict[str, list[Candidate]] = {}
    for name, one in singles.items():
        if worth_tracing(one, null[name]):
            considered[name] = _first_round(one, hypotheses[name], null[name], tried, partial(_say, progress, name))
    for name, chosen in _choose(singles, considered).items():
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
                better = _pair(one, hypotheses[name], null[name], final[name], considered[name], tried)
            else:
                better = _third(one, hypotheses[name], final[name], tried)
            if not better:
                break
            if len(better) == 2:
                found = [f for f in found if f.component != name]
            found += [Found(name, candidate, ties) for candidate, ties in better]
            final[name] = better[-1][0].fit
    _couple(whole, singles, final)
    _prune(singles, final, found)
    _judge_again(singles, final, null, found, tried)
    for name, one in singles.items():
        if final[name].terms and abs(float(final[name].offset[0])) > 0.95 * one.tolerance_K:
            # Drawn to its limit the offset stands for something else; it is no calibration.
            final[name] = fit(replace(one, tolerance_K=0.0), _terms(final[name]))
    if each_speed_once(runs):
        for name, one in singles.items():
            if name in considered and not final[name].terms:
                entry = _by_stretch(one, setting(coefficients, runs, whole, name), tried)
                if entry is not None:
                    found.append(Found(name, entry, []))
                    final[name] = entry.fit
    found.sort(key=lambda f: -_importance(whole, f))
    return Tracing(whole, found, final, null, considered, tried)


def _say(progress: Callable[[str], None], component: str, effect: str) -> None:
    progress(f"{component}: {effect}?")


def _judge_again(
    singles: dict[str, Problem], final: dict[str, Fit], null: dict[str, Fit], found: list[Found], tried: int
) -> None:
    """All of a component's effects together must pass the test against none, whatever the way to them was."""
    for name, single in singles.items():
        own = [f for f in found if f.component == name]
        if not own or any(f.candidate.effect.everywhere for f in own):
            continue
        if any("worse" not in r for r in judge(single, 0, null[name], final[name], tried, 0).reasons):
            found[:] = [f for f in found if f.component != name]
            final[name] = null[name]


def _by_stretch(single: Problem, known: Setting, tried: int) -> Candidate | None:
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


def _pair(
    single: Problem,
    hypotheses: Sequence[tuple[Effect, Variant]],
    null: Fit,
    current: Fit,
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
        further = _further(single, _terms(seed.fit), seed.fit, hypotheses, tried * SEEDS)
        good = [c for c in further if c.judgement.accepted and _material(c)]
        if good:
            ties = _tied(single, good)
            pairs.append((seed, ties[0], ties[1:]))
    for seed, second, ties in sorted(pairs, key=lambda pair: pair[1].loss):
        together = judge(single, 0, null, second.fit, tried * SEEDS, 0)
        left = [r for r in together.reasons if "worse" not in r]
        gains = p_better(single, 0, current, second.fit) < TIE_LEVEL / SEEDS
        if left or not gains or float(second.fit.loss[0]) > 0.9 * float(current.loss[0]):
            continue
        alone = replace(seed, fit=second.fit, judgement=replace(seed.judgement, reasons=()))
        others = [c for c in ties if c.effect.name not in (seed.effect.name, second.effect.name)]
        return [(alone, []), (second, _distinct(others))]
    return []


def _third(
    single: Problem, hypotheses: Sequence[tuple[Effect, Variant]], current: Fit, tried: int
) -> list[tuple[Candidate, list[Candidate]]]:
    good = [
        c
        for c in _further(single, _terms(current), current, hypotheses, tried)
        if c.judgement.accepted and _material(c)
    ]
    if not good:
        return []
    ties = _tied(single, good)
    return [(ties[0], _distinct([c for c in ties[1:] if c.effect.name != ties[0].effect.name]))]


def _distinct(candidates: Sequence[Candidate]) -> list[Candidate]:
    best: dict[str, Candidate] = {}
    for candidate in candidates:
        best.setdefault(candidate.effect.name, candidate)
    return list(best.values())


def _extend_everywhere(
    singles: dict[str, Problem], found: list[Found], final: dict[str, Fit], null: dict[str, Fit], tried: int
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


def _couple(whole: Problem, singles: dict[str, Problem], final: dict[str, Fit]) -> None:
    """Fit once more where a component's source is another one whose own effects were found meanwhile."""
    changed = {name: _rise(singles[name], f) for name, f in final.items() if f.terms}
    for name, f in list(final.items()):
        sources = {str(term.variant.fixed.get("source")) for term in f.terms}
        if sources & set(changed):
            singles[name] = singles[name].with_others({k: v for k, v in changed.items() if k != name})
            final[name] = fit(singles[name], _terms(f))


def worth_tracing(single: Problem, fitted: Fit) -> bool:
    """Whether an effect that explained all that is left could lower the RMSE by what an effect must at least."""
    variance = float(single.noise_K[0]) ** 2
    w = single.weight[:, 0, 0, :]
    of_noise = variance * np.count_nonzero(w) / max(float(w.sum()), 1.0)
    left = max(float(fitted.loss[0]) - of_noise, 0.0)
    return float(np.sqrt(variance / (variance + left))) < 1.0 - LEAST_GAIN


def _hypotheses(known: Setting) -> list[tuple[Effect, Variant]]:
    return [(effect, variant) for effect in registry().values() for variant in effect.variants(known)]


def _starts(variant: Variant) -> list[tuple[float, ...]]:
    plain = tuple(f.start for f in variant.free)
    if not any("tau" in f.name for f in variant.free):
        return [plain, *variant.also]
    return [plain, tuple(max(f.start * 0.2, f.low) if "tau" in f.name else f.start for f in variant.free)]


def _first_round(
    single: Problem,
    hypotheses: Sequence[tuple[Effect, Variant]],
    null: Fit,
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


def _training(fitted: Fit) -> float:
    return float(np.mean(fitted.error**2))


def _further(
    single: Problem, terms: list[Term], current: Fit, hypotheses: Sequence[tuple[Effect, Variant]], tried: int
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


def _penalised(candidate: Candidate) -> float:
    return candidate.loss * (1.0 + 0.02 * len(candidate.variant.free))


def _material(candidate: Candidate) -> bool:
    """An offset within the sensor's tolerance is its nature, not an effect."""
    if not isinstance(candidate.effect, SensorOffset):
        return True
    return abs(float(candidate.fit.numbers[candidate.at, -1])) > SensorOffset.TOLERANCE_K


def _choose(
    singles: dict[str, Problem], results: dict[str, list[Candidate]]
) -> dict[str, tuple[Candidate, list[Candidate]]]:
    """For each component the best accepted hypothesis; of those tied, the one that most components share."""
    ties: dict[str, list[Candidate]] = {}
    for name, candidates in results.items():
        accepted = [c for c in candidates if c.judgement.accepted and _material(c)]
        if accepted:
            ties[name] = _tied(singles[name], accepted)

    def support(candidate: Candidate) -> int:
        return sum(any(_same(candidate, other) for other in near) for near in ties.values())

    chosen = {}
    for name, near in ties.items():
        best = max(near, key=support)  # the first of equals, so the best of the ties
        chosen[name] = (best, _distinct([c for c in near if c.effect.name != best.effect.name]))
    return chosen


def _same(one: Candidate, other: Candidate) -> bool:
    keys = ("channel", "source")
    return one.effect.name == other.effect.name and (
        one.effect.name == "coupling" or all(one.variant.fixed.get(k) == other.variant.fixed.get(k) for k in keys)
    )


def _tied(single: Problem, accepted: Sequence[Candidate]) -> list[Candidate]:
    """Those that the left-out runs cannot tell from the best: first those as good, the simplest of them first."""
    best = accepted[0]
    variance = float(single.noise_K[0]) ** 2

    def near(candidate: Candidate) -> bool:
        return (candidate.loss + variance) <= _NEAR**2 * (best.loss + variance)

    tied = [c for c in accepted if near(c) or p_better(single, 0, c.fit, best.fit) > TIE_LEVEL]
    return sorted(tied, key=lambda c: (not near(c), len(c.variant.free) if near(c) else 0, c.loss))


def _terms(fitted: Fit) -> list[Term]:
    made, at = [], 0
    for term in fitted.terms:
        count = len(term.variant.free)
        made.append(Term(term.effect, term.variant, tuple(float(x) for x in fitted.numbers[0, at : at + count])))
        at += count
    return made


def _rise(single: Problem, fitted: Fit) -> np.ndarray:
    slots = [(term.effect, values) for term, values in zip(fitted.terms, fitted.values(0), strict=True)]
    rise = readings(slots, single.track)[0]
    return np.asarray(np.broadcast_to(rise, (rise.shape[0], 1, 1, single.residual.shape[-1]))[:, 0, 0, :])


def _prune(singles: dict[str, Problem], final: dict[str, Fit], found: list[Found]) -> None:
    """Drop an effect that a later one has made needless: without it the left-out error is no larger."""
    for name, single in singles.items():
        at = 0
        while len(final[name].terms) > 1 and at < len(final[name].terms):
            terms = _terms(final[name])
            without = fit(single, [term for i, term in enumerate(terms) if i != at])
            variance = float(single.noise_K[0]) ** 2
            grows = (float(without.loss[0]) + variance) > 1.05**2 * (float(final[name].loss[0]) + variance)
            if grows and p_better(single, 0, without, final[name]) < TIE_LEVEL:
                at += 1
                continue
            dropped = terms[at].effect.name
            final[name] = without
            found[:] = [f for f in found if (f.component, f.candidate.effect.name) != (name, dropped)]
            at = 0


def _importance(whole: Problem, entry: Found) -> float:
    j = entry.candidate.judgement
    c = whole.components.index(entry.component)
    return (j.before_K**2 - j.after_K**2) / float(whole.noise_K[c]) ** 2
