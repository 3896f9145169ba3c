"""What a planned run was to decide, and whether it did.

`gen plan` writes into its profile, in one comment line, between which hypotheses the run is to tell; the commands that
follow a profile copy the line into the run file, and so it comes here.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from gen.refinement.network.tracing.judged import Judged
from gen.refinement.network.tracing.search import Considered, Step
from gen.refinement.network.tracing.trace import Traced
from gen.runs import EXPECTS, Run

NONE = "none"
"""The hypothesis that there is no such effect."""
FOLLOWED = 0.9
"""Share of its time in which a run must have had the profile's PWM to count as planned."""


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class Pair(_Part):
    """Two hypotheses with how far apart the run is to be under them.

    Attributes
    ----------
    first, second
        Names of effects, or `none`.
    first_at, second_at
        Where they are, for people.
    floors, separation_K
        What is left of the difference of both predictions when all free numbers of one are fitted to the other, root
        mean square over sensors and time, in noise floors and in K.
    """

    first: str
    second: str
    first_at: str = ""
    second_at: str = ""
    floors: float = Field(ge=0.0, allow_inf_nan=False)
    separation_K: float = Field(ge=0.0, allow_inf_nan=False)


class Expectation(_Part):
    """What a planned run is to decide.

    Attributes
    ----------
    beside
        Names of the effects that were found before the open question.
    pairs
        Between which hypotheses it is to tell; none where it is to narrow intervals alone.
    holds
        The profile: PWM in counts, and for how long in s.
    """

    beside: tuple[str, ...] = ()
    pairs: tuple[Pair, ...]
    holds: tuple[tuple[int, float], ...] = Field(min_length=1)

    def text(self) -> str:
        """Give the comment's value, one line of JSON."""
        return json.dumps(self.model_dump(mode="json"), separators=(",", ":"))


@dataclass(frozen=True)
class Settled:
    """Whether a planned run told one pair of hypotheses apart, together with the runs before it.

    Attributes
    ----------
    run
        Its name.
    first, second
        The hypotheses.
    expected_floors
        How far apart the run was to be.
    found_floors
        By how much the worse of both predicts what was left out of that run worse, in noise floors; None where one of
        them was not among those judged.
    remains
        Which of both remain: as the name, or among its look-alikes. None where what they were to be told apart beside
        is found no more, so that nobody asked.
    """

    run: str
    first: str
    second: str
    expected_floors: float
    found_floors: float | None
    remains: tuple[str, ...] | None

    @property
    def told(self) -> bool | None:
        """Whether not both remain; None where nobody asked."""
        return None if self.remains is None else len(self.remains) < 2

    @property
    def sentence(self) -> str:
        """For people."""
        asked = f"{self.run}: was to tell {self.first} from {self.second} by {self.expected_floors:.1f} noise floors"
        if self.remains is None:
            return f"{asked}: what was found before is found no more, so that is no question now"
        found = "" if self.found_floors is None else f", by {self.found_floors:.1f}"
        if not self.told:
            return f"{asked}: it did not{found}, both remain"
        left = f"{self.remains[0]} remains" if self.remains else "neither remains"
        return f"{asked}: it did{found}, {left}"

    def summary(self) -> dict[str, Any]:
        """The JSON summary."""
        return {**asdict(self), "told": self.told, "sentence": self.sentence}


def settled(runs: Sequence[tuple[str, Run]], traced: Traced) -> tuple[tuple[Settled, ...], list[str]]:
    """Hold what was found against what planned runs were to decide.

    Parameters
    ----------
    runs
        The runs that were fitted, by name.
    traced
        What was found with all of them.

    Returns
    -------
    settled, warnings
        One for each pair of each planned run; sentences on runs whose comment cannot be read or that did not follow.
    """
    made: list[Settled] = []
    warnings: list[str] = []
    for number, (name, run) in enumerate(runs):
        text = run.comments.get(EXPECTS)
        if text is None:
            continue
        try:
            expected = Expectation.model_validate_json(text)
        except ValidationError as error:
            told = error.errors()[0]
            place = ".".join(map(str, told["loc"])) or "the whole"
            warnings.append(f"{name}: comment {EXPECTS}, {place}: {told['msg']}; it is no planned run")
            continue
        share = followed(expected, run)
        if share < FOLLOWED:
            warnings.append(f"{name}: had the planned PWM in {share:.0%} of its time alone; it is no planned run")
            continue
        made += [_settled(name, number, pair, _deciding(expected, pair, traced), traced) for pair in expected.pairs]
    return tuple(made), warnings


def followed(expected: Expectation, run: Run) -> float:
    """Give the share of the profile's time in which a run had its PWM."""
    levels = np.array([pwm for pwm, _ in expected.holds])
    ends = np.cumsum([seconds for _, seconds in expected.holds])
    time = run.time_s - run.time_s[0]
    asked = levels[np.minimum(np.searchsorted(ends, time[:-1], side="right"), levels.size - 1)]
    within = time[:-1] < ends[-1]
    step = np.diff(time)
    return float(np.sum(step[within & (asked == run.pwm[:-1])]) / ends[-1])


def _settled(name: str, number: int, pair: Pair, step: Step | None, traced: Traced) -> Settled:
    if step is None:
        return Settled(name, pair.first, pair.second, pair.floors, None, None)
    left = _names(step)
    remains = tuple(one for one in (pair.first, pair.second) if one in left)
    first, second = (_judged(step, one) for one in (pair.first, pair.second))
    found = None
    if first is not None and second is not None:
        found = float(np.sqrt(abs(_square(traced, number, first) - _square(traced, number, second)))) / first.noise_K
    return Settled(name, pair.first, pair.second, pair.floors, found, remains)


def _deciding(expected: Expectation, pair: Pair, traced: Traced) -> Step | None:
    """The search in which either was found, else that beside what was found before; None if that is found no more."""
    names, before = {pair.first, pair.second}, set(expected.beside)
    for step in traced.steps:
        if step.added is not None and step.added.effect.name in names:
            return step
    for number, step in enumerate(traced.steps):
        found = {one.added.effect.name for one in traced.steps[:number] if one.added is not None}
        if before <= found:
            return step
    return None


def _names(step: Step) -> set[str]:
    if step.added is None:
        return {NONE}
    return {one.effect.name for one in (step.added, *step.lookalikes)}


def _judged(step: Step, name: str) -> Judged | None:
    if name == NONE:
        return step.without
    found: list[Considered] = [one for one in step.considered if one.effect.name == name]
    return found[0].judged if found else None


def _square(traced: Traced, number: int, judged: Judged) -> float:
    """Mean square of the left-out errors in one run, K^2."""
    inputs = traced.data.inputs
    seen = (inputs.run == number)[:, None] & np.isfinite(judged.error)
    cover = np.where(seen, inputs.covered, 0.0)
    return float(np.sum(cover * np.nan_to_num(judged.error) ** 2) / max(float(cover.sum()), 1e-9))
