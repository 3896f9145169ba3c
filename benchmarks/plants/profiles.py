"""What is done with a motor: holds of PWM, in runs to identify from and in others to test with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

GRID_S = 2.0
"""Holds begin at multiples of this, which every run file has rows at."""
STEP_LEVELS = (51, 102, 153, 204, 255)
HOUR = 3600.0


class DataKind(StrEnum):
    """What identification is given."""

    STEPS = "steps"
    MIXED = "mixed"
    LONG = "long"
    UNSETTLED = "unsettled"


@dataclass(frozen=True)
class Profile:
    """One run.

    Parameters
    ----------
    name
        Of its file.
    holds
        PWM in counts and for how long in s, one after the other.
    before
        What was done right before the run, from cold.
    """

    name: str
    holds: tuple[tuple[int, float], ...]
    before: tuple[tuple[int, float], ...] = ()

    @property
    def duration(self) -> float:
        """Of the run, s."""
        return sum(seconds for _, seconds in self.holds)


def fitted(kind: DataKind, rng: Callable[[str], np.random.Generator]) -> tuple[Profile, ...]:
    """The runs to identify from.

    Parameters
    ----------
    kind
        Which.
    rng
        Gives each run's own chance by its name, so that a run is the same in every kind that has it.
    """
    steps = tuple(Profile(f"step_{pwm}", ((pwm, 3 * HOUR),)) for pwm in STEP_LEVELS)
    match kind:
        case DataKind.STEPS:
            return steps
        case DataKind.MIXED:
            first = Profile("mixed_1", _holds(rng("mixed_1"), 4 * HOUR, (10.0, 44.0)))
            return (*steps, first, Profile("mixed_2", _holds(rng("mixed_2"), 4 * HOUR, (10.0, 44.0), stops=0.2)))
        case DataKind.LONG:
            return (Profile("long", _holds(rng("long"), 10 * HOUR, (10.0, 44.0), stops=0.2)),)
        case DataKind.UNSETTLED:
            return tuple(_unsettled(rng(name), name) for name in (f"unsettled_{i}" for i in range(1, 11)))


def fresh(rng: Callable[[str], np.random.Generator]) -> tuple[Profile, ...]:
    """Two runs to test with: one that turns all the time, one with stops and reversals."""
    turning = Profile("test_turning", _holds(rng("test_turning"), 4 * HOUR, (4.0, 35.0)))
    stopping = _holds(rng("test_stopping"), 4 * HOUR, (4.0, 35.0), stops=0.25, backwards=0.4)
    return (turning, Profile("test_stopping", stopping))


def later(rng: Callable[[str], np.random.Generator], names: Sequence[str], hours: float = 4.0) -> tuple[Profile, ...]:
    """Runs of a motor in use, each with stops and reversals, which begin cold.

    Parameters
    ----------
    rng
        Gives each run's own chance by its name.
    names
        Of the runs.
    hours
        How long each lasts, h; a shorter one is the beginning of a longer one of the same name.
    """
    return tuple(Profile(name, _used(rng(name), hours)) for name in names)


def _used(rng: np.random.Generator, hours: float) -> tuple[tuple[int, float], ...]:
    return _holds(rng, hours * HOUR, (4.0, 40.0), stops=0.2, backwards=0.25)


def _holds(
    rng: np.random.Generator, total: float, minutes: tuple[float, float], stops: float = 0.0, backwards: float = 0.0
) -> tuple[tuple[int, float], ...]:
    """Random levels, each held for some minutes, until the time is up; no stop comes first or follows another.

    Parameters
    ----------
    rng
        Where chance comes from.
    total
        s.
    minutes
        Of a hold, from and to.
    stops, backwards
        Shares of holds at rest, and of the others in the other direction.
    """
    found: list[tuple[int, float]] = []
    left = total
    while left > 0.0:
        seconds = min(left, _grid(60.0 * float(rng.uniform(*minutes))))
        level = int(rng.integers(STEP_LEVELS[0], STEP_LEVELS[-1] + 1))
        rest, back = rng.random() < stops, rng.random() < backwards
        if rest and found and found[-1][0] != 0:
            level = 0
        found.append((-level if back else level, seconds))
        left -= seconds
    return tuple(found)


def _unsettled(rng: np.random.Generator, name: str) -> Profile:
    """Some minutes of running and ten of rest, several times; some begin warm from what was done before."""
    holds: list[tuple[int, float]] = []
    for _ in range(int(rng.integers(3, 7))):
        level = int(rng.integers(STEP_LEVELS[0], STEP_LEVELS[-1] + 1))
        holds += [(level, _grid(60.0 * float(rng.uniform(2.0, 15.0)))), (0, 600.0)]
    warm = ((int(rng.integers(STEP_LEVELS[0], STEP_LEVELS[-1] + 1)), 900.0), (0, 600.0))
    return Profile(name, tuple(holds), warm if rng.random() < 0.3 else ())


def _grid(seconds: float) -> float:
    return GRID_S * round(seconds / GRID_S)
