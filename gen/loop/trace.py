"""Tracing a residual: hypotheses fitted, compared on left-out runs, added one by one, named with their look-alikes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gen.coefficients import Coefficients
from gen.loop.evidence import LEAST_GAIN, LEVEL, TIE_LEVEL, Judgement, judge, p_better
from gen.loop.fit import Fit, Term, fit
from gen.loop.problem import Problem, problem
from gen.loop.residual import Condensed
from gen.model.effects import Effect, Setting, Variant, registry
from gen.model.effects.integrate import readings
from gen.model.effects.sensor_offset import SensorOffset

MOST_EFFECTS = 3
"""Most effects at one component: what is left after three is said to be unexplained."""
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
    settings = {name: setting(coefficients, runs, whole, name) for name in whole.components}
    terms: dict[str, list[Term]] = {name: [] for name in whole.components}
    null = {name: fit(one, []) for name, one in singles.items()}
    final = dict(null)
    found: list[Found] = []
    considered: dict[str, list[Candidate]] = {}
    hypotheses = {name: _hypotheses(settings[name]) for name in whole.components}
    tried = sum(len(h) for h in hypotheses.values())
    open_components = [name for name in whole.components if worth_tracing(singles[name], null[name])]
    rounds = 0
    while open_components and rounds < MOST_EFFECTS + 2:
        rounds += 1
        fresh = [name for name in open_components if not terms[name]]
        results: dict[str, list[Candidate]] = {}
        if fresh:
            results |= _first_round(whole, fresh, hypotheses, null, tried, progress)
        for name in open_components:
            if name in fresh:
                continue
            progress(f"{name}: a further effect?")
            results[name] = _further(singles[name], terms[name], final[name], hypotheses[name], tried)
        for name, candidates in results.items():
            considered.setdefault(name, candidates)
        accepted = _choose(singles, results)
        if not accepted:
            break
        for name, best, ties in accepted:
            found.append(Found(name, best, ties))
            terms[name] = _terms(best.fit, best.at)
            final[name] = fit(singles[name], terms[name])
        taken = {name for name, _, _ in accepted}
        rises = {name: _rise(singles[name], final[name]) for name in whole.components if terms[name]}
        singles = {
            name: one.with_others({k: v for k, v in rises.items() if k != name}) for name, one in singles.items()
        }
        open_components = [
            name
            for name in whole.components
            if len(terms[name]) < MOST_EFFECTS
            and worth_tracing(singles[name], final[name])
            and (name in taken or any(c.judgement.accepted for c in results.get(name, [])))
        ]
    _prune(singles, terms, final, found)
    found.sort(key=lambda f: -_importance(whole, f, null))
    return Tracing(whole, found, final, null, considered, tried)


def worth_tracing(single: Problem, fitted: Fit) -> bool:
    """Whether an effect that explained all that is left could lower the RMSE by what an effect must at least."""
    variance = float(single.noise_K[0]) ** 2
    w = single.weight[:, 0, 0, :]
    of_noise = variance * np.count_nonzero(w) / max(float(w.sum()), 1.0)
    left = max(float(fitted.loss[0]) - of_noise, 0.0)
    return float(np.sqrt(variance / (variance + left))) < 1.0 - LEAST_GAIN


def setting(coefficients: Coefficients, runs: Sequence[Condensed], whole: Problem, name: str) -> Setting:
    """What the data offer to explain one component's residual with."""
    model = coefficients.model
    c = whole.components.index(name)
    counts = np.concatenate([np.repeat(np.rint(run.pwm), np.minimum(run.weight, 1.0).astype(int)) for run in runs])
    spans = np.concatenate([np.diff(run.edges) for run in runs])[: counts.size]
    middle = (whole.track.count > 0).any() and np.median(whole.track.rate[:, c][whole.weight[:, c] > 0])
    return Setting(
        component=name,
        others=tuple(other for other in whole.components if other != name),
        channels={key: float(np.sqrt(np.mean(values**2))) for key, values in whole.track.channels.items()},
        levels=_levels(counts, spans),
        rate=float(middle) if middle else float(np.median(whole.track.rate[:, c])),
        ambient_fixed=None if model.ambient_channel is not None else model.ambient_fixed,
        ambient_measured=all(run.measured_ambient is not None for run in runs),
    )


def _levels(counts: np.ndarray, spans: np.ndarray) -> tuple[int, ...]:
    """|PWM| at which the motor ran for at least 3 % of the time, at most eight and not closer than 8 counts."""
    time = np.bincount(counts.astype(int), spans, 256)
    chosen: list[int] = [0] if time[0] > 0.01 * time.sum() else []
    near = np.convolve(time, np.ones(5), mode="same")
    for level in np.argsort(-near):
        if near[level] < 0.03 * time.sum() or len(chosen) >= 9:
            break
        if level > 2 and all(abs(int(level) - other) >= 8 for other in chosen):
            window = np.arange(max(level - 2, 1), min(level + 3, 256))
            chosen.append(int(np.rint(np.average(window, weights=time[window] + 1e-9))))
    return tuple(sorted(chosen))


def _hypotheses(known: Setting) -> list[tuple[Effect, Variant]]:
    return [(effect, variant) for effect in registry().values() for variant in effect.variants(known)]


def _starts(variant: Variant) -> list[tuple[float, ...]]:
    plain = tuple(f.start for f in variant.free)
    if not any("tau" in f.name for f in variant.free):
        return [plain]
    return [plain, tuple(max(f.start * 0.2, f.low) if "tau" in f.name else f.start for f in variant.free)]


