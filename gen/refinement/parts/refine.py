"""`gen refine`: from a baseline and measured runs to an extended model, judged on runs that took no part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gen.coefficients import Coefficients, as_json, parse, with_effects
from gen.refinement.admission import admitted
from gen.refinement.condense import Condensed, check_apart, check_measured, condense
from gen.refinement.errors import Errors, missed, said_of
from gen.refinement.parts.candidates import Tracing
from gen.refinement.parts.effect_entries import effect_entries
from gen.refinement.parts.excitation import Excitation, excitation
from gen.refinement.parts.leftover import Remains, leftover
from gen.refinement.parts.offered import each_speed_once
from gen.refinement.parts.trace import trace
from gen.refinement.run_errors import run_errors
from gen.refinement.verdict import EXPLAINED, NOTHING, Verdict
from gen.refinement.worse import got_worse, lowered, told_worse

SCHEDULE_BY_STRETCH = "a wrong schedule on thirds of each run, as each speed was run once"


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
        As the JSON summary has them, which is as in the coefficient file.
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

    @property
    def tests_worse(self) -> bool:
        """Whether the test runs are missed by more than before."""
        return got_worse(self.before, self.after)

    @property
    def judged_on(self) -> str:
        """What was left out of the fits, in turn, to judge hypotheses and to reach the verdict."""
        parts = self.tracing.problem.left_out_parts
        return f"{parts}; {SCHEDULE_BY_STRETCH}" if each_speed_once(self.runs) else parts

    def summary(self) -> dict[str, Any]:
        """The JSON summary."""
        return {
            "before": self.before.summary(),
            "after": self.after.summary(),
            "effects": self.effects,
            "verdict": self.verdict,
            "judged_on": self.judged_on,
            "noise_floor_K": {
                name: float(value)
                for name, value in zip(self.tracing.problem.components, self.tracing.problem.noise_K, strict=True)
            },
            "tests_worse": self.tests_worse,
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
    _check_test_runs(baseline, fit_paths, test_paths, progress)
    runs, warnings = _runs_to_fit(baseline, fit_paths, progress)
    tracing = trace(baseline, runs, progress)
    verdict = judge_verdict(tracing)
    entries = effect_entries(tracing, explained=verdict == "explained")
    text = with_effects(raw, entries)
    kept = {run.name for run in runs}
    paths = [path for path in fit_paths if str(path) in kept], test_paths
    before = _errors(baseline, baseline, *paths, lambda path: progress(f"judging {path}"))
    after = before
    if entries:
        refined = parse(text.encode())
        after = _errors(baseline, refined, *paths, lambda path: progress(f"judging {path} with what was found"))
    return Refinement(
        text=text,
        before=before,
        after=after,
        effects=[as_json(entry) for entry in entries],
        verdict=lowered(verdict) if got_worse(before, after) else verdict,
        tracing=tracing,
        runs=runs,
        excitation=excitation(baseline, runs),
        remains={name: leftover(tracing, runs, name) for name in tracing.problem.components},
        warnings=[*warnings, *said_of(test_paths, before), *told_worse(before, after), *missed(after)],
    )


def _check_test_runs(
    baseline: Coefficients, fit_paths: Sequence[Path], test_paths: Sequence[Path], progress: Callable[[str], None]
) -> None:
    check_apart(fit_paths, test_paths)
    for path in test_paths:
        progress(f"checking {path}")
        check_measured(baseline, path)  # only whether it can be judged: its values stay unopened until the end


def _runs_to_fit(
    baseline: Coefficients, paths: Sequence[Path], progress: Callable[[str], None]
) -> tuple[list[Condensed], list[str]]:
    """The admitted runs, and what the user must know of them."""
    read = []
    for path in paths:
        progress(f"reading {path}")
        read.append(condense(baseline, path))
    runs, warnings = admitted(baseline, read)
    return runs, warnings + [f"{run.name}: {run.left_out}" for run in read if run.left_out]


def _errors(
    baseline: Coefficients,
    model: Coefficients,
    fit_paths: Sequence[Path],
    test_paths: Sequence[Path],
    say: Callable[[Path], None],
) -> Errors:
    """Simulate a model along all runs and compare."""
    errors = Errors()
    for paths, scores in ((fit_paths, errors.fit), (test_paths, errors.test)):
        for path in paths:
            say(path)
            scores[str(path)], errors.curves[str(path)] = run_errors(baseline, model, path)
    return errors


def judge_verdict(tracing: Tracing) -> Verdict:
    """The verdict from what was left out of the fits alone: runs, or thirds of a single one."""
    null, final = tracing.ratio(tracing.null), tracing.ratio(tracing.final)
    worst = max(tracing.own_ratio(name, tracing.final) for name in tracing.problem.components)
    if not tracing.found:
        return "nothing missing" if max(null, worst) <= NOTHING else "unexplained"
    if final <= EXPLAINED and worst <= NOTHING and not any(found.candidate.by_stretch for found in tracing.found):
        return "explained"
    return "partly explained"
