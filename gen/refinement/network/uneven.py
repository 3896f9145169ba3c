"""Whether what is missing goes with speed, as anything that a file can hold does, or comes and goes by itself.

A wrong number, a part without a sensor, a worn bearing: their heat is nearly the same whenever a speed is run again.
That of a load, a fan or the sun which no column holds is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.optimize import isotonic_regression

from gen.identification.network.fitting.bins import FloatArray
from gen.refinement.network.effects.base import WHOLE
from gen.refinement.network.heat_course import HeatCourse

UNEVEN = 0.6
"""Scatter of the heat about its mean at each speed, over the size of that mean, from which it comes and goes."""
PLAIN = 2.0
"""By how many of its standard deviations it has to scatter."""
LEFT = 0.5
"""Share of the weighed squares up to which a course explains what is left."""
SINCE, BY_RUN = 0.75, 0.6
"""Share of the scatter that one change for good explains, or one level for each run."""
DEGREE = 3
"""Of the polynomial over speed."""
AT_ONCE_H = 0.3
"""Into a run up to which a change is told as since it."""
LEAST, FEWEST, MOSTLY = 0.25, 3, 0.7
"""Scatter, runs, and share of that scatter, from which heat that goes one way in their order, or is another one in
each, is told beside a larger heat that goes with speed."""
TURNS = 0.9
"""Share of a block in which the motor has to turn: at rest another heat is missing."""
ROUNDS = 20
Pattern = Literal["even", "comes and goes", "by run", "since", "grows"]


@dataclass(frozen=True, eq=False)
class Uneven:
    """What a course is like while the motor turns.

    Attributes
    ----------
    pattern
        "even": it goes with speed. Else it "comes and goes" within runs, is another one "by run", changed for good
        within them ("since"), or "grows" (or falls) little by little, both in the order of the runs.
    scatter
        About its mean at each speed, over the size of that mean.
    low_W, high_W
        Between which it is beside its mean at each speed, 80 % of the time.
    deviation_W
        How well it is known.
    levels_W
        The mean in each run, beside that of all runs at each speed.
    since
        Of "since" alone: the run, and between which hours into it.
    """

    pattern: Pattern
    scatter: float
    low_W: float
    high_W: float
    deviation_W: float
    levels_W: tuple[float, ...]
    since: tuple[int, float, float] | None = None


class _Turning:
    """The blocks of all runs in which the motor turns, in the order of the runs.

    Parameters
    ----------
    course
        The course.
    """

    def __init__(self, course: HeatCourse) -> None:
        used = [one.turning > TURNS for one in course.runs]
        self.run = np.concatenate([np.full(int(u.sum()), one.run) for one, u in zip(course.runs, used, strict=True)])
        self.time_s = np.concatenate([one.time_s[u] for one, u in zip(course.runs, used, strict=True)])
        self.heat_W = np.concatenate([one.heat_W[u] for one, u in zip(course.runs, used, strict=True)])
        deviation = np.concatenate([one.deviation_W[u] for one, u in zip(course.runs, used, strict=True)])
        speed = np.concatenate([one.speed[u] for one, u in zip(course.runs, used, strict=True)])
        self.weight = 1.0 / np.maximum(deviation, 1e-9) ** 2
        self.by_speed: FloatArray = np.vander(speed, DEGREE + 1)
        self.by_run = (self.run[:, None] == np.unique(self.run)).astype(np.float64)

    @property
    def deviation_W(self) -> float:
        """How well the heat is known in a block."""
        return float(1.0 / np.sqrt(np.mean(self.weight)))

    def mean(self, functions: FloatArray, heat_W: FloatArray) -> FloatArray:
        """The heat as far as functions give it, shape (k,)."""
        root = np.sqrt(self.weight)
        found = np.linalg.lstsq(functions * root[:, None], heat_W * root, rcond=None)[0]
        return np.asarray(functions @ found)

    def square(self, heat_W: FloatArray) -> float:
        """Its mean square, W^2."""
        return float(np.average(heat_W**2, weights=self.weight))


def uneven(courses: Sequence[HeatCourse]) -> Uneven | None:
    """Judge the likeliest course.

    Parameters
    ----------
    courses
        At each place, the likeliest first.

    Returns
    -------
    uneven
        None where no heat explains what is left, or the motor hardly turns.
    """
    course = courses[0]
    blocks = _Turning(course)
    if course.left > LEFT or course.evidence <= 0.0 or blocks.heat_W.size <= 2 * (DEGREE + 1):
        return None
    mean = blocks.mean(blocks.by_speed, blocks.heat_W)
    rest = blocks.heat_W - mean
    low, high = np.quantile(rest, (0.1, 0.9))
    levels = tuple(float(np.average(rest[own], weights=blocks.weight[own])) for own in blocks.by_run.T > 0.0)
    scatter = _scatter(blocks)
    plain = blocks.square(rest) > (PLAIN * blocks.deviation_W) ** 2
    pattern, since = _pattern(blocks, rest, scatter) if plain and scatter >= LEAST else ("even", None)
    return Uneven(pattern, scatter, float(low), float(high), blocks.deviation_W, levels, since)


def _scatter(blocks: _Turning) -> float:
    """Scatter about the mean at each speed beyond what is uncertain, over the size of that mean."""
    mean = blocks.mean(blocks.by_speed, blocks.heat_W)
    scatter = max(blocks.square(blocks.heat_W - mean) - blocks.deviation_W**2, 0.0)
    return float(np.sqrt(scatter / max(blocks.square(mean), 1e-12)))


def _pattern(blocks: _Turning, rest: FloatArray, scatter: float) -> tuple[Pattern, tuple[int, float, float] | None]:
    """Say what the scatter about the mean at each speed goes with, and when it changed for good."""
    total = blocks.square(rest)
    levels = blocks.mean(np.column_stack([blocks.by_speed, blocks.by_run]), blocks.heat_W)
    by_run = 1.0 - blocks.square(blocks.heat_W - levels) / total
    grown, for_good = min((_for_good(blocks, sign) for sign in (1.0, -1.0)), key=lambda one: one[1])
    for_good = 1.0 - for_good / total
    if scatter < UNEVEN:
        several = blocks.by_run.shape[1] >= FEWEST
        told_so = max(for_good, by_run) >= MOSTLY
        return (("grows" if for_good >= MOSTLY else "by run") if several and told_so else "even"), None
    if for_good >= SINCE and for_good >= by_run:
        at = int(np.searchsorted(np.abs(grown - grown[0]), 0.5 * abs(grown[-1] - grown[0])))
        run = int(blocks.run[at])
        before = float(blocks.time_s[at - 1]) if at and blocks.run[at - 1] == run else 0.0
        return "since", (run, before / 3600.0, float(blocks.time_s[at]) / 3600.0)
    return ("by run" if by_run >= BY_RUN else "comes and goes"), None


def _for_good(blocks: _Turning, sign: float) -> tuple[FloatArray, float]:
    """Fit heat that goes with speed, and what only grows (or falls) beside it: that, and the rest's mean square."""
    mean = blocks.mean(blocks.by_speed, blocks.heat_W)
    grown = np.zeros_like(mean)
    for _ in range(ROUNDS):  # by turns (backfitting)
        grown = sign * isotonic_regression(sign * (blocks.heat_W - mean), weights=blocks.weight).x
        mean = blocks.mean(blocks.by_speed, blocks.heat_W - grown)
    return grown, blocks.square(blocks.heat_W - mean - grown)


