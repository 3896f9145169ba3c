"""Whether what is missing goes with speed, as anything that a file can hold does, or comes and goes by itself.

A wrong number, a part without a sensor, a worn bearing: their heat is nearly the same whenever a speed is run again.
That of a load or the sun which no column holds is not; nor is what moving air or a cover does to the cooling.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import isotonic_regression
from scipy.stats import pearsonr

from gen.arrays import BoolArray, FloatArray
from gen.refinement.network.over_time.courses import Course

UNEVEN = 0.45
"""Scatter of it about its mean at each speed, over the size of that mean, from which it comes and goes."""
PLAIN, IN_ORDER, MANY = 2.0, 1.0, 5
"""By how many of its standard deviations it has to scatter; by how many where it goes one way in the order of so many
runs, which chance does not bring about: five are in one of two orders of 120."""
LEFT = 0.5
"""Share of the weighed squares up to which a course explains what is left."""
SINCE, BY_RUN = 0.75, 0.6
"""Share of the scatter that one change for good explains, or one level for each run."""
DEGREE = 3
"""Of the polynomial over speed."""
LEAST, LITTLE, FEWEST, MOSTLY = 0.25, 0.6, 3, 0.7
"""Scatter from and up to which, runs, and share of that scatter, from which heat that goes one way in their order, or
is another one in each, is told beside a larger mean that goes with speed."""
HELD, AGAIN, DOUBT = 0.02, 0.03, 0.3
"""Shares of full speed: by which blocks of one held speed differ at most; how near a speed is when it is run again
(standard deviation). And how many blocks' worth of no difference is believed beside those of other runs."""
MIDDLE = 0.25
"""Share of what grows for good from which, and to which from its end, the time is taken that it needs."""
TURNS = 0.9
"""Share of a block in which the motor has to turn: at rest another heat is missing."""
STEADY, TREND = 0.15, 0.01
"""Scatter from which, and p-value below which, levels of many runs stand in a line: what wears by and by, at a place
that only nearly is where its heat arises, scatters within the runs as well."""
ROUNDS = 20
Pattern = Literal["even", "comes and goes", "by run", "since", "grows"]
PARTING: tuple[Pattern, ...] = ("by run", "since", "grows")
"""Patterns of what the runs do not share."""


@dataclass(frozen=True, eq=False)
class Uneven:
    """What a course is like while the motor turns, in its unit.

    Attributes
    ----------
    pattern
        "even": it goes with speed. Else it "comes and goes" within runs, is another one "by run", changed for good
        within them ("since"), or "grows" (or falls) little by little, both in the order of the runs.
    scatter
        About its mean at each speed, over the size of that mean.
    low, high
        Between which it is beside its mean at each speed, 80 % of the time.
    deviation
        How well it is known.
    levels
        The mean in each run, beside that of all runs at each speed.
    since
        Of "since" alone: the run, and between which hours into it.
    """

    pattern: Pattern
    scatter: float
    low: float
    high: float
    deviation: float
    levels: tuple[float, ...]
    since: tuple[int, float, float] | None = None


class _Turning:
    """The blocks of all runs in which the motor turns, in the order of the runs.

    Parameters
    ----------
    course
        The course.
    """

    def __init__(self, course: Course) -> None:
        used = [one.turning > TURNS for one in course.runs]
        self.run = np.concatenate([np.full(int(u.sum()), one.run) for one, u in zip(course.runs, used, strict=True)])
        self.time_s = np.concatenate([one.time_s[u] for one, u in zip(course.runs, used, strict=True)])
        self.value = np.concatenate([one.value[u] for one, u in zip(course.runs, used, strict=True)])
        deviation = np.concatenate([one.deviation[u] for one, u in zip(course.runs, used, strict=True)])
        self.weight = 1.0 / np.maximum(deviation, 1e-9) ** 2
        self.speed = np.concatenate([one.speed[u] for one, u in zip(course.runs, used, strict=True)])
        self.by_speed: FloatArray = np.vander(self.speed, DEGREE + 1)
        self.by_run = (self.run[:, None] == np.unique(self.run)).astype(np.float64)

    @property
    def deviation(self) -> float:
        """How well it is known in a block."""
        return float(1.0 / np.sqrt(np.mean(self.weight)))

    def mean(self, functions: FloatArray, value: FloatArray) -> FloatArray:
        """It as far as functions give it, shape (k,)."""
        root = np.sqrt(self.weight)
        found = np.linalg.lstsq(functions * root[:, None], value * root, rcond=None)[0]
        return np.asarray(functions @ found)

    def square(self, value: FloatArray, where: BoolArray | None = None) -> float:
        """Its mean square, in some blocks or in all."""
        weight = self.weight if where is None else np.where(where, self.weight, 0.0)
        return float(np.average(value**2, weights=weight))

    @property
    def held(self) -> BoolArray:
        """Blocks before and after which the speed was the same: of a course others tell that speed's value late."""
        same = (np.abs(np.diff(self.speed)) < HELD) & (np.diff(self.run) == 0)
        return np.asarray(np.r_[False, same] & np.r_[same, False])

    def of_other_runs(self, value: FloatArray) -> FloatArray:
        """Give what other runs have of it at the same speed, shape (k,), nearly 0 where none has that speed.

        A local mean (Nadaraya, On estimating regression, Theory of Probability and its Applications 9, 1964).
        """
        near = np.exp(-0.5 * ((self.speed[:, None] - self.speed) / AGAIN) ** 2) * self.weight
        near *= self.run[:, None] != self.run
        return np.asarray(near @ value / (near.sum(axis=1) + DOUBT * np.median(self.weight)))


