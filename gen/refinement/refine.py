"""`gen refine`: from a baseline and measured runs to an extended model, judged on runs that took no part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gen.coefficients import Coefficients, parse
from gen.errors import InputError
from gen.refinement.admission import admitted
from gen.refinement.candidates import Tracing
from gen.refinement.condense import Condensed, check_measured, condense
from gen.refinement.effect_entries import calibrations, entry, extended_text
from gen.refinement.excitation import Excitation, excitation
from gen.refinement.leftover import Remains, leftover
from gen.refinement.run_errors import Curve, Score, run_errors, total
from gen.refinement.trace import trace

EXPLAINED = 1.3
"""Explained: the RMSE on left-out runs is at most this many noise floors."""
NOTHING = 1.5
"""Nothing missing: without any effect it is at most this many."""
Verdict = str


@dataclass
class Errors:
    """Errors of one model: by run and component, fit and test apart."""

    fit: dict[str, dict[str, Score]] = field(default_factory=dict)
    test: dict[str, dict[str, Score]] = field(default_factory=dict)
    curves: dict[str, Curve] = field(default_factory=dict)

    def summary(self) -> dict[str, Any]:
        """As the JSON summary has it."""
        made: dict[str, Any] = {}
        for key in ("fit", "test"):
            made[key] = total(s for run in getattr(self, key).values() for s in run.values()).summary()
        made["per_run"] = {
            run: {name: s.summary() for name, s in scores.items()} for run, scores in {**self.fit, **self.test}.items()
        }
        return made


@dataclass
class Refinement:
    """All that a refinement found.

    Parameters
    ----------
    text
        The refined coefficient file.
    before, after
        Errors of the baseline and of the refined model.
    effects
        As in the coefficient file.
    verdict
        "explained", "partly explained", "nothing missing" or "unexplained".
    tracing, runs, excitation, remains, warnings
        For the report.
    """

    text: str
    before: Errors
    after: Errors
    effects: list[dict[str, Any]]
    verdict: Verdict
    tracing: Tracing
    runs: list[Condensed]
    excitation: Excitation
    remains: dict[str, Remains]
    warnings: list[str]

    def summary(self) -> dict[str, Any]:
        """The JSON summary."""
        return {
            "before": self.before.summary(),
            "after": self.after.summary(),
            "effects": self.effects,
            "verdict": self.verdict,
            "noise_floor_K": {
                name: float(value)
                for name, value in zip(self.tracing.problem.components, self.tracing.problem.noise_K, strict=True)
            },
            "hypotheses_tried": self.tracing.tried,
            "remains": {name: left.summary() for name, left in self.remains.items()},
            "warnings": self.warnings,
        }


def refine(
    baseline: Coefficients,
    raw: str,
    fit_paths: Sequence[Path],
    test_paths: Sequence[Path],
    progress: Callable[[str], None] = lambda _: None,
) -> Refinement:
    """Trace the residual of the fit runs, extend the model, and open the test runs once, at the end.

    Parameters
    ----------
    baseline, raw
        The coefficient file, and its text.
    fit_paths, test_paths
        Run files; none may be in both.
    progress
        Called with what is being done.

    Raises
    ------
    InputError
        For files that are no runs, before anything is fitted; or for no admitted run to fit.
    """
    both = {path.resolve() for path in fit_paths} & {path.resolve() for path in test_paths}
    if both:
        raise InputError("is given as --fit and as --test; test runs must take no part", file=str(sorted(both)[0]))
    for path in test_paths:
        progress(f"checking {path}")
        check_measured(baseline, path)  # only whether it can be judged: its values stay unopened until the end
    runs = []
    for path in fit_paths:
        progress(f"reading {path}")
        runs.append(condense(baseline, path))
    long = [f"{run.name}: {run.thinned}" for run in runs if run.thinned]
    runs, warnings = admitted(baseline, runs)
    warnings += long
    tracing = trace(baseline, runs, progress)
    effects = [entry(f, tracing) for f in tracing.found]
    effects += calibrations(tracing)
    verdict = judge_verdict(tracing)
    for effect in effects:
        effect["evidence"]["confident"] = verdict == "explained" and not effect["evidence"]["lookalikes"]
    text = extended_text(raw, effects)
    refined = parse(text.encode()) if effects else baseline
    before, after = Errors(), Errors()
    kept = {run.name for run in runs}
    for paths, key in ((fit_paths, "fit"), (test_paths, "test")):
        for path in paths:
            if key == "fit" and str(path) not in kept:
                continue
            progress(f"judging {path}")
            for errors, model in ((before, baseline), (after, refined)):
                if model is baseline and errors is after:
                    scores, curve = getattr(before, key)[str(path)], before.curves[str(path)]
                else:
                    scores, curve = run_errors(baseline, model, path)
                getattr(errors, key)[str(path)] = scores
                errors.curves[str(path)] = curve
    warnings += [
        f"{path}: {before.curves[str(path)].left_out}" for path in test_paths if before.curves[str(path)].left_out
    ]
    left = {name: leftover(tracing, runs, name) for name in tracing.problem.components}
    return Refinement(text, before, after, effects, verdict, tracing, runs, excitation(baseline, runs), left, warnings)


def judge_verdict(tracing: Tracing) -> Verdict:
    """The verdict from left-out runs alone."""
    null, final = tracing.ratio(tracing.null), tracing.ratio(tracing.final)
    worst = max(tracing.own_ratio(name, tracing.final) for name in tracing.problem.components)
    if not tracing.found:
        return "nothing missing" if max(null, worst) <= NOTHING else "unexplained"
    if final <= EXPLAINED and worst <= NOTHING and not any(found.candidate.by_stretch for found in tracing.found):
        return "explained"
    return "partly explained"
