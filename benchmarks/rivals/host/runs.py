"""Run files of any number and length, of a motor of `benchmarks.plants` before and after it has changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from benchmarks.plants.cases import Bench, bench, measure, profile_chance
from benchmarks.plants.files import write
from benchmarks.plants.profiles import later
from benchmarks.plants.rooms import RoomKind

SEED = 7
"""Of a motor of five nodes, four of them measured; a row each second, none lost."""
DUSTY = 0.7
"""What is left of its conductances to the room when there is something to refine."""


def write_runs(folder: Path, prefix: str, count: int, hours: float, *, dusty: bool = False) -> list[Path]:
    """Write runs of the motor in use, each from cold.

    Parameters
    ----------
    folder
        Where; it is made.
    prefix
        Of the files' names; the same gives the same profiles, longer or shorter.
    count, hours
        How many, and how long each.
    dusty
        Whether its ways to the room have got worse.
    """
    folder.mkdir(parents=True, exist_ok=True)
    stand = _dusty(bench(SEED)) if dusty else bench(SEED)
    names = [f"{prefix}_{number}" for number in range(1, count + 1)]
    return [_written(folder, stand, name, hours) for name in names]


def _written(folder: Path, stand: Bench, name: str, hours: float) -> Path:
    (profile,) = later(profile_chance(stand), (name,), hours)
    path = folder / f"{name}.csv"
    write(path, measure(stand, profile, RoomKind.HELD).columns)
    return path


def _dusty(stand: Bench) -> Bench:
    surfaces = tuple(
        replace(one, law=replace(one.law, rest=DUSTY * one.law.rest), natural=DUSTY * one.natural)
        for one in stand.plant.surfaces
    )
    return replace(stand, plant=replace(stand.plant, surfaces=surfaces))
