"""One case: what one run leaves open, and what a planned and a random one say of it."""

from __future__ import annotations

import traceback
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import gen
from benchmarks.network_refinement.judge import identified
from benchmarks.plants.files import write
from benchmarks.plants.planted.draw import NotVisible
from benchmarks.plants.planted.later import Logged, log, used
from benchmarks.plants.planted.trial import Setting, setting
from benchmarks.plants.profiles import Profile

FIRST, NEXT, TEST = "later_1", "later_2", "test_1"
GRID_S = 2.0


@dataclass(frozen=True)
class Case:
    """What is planted on which motor, and how long runs are.

    Parameters
    ----------
    seed
        Of the motor.
    effect
        What is planted.
    fit_hours, hours
        Of the first run, and of the next.
    """

    seed: int
    effect: str
    fit_hours: float
    hours: float

    def __str__(self) -> str:
        return f"{self.seed}:{self.effect}"


@dataclass
class Named:
    """What refinement says after some runs.

    Parameters
    ----------
    names
        In order.
    lookalikes
        Of the first.
    right
        Whether the first is what was planted.
    settled
        Of planned runs: whether they told, one sentence each.
    """

    names: list[str]
    lookalikes: list[str]
    right: bool
    settled: list[str] = field(default_factory=list)

    @property
    def alone(self) -> bool:
        """Whether the first is what was planted, and no other is tied with it."""
        return self.right and not self.lookalikes


@dataclass
class Judged:
    """A case.

    Parameters
    ----------
    case
        Which.
    status
        `ok`; `clear`, where one run is enough; `failed` for anything else.
    message
        Why there is no result.
    hypotheses
        What the first run leaves open, the name it gives first.
    right
        Whether that is what was planted.
    among
        Whether what was planted is among the hypotheses.
    planned_floors, plain_floors
        The separation that is expected of the named hypothesis and the nearest other one, by the planned run and by
        the best plain one.
    planned, random
        After either run.
    """

    case: str
    status: str = "ok"
    message: str = ""
    hypotheses: list[str] = field(default_factory=list)
    right: bool = False
    among: bool = False
    planned_floors: float = float("nan")
    plain_floors: float = float("nan")
    planned: Named | None = None
    random: Named | None = None


def judge(case: Case, models: Path, folder: Path) -> Judged:
    """Judge a case in an empty folder."""
    result = Judged(str(case))
    try:
        made = setting(case.seed, (case.effect,))
        model = identified(made, models)
        first = _write(made, FIRST, folder / "first.csv", _cut(used(made.bench, FIRST), case.fit_hours), {})
        plan = gen.plan(model, [first], hours=case.hours)
        _open(plan, case, result)
        if result.status != "ok":
            return result
        plan.save(folder / "profile.csv")
        test = _write(made, TEST, folder / "test.csv", None, {})
        holds = _on_grid(plan.found.holds)
        planned = _write(made, NEXT, folder / "planned.csv", Profile("planned", holds), plan.found.comments())
        random = _write(made, NEXT, folder / "random.csv", _cut(used(made.bench, NEXT), case.hours), {})
        result.planned = named(model, [first, planned], test, case.effect)
        result.random = named(model, [first, random], test, case.effect)
    except NotVisible as error:
        result.status, result.message = "failed", f"no bench shows it: {error}"
    except Exception as error:  # of whatever kind: no case is dropped without a word
        place = traceback.extract_tb(error.__traceback__)[-1]
        said = f"{type(error).__name__}: {error} ({place.name}:{place.lineno})"
        result.status, result.message = "failed", said.replace(f"{folder}/", "").replace(f"{models}/", "")
    return result


def _open(plan: gen.Plan, case: Case, result: Judged) -> None:
    """What the first run leaves open."""
    found = plan.found
    names = [one.name for one in found.hypotheses]
    result.hypotheses = list(plan.hypotheses)
    result.right = [*found.beside, names[0]][0] == case.effect
    result.among = case.effect in (*found.beside, *names)
    rivals = [name for name in names[1:] if name != "none"]
    if result.right and not rivals:
        result.status = "clear"
    nearest = [one for one in found.told if one.first == 0]
    if nearest:
        least = min(nearest, key=lambda one: one.planned_K)
        result.planned_floors = least.planned_K / found.noise_K
        result.plain_floors = least.plain_K / found.noise_K


def named(model: gen.Model, fit: Sequence[Path], test: Path, effect: str) -> Named:
    """What refinement says of some runs."""
    found = gen.refine(model, fit=list(fit), test=[test])
    rows: list[dict[str, Any]] = found.details()["effects"]
    names = [row["name"] for row in rows]
    lookalikes = [other["name"] for other in rows[0]["evidence"]["lookalikes"]] if rows else []
    said = [one["sentence"] for one in found.details()["planned"]]
    settled = [text.partition(": ")[2] for text in said]
    return Named(names, lookalikes, bool(names) and names[0] == effect, settled)


def _write(made: Setting, name: str, path: Path, profile: Profile | None, notes: dict[str, str]) -> Path:
    changes = [one.change for one in made.planted]
    run: Logged = log(made.bench, changes, name, profile)
    write(path, run.columns, notes)
    return path


def _cut(profile: Profile, hours: float) -> Profile:
    """The beginning of a profile."""
    left, holds = 3600.0 * hours, []
    for pwm, seconds in profile.holds:
        if left <= 0.0:
            break
        holds.append((pwm, min(seconds, left)))
        left -= seconds
    return Profile(profile.name, tuple(holds), profile.before)


def _on_grid(holds: Sequence[tuple[int, float]]) -> tuple[tuple[int, float], ...]:
    """Holds that end at rows of every run file."""
    made, begin, end = [], 0.0, 0.0
    for pwm, seconds in holds:
        end += seconds
        at = GRID_S * round(end / GRID_S)
        made.append((pwm, at - begin))
        begin = at
    return tuple(made)
