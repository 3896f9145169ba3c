"""Charts of what a model leaves: over time, speed and temperature, and before and after."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from gen.pages.charts import Chart, Series
from gen.refinement.condense import Condensed
from gen.refinement.errors import Errors
from gen.refinement.parts.refine import Refinement

Points = tuple[str, list[Series]]


def _time_unit(runs: list[Condensed]) -> tuple[str, float]:
    """Hours, or minutes where runs are short: label and s."""
    longest = max(float(run.edges[-1] - run.edges[0]) for run in runs)
    return ("h", 3600.0) if longest > 5400.0 else ("min", 60.0)


def residual_charts(runs: list[Condensed], name: str) -> list[Chart]:
    """A component's residual over time, speed and the model's temperature."""
    titles = {"time": "over time", "speed": "over speed", "temp": "over the model's temperature"}
    return [_over(kind, title, runs, name, *_residual(runs, name, kind)) for kind, title in titles.items()]


def left_chart(found: Refinement, name: str) -> Chart:
    """What the final fits leave of a component where they did not see it, over time."""
    return _over("left", "what is left over time", found.runs, name, *_left(found, name))


def _residual(runs: list[Condensed], name: str, over: str) -> Points:
    series = []
    unit = _time_unit(runs)
    for r, run in enumerate(runs):
        own = run.traces.get(name)
        if own is None:
            continue
        good = np.isfinite(own.residual)
        middle = 0.5 * (run.edges[1:] + run.edges[:-1]) / unit[1]
        x = {"time": middle, "speed": run.pwm, "temp": 0.5 * (own.base[1:] + own.base[:-1])}[over]
        series.append(Series("", x[good].tolist(), own.residual[good].tolist(), r % 8, dots=over != "time"))
    label = {"time": f"time ({unit[0]})", "speed": "|PWM| (counts)", "temp": "modelled rise (K)"}[over]
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


def error_courses(found: Refinement, short: dict[str, str]) -> Iterable[Chart]:
    """What is left before and after, for the components with an effect, in the test runs first."""
    changed = list(dict.fromkeys(effect["component"] for effect in found.effects))
    unit = _time_unit(found.runs)
    for number, run in enumerate([*found.before.test, *found.before.fit]):
        kind = "test" if run in found.before.test else "fit"
        for name in changed:
            if name not in found.before.curves[run].error:
                continue
            series = (_error(found.before, run, name, unit[1], 1), _error(found.after, run, name, unit[1], 0))
            title = f"{name}, {kind} run {short[run]}"
            text = f"Measured minus model before and after, {title}."
            yield Chart(f"course-{number}-{name}", title, text, f"time ({unit[0]})", "measured − model", "K", series)


def _error(errors: Errors, run: str, name: str, unit_s: float, style: int) -> Series:
    samples, start_s = errors.curves[run].error[name], errors.curves[run].start_s
    return Series(
        "before" if style else "after", ((samples.time_s - start_s) / unit_s).tolist(), samples.values.tolist(), style
    )
