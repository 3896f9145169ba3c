"""What a refinement says of what is left: the heat or cooling over time that would explain it, and what it is like."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen.refinement.network.effects import NetworkEffect
from gen.refinement.network.fitting.fit import Bench
from gen.refinement.network.over_time.course_fit import fitted_courses
from gen.refinement.network.over_time.courses import Course, Quantity
from gen.refinement.network.over_time.told_course import told
from gen.refinement.network.over_time.uneven import LEFT, PARTING, TURNS, Uneven, uneven
from gen.refinement.network.tracing.trace import Traced
from gen.refinement.verdict import NOTHING

PLAINLY, AGAINST = 20.0, 0.1
"""Logarithm of how much likelier the readings have to be with a conductance than with heat, for it to be called that;
and how far below none it may be a tenth of the time, as a share of how far it is above: a load, the sun or a neighbour
heat, and what heats looks much like a conductance less than the file's."""
_NAMES: dict[Quantity, tuple[str, str]] = {"heat": ("heat", "W"), "conductance": ("conductance", "W_per_K")}


@dataclass(frozen=True, eq=False)
class MissingHeat:
    """Heat, or a conductance to the ambient, over time, beside what was found.

    Attributes
    ----------
    course
        At the likeliest place.
    places
        Names of others that explain about as much by the same quantity, the likeliest first.
    uneven
        What it is like.
    names
        Of the runs.
    """

    course: Course
    places: tuple[str, ...]
    uneven: Uneven
    names: tuple[str, ...]

    @property
    def parts_runs(self) -> bool:
        """Whether the runs do not share it: what is found in all of them is then in some of them only."""
        return self.uneven.pattern in PARTING

    @property
    def comes_and_goes(self) -> bool:
        """Whether it is nothing that a file holds."""
        return self.uneven.pattern == "comes and goes"

    def warnings(self, found: Sequence[str]) -> list[str]:
        """A sentence for the user, beside the names of what was found; none where it goes with speed."""
        said = told(self.uneven, self.course, self.names)
        if said and found:
            said += f". {', '.join(dict.fromkeys(found))}, which was found beside it, may stand for its mean"
        return [said] if said else []

    def summary(self) -> dict[str, Any]:
        """As the JSON summary has it: keys end on the unit of the quantity."""
        found, (name, unit) = self.uneven, _NAMES[self.course.quantity]
        made = {
            "quantity": self.course.quantity,
            "component": self.course.component,
            "lookalikes": list(self.places),
            "share_of_squares_left": self.course.left,
            "pattern": found.pattern,
            f"beside_mean_at_each_speed_{unit}": [found.low, found.high],
            f"deviation_{unit}": found.deviation,
            "since": None if found.since is None else {"run": self.names[found.since[0]], "hours": found.since[1:]},
            "runs": {
                self.names[one.run]: {
                    "time_s": one.time_s.tolist(),
                    f"{name}_{unit}": one.value.tolist(),
                    f"deviation_{unit}": one.deviation.tolist(),
                }
                for one in self.course.runs
            },
        }
        return made if self.course.quantity == "heat" else {**made, "whole_motor_W_per_K": self.course.usual}


def missing_heat(traced: Traced, grown: Sequence[bool], names: Sequence[str]) -> MissingHeat | None:
    """Ask what heat or conductance over time would explain what is left.

    Parameters
    ----------
    traced
        What was found.
    grown
        For each effect of it whether it is heat that has grown: beside such an effect nothing is asked, since the mean
        of what comes and goes looks like it.
    names
        Of the later runs.

    Returns
    -------
    missing
        Beside those effects that may differ at the same speed, where it comes and goes or parts the runs: the others,
        which all runs share, bend to what some of them have. Else beside all that was found. None where little is left,
        or no course explains it.
    """
    if traced.final.floors <= NOTHING and not any(grown):
        return None
    own = [found.effect for found, more in zip(traced.added, grown, strict=True) if not more]
    beside_all = _beside(traced, own, names)
    if traced.final.floors <= NOTHING or not any(effect.goes_with_speed for effect in own):
        return beside_all
    beside_some = _beside(traced, [effect for effect in own if not effect.goes_with_speed], names)
    if beside_some is None or beside_some.uneven.pattern == "even":
        return beside_all
    hidden = beside_all is None or beside_all.uneven.pattern == "even"
    return beside_some if beside_some.parts_runs or hidden else beside_all


def _beside(traced: Traced, effects: Sequence[NetworkEffect], names: Sequence[str]) -> MissingHeat | None:
    """The same beside some effects."""
    fitted = traced.final.fitted if effects else traced.null.fitted
    courses = likeliest(fitted_courses(Bench(traced.data), fitted, fitted.shape.with_effects(*effects)))
    found = uneven(courses)
    if found is None:
        return None
    alike = tuple(one.component for one in courses[1:] if one.left <= min(2.0 * courses[0].left, LEFT))
    return MissingHeat(courses[0], alike, found, tuple(names))


def likeliest(every: Sequence[Course]) -> list[Course]:
    """Give the courses of one quantity, the likeliest first: of heat, unless cooling that is added is plainly likelier.

    Parameters
    ----------
    every
        Of both quantities.
    """
    heat = [one for one in every if one.quantity == "heat"]
    cooling = [one for one in every if one.quantity == "conductance"]
    plainly = bool(cooling) and cooling[0].evidence > max(heat[0].evidence, 0.0) + PLAINLY
    return cooling if plainly and _only_adds(cooling[0]) else heat


def _only_adds(course: Course) -> bool:
    """Whether it is hardly ever below none while the motor turns."""
    value = np.concatenate([one.value[one.turning > TURNS] for one in course.runs])
    if not value.size:
        return False
    low, high = np.quantile(value, (0.1, 0.9))
    return bool(high > 0.0 and low > -AGAINST * high)
