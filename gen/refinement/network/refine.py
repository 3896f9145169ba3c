"""`gen refine` on a network: effects are its terms, fitted together with all that its file leaves open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gen.coefficients import Coefficients, parse
from gen.reference.simulate import simulate_run
from gen.refinement.condense import check_apart, check_measured, read_measured
from gen.refinement.errors import Errors, missed, said_of
from gen.refinement.network.ambient import MovingAmbient, moving_ambient
from gen.refinement.network.changed import looks_like_a_change
from gen.refinement.network.effects.walls import Walls
from gen.refinement.network.effects.warm_start import WarmStart, warm_start
from gen.refinement.network.entries import ambient_entry, considered_entry, effect_entry, start_entry
from gen.refinement.network.folds import described
from gen.refinement.network.missing_heat import MissingHeat, missing_heat
from gen.refinement.network.planned import Settled, settled
from gen.refinement.network.prepared import prepared
from gen.refinement.network.search import Considered
from gen.refinement.network.trace import Traced, trace
from gen.refinement.network.written import Written, offered_anew, written
from gen.refinement.run_errors import compared
from gen.refinement.verdict import EXPLAINED, NOTHING, Verdict
from gen.refinement.worse import got_worse, lowered, spoiled, told_worse

WALLS_ALONE = (
    "ambient: walls that lag behind the air were found, but a fixed ambient predicts as well as these and the measured "
    "air together, so nothing is written"
)
NOT_IN_ALL = (
    "what was found for all runs together is not written, since they differ: with --accept-change it is, as their mean"
)


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
    start = warm_start(data, traced.final)
    changes = [looks_like_a_change(found.effect, found.values, data) for found in traced.added]
    missing = missing_heat(traced, changes, [name for name, _ in runs])
    # What comes and goes is no change of the motor: what stood for it on average is told as what it is, and not named.
    loads = missing is not None and missing.comes_and_goes and not accept_change
    named = [
        not loads or not (change or _is_a_mean(found)) for found, change in zip(traced.added, changes, strict=True)
    ]
    kept = [
        found.effect
        for found, change, told in zip(traced.added, changes, named, strict=True)
        if accept_change or (told and not change)
    ]
    # Walls about an ambient that the file holds for fixed would be no walls.
    fixed = room is None and coefficients.model.ambient_channel is None
    no_walls = fixed and any(isinstance(effect, Walls) for effect in kept)
    if no_walls:
        warnings.append(WALLS_ALONE)
        kept = []
    made = written(coefficients, raw, traced, kept, room, start.factors, accept_change=accept_change)
    anew = "" if made.refitted else offered_anew(traced)
    beside = [] if missing is None or missing.parts_runs else [effect.name for effect in kept]
    warnings += [] if missing is None else missing.warnings(beside)
    warnings += [said for said in (*([] if loads else changes), made.refused, anew) if said]
    warnings += [
        f"{one.effect.component}: {one.effect.name} was found first, and is not needed beside what was found after it"
        for one in traced.dropped
    ]
    effects = _entries(traced, changes, named, room, start)
    kept_paths = [Path(name) for name, _ in runs]
    before = _errors(coefficients, kept_paths, test_paths, lambda path: progress(f"judging {path}"))
    after, refined = before, coefficients
    if made.text != raw:
        refined = parse(made.text.encode())
        after = _errors(refined, kept_paths, test_paths, lambda path: progress(f"judging {path} with what was found"))
    parts_runs = missing is not None and missing.parts_runs and bool(kept)
    torn = spoiled(before, after, traced.null.noise_K) + ([NOT_IN_ALL] if parts_runs else [])
    torn = [] if accept_change else torn
    if torn:
        made, after, effects = Written(raw), before, []
        warnings += torn
    elif after is not before:
        warnings += [f"of what is written: {said}" for said in refined.warnings if said not in coefficients.warnings]
    holds = not made.refused and not no_walls and not any(changes)
    holds = holds and all(found.effect.held_by_the_file for found in traced.added)
    verdict = _verdict(traced, start, anything=bool(effects), holds=holds)
    verdict = "unexplained" if torn else lowered(verdict) if got_worse(before, after) else verdict
    told, ignored = settled(runs, traced)
    warnings += [*ignored, *said_of(test_paths, before), *told_worse(before, after), *missed(after)]
    return NetworkRefinement(made.text, before, after, effects, verdict, made.refitted, traced, warnings, told, missing)


def _is_a_mean(found: Considered) -> bool:
    """Whether an effect is no more than other heat at each speed: so is the mean of any heat that comes and goes."""
    return found.effect.bends_the_file


def _entries(
    traced: Traced, changes: Sequence[str], named: Sequence[bool], room: MovingAmbient | None, start: WarmStart
) -> list[dict[str, Any]]:
    """What was found as the summary has it, of that which is named."""
    made = [] if room is None else [ambient_entry(room)]
    for step, change, told in zip(traced.steps, changes, named, strict=False):
        assert step.added is not None  # the last search alone may have added nothing
        if told:
            made.append(effect_entry(step, step.added, traced, change))
    return made + ([start_entry(start)] if start.factors else [])


def _verdict(traced: Traced, start: WarmStart, *, anything: bool, holds: bool) -> Verdict:
    """The verdict from what was left out of the fits alone.

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
    worst = _worst_sensor(traced)
    if not anything:
        return "nothing missing" if max(traced.null.floors, start.floors, worst) <= NOTHING else "unexplained"
    near = max(traced.final.floors, start.floors) <= EXPLAINED and worst <= NOTHING
    return "explained" if near and holds else "partly explained"


def _worst_sensor(traced: Traced) -> float:
    """The largest left-out error of one sensor in its noise floors."""
    data, error = traced.data, traced.final.error
    cover = np.where(np.isfinite(error), data.inputs.covered, 0.0)
    square = np.sum(cover * np.nan_to_num(error) ** 2, axis=0) / np.maximum(cover.sum(axis=0), 1e-9)
    noise = np.maximum(np.mean([run.noise_K**2 for run in data.inputs.runs[: data.later]], axis=0), 0.05**2)
    return float(np.sqrt(np.max((square + noise) / noise)))


def _errors(
    model: Coefficients, fit_paths: Sequence[Path], test_paths: Sequence[Path], say: Callable[[Path], None]
) -> Errors:
    """What `gen simulate` gives for each run, compared with what was measured."""
    errors = Errors()
    for paths, scores in ((fit_paths, errors.fit), (test_paths, errors.test)):
        for path in paths:
            say(path)
            run = read_measured(model, path)
            columns = simulate_run(model, run, "exact", "auto", str(path))
            shown = {name: np.asarray(columns[f"{name}_degC"], dtype=np.float64) for name in run.temps}
            scores[str(path)], errors.curves[str(path)] = compared(run, shown)
    return errors
