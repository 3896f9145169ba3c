"""The story of a refinement as one HTML page."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any

import numpy as np

from gen.coefficients import Coefficients
from gen.model.effects import registry
from gen.pages.charts import Chart, Series
from gen.pages.environment import page_environment
from gen.refinement.candidates import Candidate
from gen.refinement.condense import Condensed
from gen.refinement.judgement import ALONE, TOO_LITTLE
from gen.refinement.refine import Refinement

_SENTENCES = {
    "explained": "With the effects below, what is left on runs that were left out is near the sensors' noise.",
    "partly explained": "The effects below lower the error on left-out runs by more than chance, but something is "
    "left: the names are the nearest in the library, not certain.",
    "nothing missing": "The residual is near the sensors' noise; no effect is added.",
    "unexplained": "Something is missing, and no effect of the library explains it on left-out runs.",
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
    return page_environment().get_template("refine.html.j2").render(_context(found, baseline))


def _context(found: Refinement, baseline: Coefficients) -> dict[str, Any]:
    tracing = found.tracing
    names = tracing.problem.components
    before, after = found.before.summary(), found.after.summary()
    totals = [[key, *_four(before[key], after[key])] for key in ("fit", "test")]
    short = _short_names([*found.before.fit, *found.before.test])
    errors = {
        kind: [
            [short[run] if first else "", name, *_four(before["per_run"][run][name], after["per_run"][run][name])]
            for run, parts in getattr(found.before, kind).items()
            for first, name in zip([True] + [False] * len(parts), parts, strict=False)
        ]
        for kind in ("test", "fit")
    }
    return {
        "name": baseline.name,
        "verdict": found.verdict,
        "sentence": _SENTENCES[found.verdict],
        "warnings": found.warnings,
        "facts": found.excitation.facts,
        "missing": found.excitation.missing,
        "noise": ", ".join(f"{n} {s:.2f} K" for n, s in zip(names, tracing.problem.noise_K, strict=True)),
        "components": [_component(found, name) for name in names],
        "tried": tracing.tried,
        "level": tracing.level,
        "effects": [_effect(effect) for effect in found.effects],
        "totals": totals,
        "errors": errors,
        "runs": [(short[run.name], number % 8) for number, run in enumerate(found.runs)],
        "courses": list(islice(_courses(found, short), _MOST_COURSES)),
        "left": [_over("left", "what is left over time", found.runs, name, *_left(found, name)) for name in names],
        "next": _next(found),
    }


def _four(before: dict[str, float], after: dict[str, float]) -> list[str]:
    return [f"{which[key]:.2f}" for key in ("rmse_K", "max_abs_K") for which in (before, after)]


def _component(found: Refinement, name: str) -> dict[str, Any]:
    tracing = found.tracing
    variance = float(tracing.problem.noise_K[tracing.problem.components.index(name)]) ** 2
    left = found.remains[name]
    considered = _distinct(tracing.considered.get(name, []))
    most = ", ".join(f"{key} {share:.0%}" for key, share in islice(left.shares.items(), 4))
    remains = f"{left.rms_K:.2f} K (bins' means, left-out runs) beside a sensor noise of {left.noise_K:.2f} K."
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
        "residual": [
            _over("time", "over time", found.runs, name, *_residual(found.runs, name, "time")),
            _over("speed", "over speed", found.runs, name, *_residual(found.runs, name, "speed")),
            _over(
                "temp", "over the model's temperature", found.runs, name, *_residual(found.runs, name, "temperature")
            ),
        ],
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


Points = tuple[str, list[Series]]


def _time_unit(runs: list[Condensed]) -> tuple[str, float]:
    """Hours, or minutes where runs are short: label and s."""
    longest = max(float(run.edges[-1] - run.edges[0]) for run in runs)
    return ("h", 3600.0) if longest > 5400.0 else ("min", 60.0)


def _residual(runs: list[Condensed], name: str, over: str) -> Points:
    series = []
    unit = _time_unit(runs)
    for r, run in enumerate(runs):
        own = run.traces.get(name)
        if own is None:
            continue
        good = np.isfinite(own.residual)
        middle = 0.5 * (run.edges[1:] + run.edges[:-1]) / unit[1]
        x = {"time": middle, "speed": run.pwm, "temperature": 0.5 * (own.base[1:] + own.base[:-1])}[over]
        series.append(Series("", x[good].tolist(), own.residual[good].tolist(), r % 8, dots=over != "time"))
    label = {"time": f"time ({unit[0]})", "speed": "|PWM| (counts)", "temperature": "modelled rise (K)"}[over]
    return label, series


def _left(found: Refinement, name: str) -> Points:
    series = []
    unit = _time_unit(found.runs)
    fitted = found.tracing.final[name]
    for r, run in enumerate(found.runs):
        size = run.edges.size - 1
        good = found.tracing.problem.weight[:size, found.tracing.problem.components.index(name), 0, r] > 0
        middle = 0.5 * (run.edges[1:] + run.edges[:-1]) / unit[1]
        if good.any():
            series.append(Series("", middle[good].tolist(), fitted.left_out[:size, 0, r][good].tolist(), r % 8))
    return f"time ({unit[0]})", series


def _over(kind: str, title: str, runs: list[Condensed], name: str, label: str, series: list[Series]) -> Chart:
    ends = [value for one in series for value in one.y]
    text = f"Residual of {name} {title} in {len(runs)} runs, from {min(ends):.2f} to {max(ends):.2f} K."
    return Chart(f"{kind}-{name}", f"{name}: {title}", text, label, "measured − model", "K", tuple(series))


def _courses(found: Refinement, short: dict[str, str]) -> Iterable[Chart]:
    """What is left before and after, for the components with an effect, in the test runs first."""
    changed = list(dict.fromkeys(effect["component"] for effect in found.effects))
    unit = _time_unit(found.runs)
    for number, run in enumerate([*found.before.test, *found.before.fit]):
        old, new = found.before.curves[run], found.after.curves[run]
        elapsed = (old.time_s - old.time_s[0]) / unit[1]
        for name in changed:
            if name not in old.measured:
                continue
            good = np.isfinite(old.measured[name])
            x = elapsed[good].tolist()
            series = (
                Series("before", x, (old.measured[name] - old.model[name])[good].tolist(), 1),
                Series("after", x, (new.measured[name] - new.model[name])[good].tolist(), 0),
            )
            kind = "test" if run in found.before.test else "fit"
            title = f"{name}, {kind} run {short[run]}"
            text = f"Measured minus model before and after, {title}."
            yield Chart(f"course-{number}-{name}", title, text, f"time ({unit[0]})", "measured − model", "K", series)


def _short_names(paths: list[str]) -> dict[str, str]:
    """File names where they tell the runs apart, else the paths as they were given."""
    names = [path.rsplit("/", 1)[-1] for path in paths]
    return dict(zip(paths, names if len(set(names)) == len(names) else paths, strict=True))


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
    for name, considered in found.tracing.considered.items():
        if not found.tracing.final[name].terms:
            alone = [c.label for c in _distinct(considered) if ALONE in c.judgement.reasons]
            asked += [f"{name}: {label} would fit, but one run alone excites it: run that again" for label in alone[:2]]
    return list(dict.fromkeys([*asked, *found.excitation.missing]))
