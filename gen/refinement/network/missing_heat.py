"""What a refinement says of what is left: the heat over time that would explain it, and what that is like."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gen.refinement.network.effects import NetworkEffect
from gen.refinement.network.fit import Bench
from gen.refinement.network.heat_course import HeatCourse, heat_courses
from gen.refinement.network.trace import Traced
from gen.refinement.network.uneven import LEFT, Uneven, told, uneven
from gen.refinement.verdict import NOTHING


@dataclass(frozen=True, eq=False)
class MissingHeat:
    """Heat over time, beside what was found.

    Attributes
    ----------
    course
        At the likeliest place.
    places
        Names of others that explain about as much, the likeliest first.
    uneven
        What it is like.
    names
        Of the runs.
    """

    course: HeatCourse
    places: tuple[str, ...]
    uneven: Uneven
    names: tuple[str, ...]

    @property
    def parts_runs(self) -> bool:
        """Whether the runs do not share it: what is found in all of them is then in some of them only."""
        return self.uneven.pattern in ("by run", "since", "grows")

    @property
    def comes_and_goes(self) -> bool:
        """Whether it is nothing that a file holds."""
        return self.uneven.pattern == "comes and goes"

    def warnings(self, found: Sequence[str]) -> list[str]:
        """A sentence for the user, beside the names of what was found; none where the heat goes with speed."""
        said = told(self.uneven, self.course.component, self.names)
        if said and found:
            said += f". {', '.join(dict.fromkeys(found))}, which was found beside it, may stand for its mean"
        return [said] if said else []

    def summary(self) -> dict[str, Any]:
        """As the JSON summary has it."""
        found = self.uneven
        return {
            "component": self.course.component,
            "lookalikes": list(self.places),
            "share_of_squares_left": self.course.left,
            "pattern": found.pattern,
            "beside_mean_at_each_speed_W": [found.low_W, found.high_W],
            "deviation_W": found.deviation_W,
            "since": None if found.since is None else {"run": self.names[found.since[0]], "hours": found.since[1:]},
            "runs": {
                self.names[one.run]: {
                    "time_s": one.time_s.tolist(),
                    "heat_W": one.heat_W.tolist(),
                    "deviation_W": one.deviation_W.tolist(),
                }
                for one in self.course.runs
            },
        }


def missing_heat(traced: Traced, changes: Sequence[str], names: Sequence[str]) -> MissingHeat | None:
    """Ask what heat over time would explain what is left.

    Parameters
    ----------
    traced
        What was found.
    changes
        For each effect of it why it may be another motor: beside such an effect nothing is asked.
    names
        Of the later runs.

    Returns
    -------
    missing
        Beside those effects that may differ at the same speed, where it comes and goes or parts the runs: the others,
        which all runs share, bend to what some of them have. Else beside all that was found. None where little is left,
        or no heat explains it.
    """
    if traced.final.floors <= NOTHING and not any(changes):
        return None
    own = [found.effect for found, change in zip(traced.added, changes, strict=True) if not change]
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
    courses = heat_courses(Bench(traced.data), fitted, fitted.shape.with_effects(*effects))
    found = uneven(courses)
    if found is None:
        return None
    alike = tuple(one.component for one in courses[1:] if one.left <= min(2.0 * courses[0].left, LEFT))
    return MissingHeat(courses[0], alike, found, tuple(names))
