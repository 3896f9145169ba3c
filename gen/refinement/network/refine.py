"""`gen refine` on a network: effects are its terms, fitted together with all that its file leaves open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from gen.coefficients import Coefficients
from gen.reference.simulate import simulate_run
from gen.refinement.condense import check_apart, check_measured, read_measured
from gen.refinement.declared import Held, held
from gen.refinement.errors import Errors, missed, said_of
from gen.refinement.network.ambient import moving_ambient
from gen.refinement.network.entries import considered_entry
from gen.refinement.network.fitting.folds import described
from gen.refinement.network.kept import kept
from gen.refinement.network.outcome import Found
from gen.refinement.network.over_time.missing_heat import MissingHeat
from gen.refinement.network.planned import Settled, settled
from gen.refinement.network.prepared import prepared
from gen.refinement.network.tracing.trace import Traced, trace
from gen.refinement.network.tracing.warm_start import warm_start
from gen.refinement.network.written import offered_anew
from gen.refinement.run_errors import Curve, Score, compared
from gen.refinement.verdict import Verdict
from gen.refinement.worse import got_worse, told_worse
from gen.runs import Run
from gen.side_by_side import side_by_side


@dataclass(frozen=True, eq=False)
class NetworkRefinement:
    """All that a refinement found.

    Attributes
    ----------
    text
        The refined coefficient file.
    before, after
        Errors of the file and of the refined one: what `gen simulate` gives for each run.
    effects
        As the JSON summary has them.
    verdict
        "explained", "partly explained", "nothing missing" or "unexplained".
    refitted
        Whether numbers that the file had left open were fitted anew, with or without effects.
    traced
        For the report.
    warnings
        What to look at, one sentence each.
    planned
        Of runs that `gen plan` asked for: whether they told what they were to tell.
    missing
        The heat over time that would explain what is left, where much is.
    """

    text: str
    before: Errors
    after: Errors
    effects: list[dict[str, Any]]
    verdict: Verdict
    refitted: bool
    traced: Traced
    warnings: list[str]
    planned: tuple[Settled, ...] = ()
    missing: MissingHeat | None = None

    @property
    def tests_worse(self) -> bool:
        """Whether the test runs are missed by more than before."""
        return got_worse(self.before, self.after)

    @property
    def lead(self) -> str:
        """What is to be said before the verdict, or nothing."""
        return ""

    @property
    def judged_on(self) -> str:
        """What was left out of the fits, in turn."""
        return described(self.traced.data.later)

    def summary(self) -> dict[str, Any]:
        """The JSON summary."""
        return {
            "before": self.before.summary(),
            "after": self.after.summary(),
            "effects": self.effects,
            "verdict": self.verdict,
            "judged_on": self.judged_on,
            "refitted": self.refitted,
            "tests_worse": self.tests_worse,
            "left_out_rmse_K": {"without_effects": self.traced.null.score_K, "with": self.traced.final.score_K},
            "noise_floor_K": self.traced.null.noise_K,
            "considered": [considered_entry(step) for step in self.traced.steps],
            "planned": [one.summary() for one in self.planned],
            "missing_heat": None if self.missing is None else self.missing.summary(),
            "warnings": self.warnings,
        }


def refine_network(
    coefficients: Coefficients,
    raw: str,
    fit_paths: Sequence[Path],
    test_paths: Sequence[Path],
    progress: Callable[[str], None],
    *,
    accept_change: bool = False,
) -> NetworkRefinement:
    """Trace the error of a network on the fit runs, extend it, and open the test runs once, at the end.

    Parameters
    ----------
    coefficients, raw
        The file, and its text.
    fit_paths, test_paths
        Run files; none may be in both.
    progress
        Called with what is being done.
    accept_change
        Write what looks like another motor, too.

    Raises
    ------
    InputError
        For files that are no runs, or with no admitted run to fit.
    """
    check_apart(fit_paths, test_paths)
    for path in test_paths:
        progress(f"checking {path}")
        check_measured(coefficients, path)  # only whether it can be judged: its values stay unopened until the end
    runs, data, shape, warnings = prepared(coefficients, fit_paths, progress)
    traced = trace(data, shape, progress)
    room = moving_ambient(coefficients, runs, data, traced)
    fixed = room is None and coefficients.model.ambient_channel is None
    sorted_out = kept(traced, [name for name, _ in runs], fixed_ambient=fixed, accept_change=accept_change)
    start = warm_start(data, traced.final)
    start = start if len(sorted_out.effects) == len(traced.added) else start.as_the_file
    paths = [Path(name) for name, _ in runs], test_paths
    before = _errors(coefficients, *paths, progress)
    found = Found(coefficients, raw, before, traced, room, accept_change)
    outcome = found.outcome(
        sorted_out,
        start,
        lambda refined: _errors(refined, *paths, lambda what: progress(f"{what} with what was found")),
    )
    nothing = outcome.verdict == "unexplained" and not outcome.effects
    declared = _within_what_is_declared(coefficients, runs) if nothing else ""
    anew = offered_anew(traced, declared=bool(declared)) if outcome.offers_anew else ""
    warnings += [*(said for said in (declared, anew) if said), *outcome.warnings]
    told, ignored = settled(runs, traced)
    after = outcome.after
    warnings += [*ignored, *said_of(test_paths, before), *told_worse(before, after), *missed(after)]
    return NetworkRefinement(
        outcome.made.text,
        before,
        after,
        outcome.effects,
        outcome.verdict,
        outcome.made.refitted,
        traced,
        warnings,
        told,
        sorted_out.missing,
    )


def _within_what_is_declared(coefficients: Coefficients, runs: Sequence[tuple[str, Run]]) -> str:
    """That the file misses the runs by no more than it declares, or nothing."""
    made = side_by_side([partial(_held, coefficients, run, name) for name, run in runs])
    return sum(made, Held()).sentence


def _held(model: Coefficients, run: Run, name: str) -> Held:
    columns = simulate_run(model, run, "exact", "auto", name)
    return held(model, run, {part: np.asarray(columns[f"{part}_degC"], dtype=np.float64) for part in run.temps})


def _errors(
    model: Coefficients, fit_paths: Sequence[Path], test_paths: Sequence[Path], progress: Callable[[str], None]
) -> Errors:
    """What `gen simulate` gives for each run, compared with what was measured."""
    errors = Errors()
    progress(f"judging {len(fit_paths) + len(test_paths)} runs")
    made = iter(side_by_side([partial(_judged, model, path) for path in (*fit_paths, *test_paths)]))
    for paths, scores in ((fit_paths, errors.fit), (test_paths, errors.test)):
        for path in paths:
            scores[str(path)], errors.curves[str(path)] = next(made)
    return errors


def _judged(model: Coefficients, path: Path) -> tuple[dict[str, Score], Curve]:
    run = read_measured(model, path)
    columns = simulate_run(model, run, "exact", "auto", str(path))
    return compared(run, {name: np.asarray(columns[f"{name}_degC"], dtype=np.float64) for name in run.temps})
