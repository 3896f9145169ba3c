"""The story of a refinement as one HTML page."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any

import numpy as np

from gen.coefficients import Coefficients
from gen.model.effects import registry
from gen.pages.environment import page_environment
from gen.pages.panels import panels_svg
from gen.refinement.gains import TOO_LITTLE
from gen.refinement.parts.candidates import Candidate
from gen.refinement.parts.judgement import ALONE
from gen.refinement.parts.refine import Refinement
from gen.refinement.parts.residual_charts import error_courses, left_chart, residual_charts
from gen.refinement.parts.stacked_runs import THIRDS
from gen.refinement.run_charts import run_pictures
from gen.refinement.run_tables import error_rows, short_names, totals
from gen.refinement.worse import TOLD

_SENTENCES = {
    "explained": "With the effects below, what is left on {left_out} is near the sensors' noise.",
    "partly explained": "The effects below lower the error on {left_out} by more than chance, but something is left: "
    "the names are the nearest in the library, not certain.",
    "nothing missing": "The residual is near the sensors' noise; no effect is added.",
    "unexplained": "Something is missing, and no effect of the library explains it on {left_out}.",
}
_MOST_COURSES = 12


def page(found: Refinement, baseline: Coefficients) -> str:
    """Render the report.

    Parameters
    ----------
    found
        What `gen refine` found.
    baseline
        The coefficient file that it began with.
    """
    environment = page_environment(panels=panels_svg)
    return environment.get_template("refine.html.j2").render(_context(found, baseline))


def _context(found: Refinement, baseline: Coefficients) -> dict[str, Any]:
    tracing = found.tracing
    names = tracing.problem.components
    short = short_names([*found.before.fit, *found.before.test])
    pictures, not_drawn = run_pictures(found, short)
    return {
        "name": baseline.name,
        "input_meaning": baseline.document.input.meaning,
        "verdict": found.verdict,
        "sentence": _SENTENCES[found.verdict].format(left_out=_left_out(found)) + (TOLD if found.tests_worse else ""),
        "changed": found.after is not found.before,
        "judged_on": found.judged_on,
        "left_out": _left_out(found),
        "pictures": pictures,
        "not_drawn": not_drawn,
        "warnings": found.warnings,
        "facts": found.excitation.facts,
        "missing": found.excitation.missing,
        "noise": ", ".join(f"{n} {s:.2f} K" for n, s in zip(names, tracing.problem.noise_K, strict=True)),
        "components": [_component(found, name) for name in names],
        "tried": tracing.tried,
        "level": tracing.level,
        "effects": [_effect(effect) for effect in found.effects],
        "totals": totals(found.before, found.after),
        "errors": error_rows(found.before, found.after, short),
        "runs": [(short[run.name], number % 8) for number, run in enumerate(found.runs)],
        "courses": list(islice(error_courses(found, short), _MOST_COURSES)),
        "left": [left_chart(found, name) for name in names],
        "next": _next(found),
    }


def _one_run(found: Refinement) -> bool:
    return found.tracing.problem.left_out_parts == THIRDS


def _left_out(found: Refinement) -> str:
    """What the judgement looked at."""
    return "left-out thirds of the run" if _one_run(found) else "left-out runs"


def _component(found: Refinement, name: str) -> dict[str, Any]:
    tracing = found.tracing
    variance = float(tracing.problem.noise_K[tracing.problem.components.index(name)]) ** 2
    left = found.remains[name]
    considered = _distinct(tracing.considered.get(name, []))
    most = ", ".join(f"{key} {share:.0%}" for key, share in islice(left.shares.items(), 4))
    remains = f"{left.rms_K:.2f} K (bins' means, {_left_out(found)}) beside a sensor noise of {left.noise_K:.2f} K."
    if left.rms_K > left.noise_K:
        remains += f" Share of its variance between classes of: {most}."
    return {
        "name": name,
        "null": f"{np.sqrt(tracing.null[name].loss[0] + variance):.2f}",
        "considered": [_considered(c) for c in considered if TOO_LITTLE not in c.judgement.reasons],
        "tried": bool(considered),
        "together": _together(found, name),
        "no_help": ", ".join(c.label for c in considered if TOO_LITTLE in c.judgement.reasons),
        "remains": remains,
        "residual": residual_charts(found.runs, name),
    }


def _distinct(candidates: Iterable[Candidate]) -> list[Candidate]:
    best: dict[str, Candidate] = {}
    for candidate in candidates:
        best.setdefault(candidate.label, candidate)
    return list(best.values())


def _considered(candidate: Candidate) -> tuple[str, str, str, str]:
    judgement = candidate.judgement
    against = "against: " + "; ".join(judgement.reasons) if judgement.reasons else ""
    why = against or "passes every test; its signature: " + candidate.effect.signature
    p = "<1e-9" if judgement.p_value < 1e-9 else f"{judgement.p_value:.1g}"
    return candidate.label, f"{judgement.after_K:.2f}", p, why


def _together(found: Refinement, name: str) -> str:
    """What several effects leave that were accepted at one component."""
    terms = [term.effect.name for term in found.tracing.final[name].terms]
    if len(terms) < 2:
        return ""
    c = found.tracing.problem.components.index(name)
    left = np.sqrt(found.tracing.final[name].loss[0] + found.tracing.problem.noise_K[c] ** 2)
    return (
        f"Accepted together: {' with '.join(terms)}, left-out RMSE {left:.2f} K. The best of the table were each tried "
        "with every second effect, because two can hide each other: alone, either may do little."
    )


def _effect(effect: dict[str, Any]) -> dict[str, Any]:
    known = registry()[effect["name"]]
    intervals = effect["evidence"].get("intervals_95", {})
    rows = []
    levels = effect["parameters"].get(known.over_pwm) if known.over_pwm is not None else None
    for key, value in effect["parameters"].items():
        if levels is not None and isinstance(value, list):
            if key != known.over_pwm:
                rows += _over_pwm(key, levels, value, intervals)
        elif isinstance(value, list):
            for i, entry in enumerate(value):
                rows.append([f"{key}[{i}]", _number(entry), _interval(intervals.get(f"{key}[{i}]"))])
        elif value is not None:
            rows.append([key, _number(value), _interval(intervals.get(key))])
        elif key == known.tau:
            rows.append([key, "the component's own", ""])
    note = effect["evidence"].get("note", "")
    return {
        "name": effect["name"],
        "component": effect["component"],
        "title": known.title,
        "equation": known.equation,
        "signature": f"Note: {note}." if note else f"Signature: {known.signature}.",
        "rows": rows,
        "lookalikes": effect["evidence"]["lookalikes"],
    }


def _over_pwm(key: str, levels: list[int], values: list[float], intervals: dict[str, list[float]]) -> list[list[str]]:
    """A table over |PWM|, without the entries that were not fitted."""
    ends = [intervals.get(f"{key}[{i}]") for i in range(len(values))]
    return [
        [f"{key} at PWM {level}", _number(value), _interval(own)]
        for level, value, own in zip(levels, values, ends, strict=True)
        if own is None or own[0] < own[1]
    ]


def _number(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _interval(ends: list[float] | None) -> str:
    return "" if ends is None else f"{ends[0]:.4g} .. {ends[1]:.4g}"


def _next(found: Refinement) -> list[str]:
    asked = [
        f"{effect['component']}, {effect['name']} or {other['name']}: {other['told_apart_by']}"
        for effect in found.effects
        for other in effect["evidence"]["lookalikes"]
    ]
    if found.verdict in ("unexplained", "partly explained"):
        for name, left in found.remains.items():
            if left.shares and left.rms_K > left.noise_K:
                key, share = next(iter(left.shares.items()))
                asked.append(
                    f"{name}: what is left goes with {key} ({share:.0%} of its variance); vary it alone, the rest held"
                )
    return list(dict.fromkeys([*asked, *_excited_once(found), *found.excitation.missing]))


def _excited_once(found: Refinement) -> list[str]:
    """What would fit, but that nothing left out can confirm."""
    what = "a third of the run" if _one_run(found) else "one run"
    asked = []
    for name, considered in found.tracing.considered.items():
        if not found.tracing.final[name].terms:
            alone = [c.label for c in _distinct(considered) if ALONE in c.judgement.reasons]
            asked += [f"{name}: {label} would fit, but {what} alone excites it: run that again" for label in alone[:2]]
    return asked