def told(found: Uneven, component: str, names: Sequence[str]) -> str:
    """Say what is uneven, for a user.

    Parameters
    ----------
    found
        What the course is like.
    component
        Where.
    names
        Of the runs.

    Returns
    -------
    str
        Empty where it goes with speed.
    """
    if found.pattern == "even":
        return ""
    place = "the motor" if component == WHOLE else component
    known = f"(each known to {found.deviation_W:.2g} W)"
    if found.pattern == "since":
        assert found.since is not None
        run, earliest_h, latest_h = found.since
        when = f"{earliest_h:.1f} to {latest_h:.1f} h into " if latest_h > AT_ONCE_H else ""
        return (
            f"{place}: since {when}{Path(names[run]).name} another heat is missing at the same speed than before, by "
            f"{found.high_W - found.low_W:.2g} W {known}: the motor, what it drives or what cools it has changed. "
            "Refine the runs before and after it apart"
        )
    each = ", ".join(f"{Path(n).name} {level:+.2g} W" for n, level in zip(names, found.levels_W, strict=True))
    if found.pattern == "grows":
        return (
            f"{place}: the heat that is missing at the same speed goes one way from run to run ({each}, against their "
            "mean): something wears, gathers dust, or is loaded ever more. It is no property of the motor that all "
            "runs share"
        )
    if found.pattern == "by run":
        return (
            f"{place}: the heat that is missing at the same speed is another one in each run ({each}, against their "
            "mean): something was otherwise that no column holds (a fan, a load, the supply, how it was mounted). Log "
            "it, or refine the runs that are alike apart"
        )
    return (
        f"{place}: what is missing comes and goes like a heat from {found.low_W:+.2g} to {found.high_W:+.2g} W about "
        f"its mean at each speed {known}, and nothing in the columns goes with it: a load, a fan, the sun, a "
        "neighbour, or a part that sticks at times. No number of the file can be that: log it (a motor's current "
        "tells its load) and refine again. The report draws it over time"
    )
