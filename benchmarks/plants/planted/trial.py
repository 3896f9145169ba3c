"""Trials of refinement: a bench, what was changed on it, and the run files before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from benchmarks.plants.cases import Bench, bench, measure, profile_chance
from benchmarks.plants.files import write
from benchmarks.plants.planted.draw import NotVisible, Planted, planted
from benchmarks.plants.planted.kinds import KINDS
from benchmarks.plants.planted.later import FIT_NAMES, TEST_NAMES, floor, log
from benchmarks.plants.profiles import DataKind, fitted
from benchmarks.plants.rooms import RoomKind

NOTHING = "nothing"
FARTHER = 1000
"""Seeds to the next bench to try, where the sensors of one do not see a change."""
BENCHES = 12
"""How many of them are tried."""


@dataclass(frozen=True, order=True)
class Trial:
    """What is planted on a bench, and what is given of it.

    Parameters
    ----------
    seed
        Of the bench; where its sensors cannot see the change, another one stands in.
    names
        Of what is planted; none for nothing.
    fit_runs
        Two or six; up to 20 to see how long that takes.
    """

    seed: int
    names: tuple[str, ...]
    fit_runs: int

    def __str__(self) -> str:
        return f"{self.seed}:{'+'.join(self.names) or NOTHING}:{self.fit_runs}"

    @classmethod
    def parse(cls, text: str) -> Trial:
        """Read `SEED:NAME:FIT`, where NAME is `nothing`, a name, or several with + between them.

        Raises
        ------
        ValueError
            If it is none.
        """
        seed, what, fit = text.split(":")
        names = () if what == NOTHING else tuple(what.split("+"))
        unknown = [name for name in names if name not in KINDS]
        if unknown or not 1 <= int(fit) <= len(FIT_NAMES):
            raise ValueError(f"{text}: no trial")
        return cls(int(seed), names, int(fit))


@dataclass(frozen=True, eq=False)
class Setting:
    """A bench and what was changed on it."""

    bench: Bench
    planted: tuple[Planted, ...]

    @property
    def ambient_measured(self) -> bool:
        """Whether the room was measured while the motor was identified."""
        return not any(one.change.else_held for one in self.planted)


@lru_cache(maxsize=8)
def setting(seed: int, names: tuple[str, ...]) -> Setting:
    """Draw what is planted, on the bench of a seed or the first after it that sees all of it.

    Raises
    ------
    NotVisible
        If none does.
    """
    unseen = NotVisible(f"{'+'.join(names)}: no bench was tried")
    for attempt in range(BENCHES):
        stand = bench(seed + FARTHER * attempt)
        try:
            return Setting(stand, tuple(planted(stand, name, KINDS[name]) for name in names))
        except NotVisible as error:
            unseen = error
    raise unseen


@dataclass(frozen=True, eq=False)
class Written:
    """A trial's files.

    Parameters
    ----------
    trial, setting
        What they are of.
    fit, test
        Run files to refine with and to test with.
    floor_K
        Root mean square of read minus what a perfect model says, over all sensed nodes of the test runs.
    """

    trial: Trial
    setting: Setting
    fit: tuple[Path, ...]
    test: tuple[Path, ...]
    floor_K: float


def write_trial(trial: Trial, folder: Path) -> Written:
    """Write the later runs of a trial into a folder."""
    made = setting(trial.seed, trial.names)
    changes = [one.change for one in made.planted]
    names = (*FIT_NAMES[: trial.fit_runs], *TEST_NAMES)
    runs = [log(made.bench, changes, name) for name in names]
    paths = tuple(folder / f"{name}.csv" for name in names)
    for path, run in zip(paths, runs, strict=True):
        write(path, run.columns)
    fit = paths[: trial.fit_runs]
    return Written(trial, made, fit, paths[trial.fit_runs :], floor(made.bench, runs[trial.fit_runs :]))


def write_identification(made: Setting, folder: Path) -> tuple[Path, ...]:
    """Write the runs that identify the motor, before anything was changed: five steps and two mixed runs."""
    found = []
    for profile in fitted(DataKind.MIXED, profile_chance(made.bench)):
        measured = measure(made.bench, profile, RoomKind.HELD)
        columns = dict(measured.columns)
        if not made.ambient_measured:
            del columns["ambient_degC"]
        found.append(folder / f"{profile.name}.csv")
        write(found[-1], columns)
    return tuple(found)


def trials(seeds: Sequence[int], kinds: Sequence[tuple[str, ...]], fit_runs: Sequence[int]) -> list[Trial]:
    """All trials of some benches, bench by bench: any beginning of the list has each kind about as often."""
    return [Trial(seed, names, runs) for seed in seeds for names in kinds for runs in fit_runs]