def uneven(courses: Sequence[Course]) -> Uneven | None:
    """Judge the likeliest course.

    Parameters
    ----------
    courses
        At each place, the likeliest first.

    Returns
    -------
    uneven
        None where no course explains what is left, or the motor hardly turns.
    """
    course = courses[0]
    blocks = _Turning(course)
    if course.left > LEFT or course.evidence <= 0.0 or blocks.value.size <= 2 * (DEGREE + 1):
        return None
    mean = blocks.mean(blocks.by_speed, blocks.value)
    rest = blocks.value - mean
    low, high = np.quantile(rest, (0.1, 0.9))
    levels = tuple(float(np.average(rest[own], weights=blocks.weight[own])) for own in blocks.by_run.T > 0.0)
    scatter = _scatter(blocks)
    size = float(np.sqrt(blocks.square(rest))) / blocks.deviation
    pattern, since = _pattern(blocks, rest, scatter) if size > IN_ORDER and scatter >= LEAST else ("even", None)
    if size <= PLAIN and not (pattern == "grows" and len(levels) >= MANY):
        pattern, since = "even", None
    if pattern == "comes and goes" and _narrowly_even(blocks, mean):
        pattern = "even"
    if pattern != "since" and scatter >= STEADY and _in_line(levels, blocks.deviation):
        pattern = "grows"
    return Uneven(pattern, scatter, float(low), float(high), blocks.deviation, levels, since)


def _scatter(blocks: _Turning) -> float:
    """Scatter about the mean at each speed beyond what is uncertain, over the size of that mean."""
    mean = blocks.mean(blocks.by_speed, blocks.value)
    scatter = max(blocks.square(blocks.value - mean) - blocks.deviation**2, 0.0)
    return float(np.sqrt(scatter / max(blocks.square(mean), 1e-12)))


def _in_line(levels: Sequence[float], deviation: float) -> bool:
    """Whether levels of many runs go one way in their order, by more than how well one block is known."""
    if len(levels) < MANY or max(levels) - min(levels) <= deviation:
        return False
    return bool(pearsonr(np.arange(len(levels)), levels).pvalue < TREND)


def _narrowly_even(blocks: _Turning, mean: FloatArray) -> bool:
    """Whether it is what other runs have at nearly the same speed: a resonance, which no smooth mean follows."""
    held = blocks.held
    if not held.any():
        return False
    again = mean + blocks.of_other_runs(blocks.value - mean)
    left = blocks.square(blocks.value - again, held)
    told = left < blocks.square(blocks.value - mean, held)  # else other runs say nothing of it
    return told and left - blocks.deviation**2 < UNEVEN**2 * blocks.square(again, held)


def _pattern(blocks: _Turning, rest: FloatArray, scatter: float) -> tuple[Pattern, tuple[int, float, float] | None]:
    """Say what the scatter about the mean at each speed goes with, and when it changed for good."""
    total = blocks.square(rest)
    levels = blocks.mean(np.column_stack([blocks.by_speed, blocks.by_run]), blocks.value)
    by_run = 1.0 - blocks.square(blocks.value - levels) / total
    grown, for_good = min((_for_good(blocks, sign) for sign in (1.0, -1.0)), key=lambda one: one[1])
    for_good = 1.0 - for_good / total
    if scatter < LITTLE and blocks.by_run.shape[1] >= FEWEST and max(for_good, by_run) >= MOSTLY:
        return ("grows" if for_good >= MOSTLY else "by run"), None
    if scatter < UNEVEN:
        return "even", None
    if for_good >= SINCE and for_good >= by_run:
        if _by_and_by(blocks, grown):
            return "grows", None
        at = int(np.searchsorted(np.abs(grown - grown[0]), 0.5 * abs(grown[-1] - grown[0])))
        run = int(blocks.run[at])
        before = float(blocks.time_s[at - 1]) if at and blocks.run[at - 1] == run else 0.0
        return "since", (run, before / 3600.0, float(blocks.time_s[at]) / 3600.0)
    return ("by run" if by_run >= BY_RUN else "comes and goes"), None


def _by_and_by(blocks: _Turning, grown: FloatArray) -> bool:
    """Whether what only grows, shape (k,), takes more than a run for the middle half of it, where there are enough."""
    runs = blocks.by_run.shape[1]
    share = (grown - grown[0]) / (grown[-1] - grown[0])
    taken = int(np.searchsorted(share, 1.0 - MIDDLE)) - int(np.searchsorted(share, MIDDLE))
    return bool(runs >= FEWEST and taken > share.size / runs)


def _for_good(blocks: _Turning, sign: float) -> tuple[FloatArray, float]:
    """Fit what goes with speed, and what only grows (or falls) beside it: that, and the rest's mean square."""
    mean = blocks.mean(blocks.by_speed, blocks.value)
    grown = np.zeros_like(mean)
    for _ in range(ROUNDS):  # by turns (backfitting)
        grown = sign * isotonic_regression(sign * (blocks.value - mean), weights=blocks.weight).x
        mean = blocks.mean(blocks.by_speed, blocks.value - grown)
    return grown, blocks.square(blocks.value - mean - grown)