def _first_round(
    whole: Problem,
    names: Sequence[str],
    hypotheses: dict[str, list[tuple[Effect, Variant]]],
    null: dict[str, Fit],
    tried: int,
    progress: Callable[[str], None],
) -> dict[str, list[Candidate]]:
    """Each hypothesis at each component; those that only differ in the component are fitted in one go."""
    results: dict[str, list[Candidate]] = {name: [] for name in names}
    singles = {name: whole.only(name) for name in names}
    for name in names:
        for effect, variant in hypotheses[name]:
            progress(f"{name}: {effect.name}?")
            best: Fit | None = None
            for start in _starts(variant):
                made = fit(singles[name], [Term(effect, variant, start)])
                if best is None or float(np.mean(made.error**2)) < float(np.mean(best.error**2)):
                    best = made
            if best is not None:
                verdict = judge(singles[name], 0, null[name], best, tried, 0)
                results[name].append(Candidate(effect, variant, best, 0, verdict))
        results[name].sort(key=_penalised)
    return results


def _further(
    single: Problem, terms: list[Term], current: Fit, hypotheses: Sequence[tuple[Effect, Variant]], tried: int
) -> list[Candidate]:
    have = {term.effect.name for term in terms}
    made = []
    for effect, variant in hypotheses:
        if effect.name in have and effect.name not in ("coupling", "load_heating"):
            continue
        best: Fit | None = None
        for start in _starts(variant):
            new = fit(single, [*terms, Term(effect, variant, start)])
            if best is None or float(np.mean(new.error**2)) < float(np.mean(best.error**2)):
                best = new
        if best is not None:
            added = sum(len(term.variant.free) for term in terms)
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
) -> list[tuple[str, Candidate, list[Candidate]]]:
    """The best accepted hypothesis of the component with the largest gain, and of those that agree with it."""
    ties: dict[str, list[Candidate]] = {}
    for name, candidates in results.items():
        accepted = [c for c in candidates if c.judgement.accepted and _material(c)]
        if accepted:
            ties[name] = _tied(singles[name], accepted)
    if not ties:
        return []

    def gain(candidate: Candidate) -> float:
        return float(np.log(candidate.judgement.before_K / candidate.judgement.after_K))

    def support(candidate: Candidate) -> tuple[int, float]:
        return sum(any(_same(candidate, other) for other in ties[name]) for name in ties), -_penalised(candidate)

    lead = max(ties, key=lambda name: gain(ties[name][0]))
    best = max(ties[lead], key=support)
    chosen = []
    for name, near in ties.items():
        for candidate in near:
            if _same(best, candidate):
                others = [c for c in near if c.effect.name != candidate.effect.name]
                distinct = {c.label: c for c in reversed(others)}
                chosen.append((name, candidate, list(distinct.values())[::-1]))
                break
    return chosen


def _same(one: Candidate, other: Candidate) -> bool:
    keys = ("channel", "source")
    return one.effect.name == other.effect.name and (
        one.effect.name == "coupling" or all(one.variant.fixed.get(k) == other.variant.fixed.get(k) for k in keys)
    )


def _tied(single: Problem, accepted: Sequence[Candidate]) -> list[Candidate]:
    """Those that the left-out runs cannot tell from the best."""
    best = accepted[0]
    variance = float(single.noise_K[0]) ** 2
    tied = []
    for candidate in accepted:
        near = (candidate.loss + variance) <= _NEAR**2 * (best.loss + variance)
        if candidate is best or near or p_better(single, 0, candidate.fit, best.fit) > TIE_LEVEL:
            tied.append(candidate)
    return tied


def _terms(fitted: Fit, c: int) -> list[Term]:
    made, at = [], 0
    for term in fitted.terms:
        count = len(term.variant.free)
        made.append(Term(term.effect, term.variant, tuple(float(x) for x in fitted.numbers[c, at : at + count])))
        at += count
    return made


def _rise(single: Problem, fitted: Fit) -> np.ndarray:
    slots = [(term.effect, values) for term, values in zip(fitted.terms, fitted.values(0), strict=True)]
    rise = readings(slots, single.track)[0]
    return np.asarray(np.broadcast_to(rise, (rise.shape[0], 1, 1, single.residual.shape[-1]))[:, 0, 0, :])


def _prune(
    singles: dict[str, Problem], terms: dict[str, list[Term]], final: dict[str, Fit], found: list[Found]
) -> None:
    """Drop an effect that a later one has made needless: without it the left-out error is no larger."""
    for name, own in terms.items():
        at = 0
        while len(own) > 1 and at < len(own):
            rest = [term for i, term in enumerate(own) if i != at]
            without = fit(singles[name], rest)
            variance = float(singles[name].noise_K[0]) ** 2
            kept = (float(without.loss[0]) + variance) > 1.05**2 * (float(final[name].loss[0]) + variance)
            if kept and p_better(singles[name], 0, without, final[name]) < TIE_LEVEL:
                at += 1
                continue
            dropped = own[at].effect.name
            own[:] = rest
            final[name] = without
            for i, entry in enumerate(found):
                if entry.component == name and entry.candidate.effect.name == dropped:
                    del found[i]
                    break
            at = 0


def _importance(whole: Problem, entry: Found, null: dict[str, Fit]) -> float:
    j = entry.candidate.judgement
    c = whole.components.index(entry.component)
    return (j.before_K**2 - j.after_K**2) / float(whole.noise_K[c]) ** 2
