"""`gen refine`: from a baseline and measured runs to an extended model, judged on runs that took no part."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gen.coefficients import Coefficients, parse
from gen.errors import InputError
from gen.loop.admission import admitted
from gen.loop.excitation import Excitation, excitation
from gen.loop.found import Found, Tracing
from gen.loop.remains import Remains, remains
from gen.loop.residual import Condensed, check_measured, condense
from gen.loop.score import Curve, Score, score, total
from gen.loop.trace import trace
from gen.model.effects.sensor_offset import SensorOffset

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
                    scores, curve = score(baseline, model, path)
                getattr(errors, key)[str(path)] = scores
                errors.curves[str(path)] = curve
    warnings += [
        f"{path}: {before.curves[str(path)].left_out}" for path in test_paths if before.curves[str(path)].left_out
    ]
    left = {name: remains(tracing, runs, name) for name in tracing.problem.components}
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


def calibrations(tracing: Tracing) -> list[dict[str, Any]]:
    """Offsets within the sensors' tolerance that were fitted beside accepted effects.

    They are no finding of their own (so none is written for a component without an effect), but the effects' parameters
    hold beside them only.
    """
    made = []
    for name in dict.fromkeys(found.component for found in tracing.found):
        final = tracing.final[name]
        noise = float(tracing.problem.noise_K[tracing.problem.components.index(name)])
        offset = float(final.offset[0])
        if any(term.effect.name == "sensor_offset" for term in final.terms) or abs(offset) < 0.5 * noise:
            continue
        made.append(
            {
                "name": "sensor_offset",
                "component": name,
                "parameters": {"offset_K": offset},
                "evidence": {
                    "within_tolerance": True,
                    "note": f"within the sensor's tolerance of {SensorOffset.TOLERANCE_K:g} K; fitted with the others",
                    "lookalikes": [],
                },
            }
        )
    return made


def entry(found: Found, tracing: Tracing) -> dict[str, Any]:
    """An effect as the coefficient file and the JSON summary have it, parameters from the last joint fit."""
    name, candidate = found.component, found.candidate
    final = tracing.final[name]
    at = next(i for i, term in enumerate(final.terms) if term.effect.name == candidate.effect.name)
    values = final.values(0)[at]
    intervals = {}
    for i, free in enumerate(candidate.variant.free, start=final.first_free(at)):
        value, spread = float(final.numbers[0, i]), 2.0 * float(final.spread[0, i])
        if not np.isfinite(spread):
            ends = [free.low, free.high]
        elif free.log:
            ends = [value * float(np.exp(-min(spread, 20.0))), value * float(np.exp(min(spread, 20.0)))]
        else:
            ends = [value - spread, value + spread]
        intervals[free.name] = [max(ends[0], free.low), min(ends[1], free.high)]
    experiments = candidate.effect.lookalikes
    judgement = candidate.judgement
    return {
        "name": candidate.effect.name,
        "component": name,
        "parameters": {key: _plain(value) for key, value in values.items()},
        "evidence": {
            "left_out_rmse_K": {"before": judgement.before_K, "after": judgement.after_K},
            "p_value": judgement.p_value,
            "level": tracing.level,
            "judged_on": "stretches of runs, as each speed was run once" if candidate.by_stretch else "whole runs",
            "intervals_95": intervals,
            "lookalikes": [
                {
                    "name": other.effect.name,
                    "left_out_rmse_K": other.judgement.after_K,
                    "told_apart_by": experiments.get(
                        other.effect.name, other.effect.lookalikes.get(candidate.effect.name, "")
                    )
                    or "vary what drives the one while the other's drive is held, for two hours each",
                }
                for other in found.lookalikes
            ],
        },
    }


def _plain(value: Any) -> Any:  # noqa: ANN401
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return value


def extended_text(raw: str, effects: Sequence[dict[str, Any]]) -> str:
    """The coefficient file with effects added to those that it has."""
    document = json.loads(raw)
    if effects:
        document["effects"] = [*document.get("effects", []), *effects]
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"
