"""The heat or cooling that would explain what is left, over time, as the report draws it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.pages.panels import Course, Panel, Panels
from gen.refinement.errors import Errors
from gen.refinement.network.effects.base import WHOLE
from gen.refinement.network.over_time.courses import Quantity, RunCourse
from gen.refinement.network.over_time.missing_heat import MissingHeat
from gen.refinement.network.over_time.uneven import Pattern
from gen.refinement.run_charts import LONG_S

MOST_CHARTS, MOST_POINTS = 12, 300
_MEANING: dict[Pattern, str] = {
    "even": "It is about the same whenever a speed is run again, so a number of the file, or a part that it lacks, may "
    "be the reason.",
    "comes and goes": "It comes and goes at the same speed, so no number of the file is the reason: something that no "
    "column holds was on at times. Whoever was there may know it by its times.",
    "by run": "At the same speed it is another one in each run: something was otherwise in some of them.",
    "grows": "At the same speed it goes one way from run to run: something wears, gathers dust, or is loaded more.",
    "since": "At the same speed it is another one from some time on: something changed for good.",
}
_TITLES: dict[Quantity, str] = {
    "heat": "Heat that would explain what is left",
    "conductance": "Cooling that would explain what is left",
}
_WHATS: dict[Quantity, str] = {"heat": "a heat", "conductance": "a conductance that is added"}


@dataclass(frozen=True)
class HeatStory:
    """What the page tells.

    Attributes
    ----------
    title, what
        Whether it is heat or cooling, as a heading and in a sentence.
    place, beside
        Where it is, and where else, or what else, it may be.
    meaning
        A sentence.
    charts
        One for each run.
    not_drawn
        A sentence where there are more runs than are drawn.
    """

    title: str
    what: str
    place: str
    beside: str
    meaning: str
    charts: tuple[Panels, ...]
    not_drawn: str


def heat_story(missing: MissingHeat, errors: Errors, short: dict[str, str]) -> HeatStory:
    """Tell and draw it.

    Parameters
    ----------
    missing
        What was found.
    errors
        For each run's PWM.
    short
        Names of the runs as the page has them.
    """
    courses = missing.course.runs
    # One scale for all: runs are compared.
    ends = [one.value + sign * one.deviation for one in courses for sign in (-1.0, 1.0)]
    low, high = min(float(end.min()) for end in ends), max(float(end.max()) for end in ends)
    charts = tuple(_chart(one, missing, errors, short, (low, high)) for one in courses[:MOST_CHARTS])
    more = len(courses) - len(charts)
    others = [_place(name, missing.course.quantity) for name in missing.places]
    return HeatStory(
        title=_TITLES[missing.course.quantity],
        what=_WHATS[missing.course.quantity],
        place=_place(missing.course.component, missing.course.quantity),
        beside=f" (or, nearly as likely, {', '.join(others)})" * bool(others),
        meaning=_MEANING[missing.uneven.pattern],
        charts=charts,
        not_drawn=f"{more} more runs are in the JSON summary." if more else "",
    )


def _place(component: str, quantity: Quantity) -> str:
    if component == WHOLE:
        return "in all parts, as the file's heats are" if quantity == "heat" else "on all paths to the ambient together"
    return f"at {component}" if quantity == "heat" else f"from {component} to the ambient"


def _chart(
    one: RunCourse, missing: MissingHeat, errors: Errors, short: dict[str, str], ends: tuple[float, float]
) -> Panels:
    name = missing.names[one.run]
    curve = errors.curves[name]
    unit, seconds = ("h", 3600.0) if curve.span_s > LONG_S else ("min", 60.0)
    time = one.time_s / seconds
    outline = np.concatenate([one.value + one.deviation, (one.value - one.deviation)[::-1]])
    pwm = curve.pwm.thinned(MOST_POINTS)
    return Panels(
        identifier=f"heat-{one.run}",
        title=short[name],
        description=f"Missing {missing.course.quantity} of {missing.course.component}, from {one.value.min():.3g} to "
        f"{one.value.max():.3g} {missing.course.unit}; below, PWM.",
        x_label=f"time ({unit})",
        panels=(
            Panel(
                missing.course.unit,
                (
                    Course("band", np.concatenate([time, time[::-1]]).tolist(), outline.tolist(), "area"),
                    Course("after", time.tolist(), one.value.tolist()),
                ),
                110.0,
                from_zero=True,
                reaching=ends,
            ),
            Panel(
                "PWM",
                (Course("drive", ((pwm.time_s - curve.start_s) / seconds).tolist(), pwm.values.tolist(), "steps"),),
                48.0,
                from_zero=True,
            ),
        ),
    )
