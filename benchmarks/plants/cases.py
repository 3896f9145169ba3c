"""The matrix of cases: plants, what is measured of them, and the room; each written as a folder of run files."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.course import LEAD_S, Course, course
from benchmarks.plants.decoys import CHANNELS, decoys, electric
from benchmarks.plants.disturbance import disturbance
from benchmarks.plants.draw import random_plant
from benchmarks.plants.files import write
from benchmarks.plants.plant import Plant
from benchmarks.plants.profiles import DataKind, Profile, fitted, fresh
from benchmarks.plants.rooms import Room, RoomKind, random_room
from benchmarks.plants.sensors import Sensor, random_sensor

FloatArray = NDArray[np.float64]
Columns = dict[str, FloatArray | NDArray[np.int64]]


@dataclass(frozen=True, order=True)
class Case:
    """A plant, by its seed, with what identification is given of it."""

    seed: int
    data: DataKind
    room: RoomKind

    def __str__(self) -> str:
        return f"{self.seed}:{self.data}:{self.room}"

    @classmethod
    def parse(cls, text: str) -> Case:
        """Read `SEED:DATA:ROOM`.

        Raises
        ------
        ValueError
            If it is none.
        """
        seed, data, room = text.split(":")
        return cls(int(seed), DataKind(data), RoomKind(room))


def matrix(seeds: Iterable[int], data: Iterable[DataKind], rooms: Iterable[RoomKind]) -> list[Case]:
    """All cases of some plants; any beginning of the list has as many cells of each kind as can be."""
    return [Case(*cell) for cell in product(seeds, data, rooms)]


@dataclass(frozen=True, eq=False)
class Bench:
    """A plant on its test bench.

    Parameters
    ----------
    seed, plant
        The motor.
    sensors
        One for each sensed node.
    thermometer
        Of the room.
    usual
        The room's usual temperature, degC.
    row_s
        From row to row, s.
    lost
        Share of rows that the logger lost.
    channels
        What else is logged.
    """

    seed: int
    plant: Plant
    sensors: tuple[Sensor, ...]
    thermometer: Sensor
    usual: float
    row_s: float
    lost: float
    channels: tuple[str, ...]

    def chance(self, *names: str) -> np.random.Generator:
        """The chance of something named: the same whatever else is drawn."""
        return np.random.default_rng([20272, self.seed, zlib.crc32("/".join(names).encode())])


@lru_cache(maxsize=4)
def bench(seed: int) -> Bench:
    """Draw a plant and its bench."""
    plant = random_plant(seed)
    rng = np.random.default_rng([20273, seed])
    logged = rng.permutation(CHANNELS)[: int(rng.integers(2, 5))]
    return Bench(
        seed,
        plant,
        tuple(random_sensor(rng) for _ in plant.sensed),
        random_sensor(rng),
        float(rng.uniform(18.0, 28.0)),
        float(rng.choice([1.0, 2.0])),
        float(rng.choice([0.0, 0.005])),
        tuple(str(name) for name in logged),
    )


@dataclass(frozen=True, eq=False)
class Measured:
    """One run and what was written of it.

    Parameters
    ----------
    profile, room, run
        What was done, where, and what truly happened.
    columns
        Of the run file.
    """

    profile: Profile
    room: Room
    run: Course
    columns: Columns

    @property
    def notes(self) -> dict[str, str]:
        """What whoever ran it wrote down: the room, to a kelvin, where neither a column nor a cold start tells it."""
        told = self.room.measured or not self.profile.before
        return {} if told else {"ambient_degC": f"{self.run.ambient[0]:.0f}"}


def measure(bench: Bench, profile: Profile, kind: RoomKind) -> Measured:
    """Run a motor and log it."""
    rng = bench.chance("room", kind, profile.name)
    lead = LEAD_S + sum(seconds for _, seconds in profile.before)
    room = random_room(rng, kind, bench.usual, profile.duration, lead)
    run = course(bench.plant, profile, room, bench.row_s)
    rng = bench.chance("sensors", kind, profile.name)
    columns: Columns = {"time_s": run.time, "pwm": run.pwm}
    for sensor, node in zip(bench.sensors, bench.plant.sensed, strict=True):
        columns[f"{bench.plant.names[node]}_degC"] = sensor.read(rng, run.temperature[:, node], bench.row_s)
    if room.measured:
        columns["ambient_degC"] = bench.thermometer.read(rng, run.ambient, bench.row_s)
    columns |= decoys(rng, electric(bench.plant.losses, run.pwm), run, bench.channels)
    rows = kept(rng, run.pwm, bench.lost)
    run = Course(run.time[rows], run.pwm[rows], run.temperature[rows], run.ambient[rows])
    return Measured(profile, room, run, {name: values[rows] for name, values in columns.items()})


def kept(rng: np.random.Generator, pwm: NDArray[np.int64], lost: float) -> NDArray[np.bool_]:
    """Rows that the logger did not lose; where PWM changes and at the ends it loses none."""
    rows = rng.random(pwm.size) >= lost
    rows[0] = rows[-1] = True
    rows[1:] |= pwm[1:] != pwm[:-1]
    return np.asarray(rows)


@dataclass(frozen=True, eq=False)
class Written:
    """A case's files.

    Parameters
    ----------
    case, bench
        What they are of.
    fit, test
        Run files to identify from and to test with.
    floor_K
        Root mean square of measured minus true over all sensed nodes of the test runs: noise, quantiser, bias and lag.
    """

    case: Case
    bench: Bench
    fit: tuple[Path, ...]
    test: tuple[Path, ...]
    floor_K: float


def write_case(case: Case, folder: Path, disturbed_K: float = 0.0) -> Written:
    """Write a case's run files into a folder.

    Parameters
    ----------
    case
        Which.
    folder
        Where.
    disturbed_K
        Standard deviation of a slow disturbance of all but the test runs, K.
    """
    stand = bench(case.seed)
    runs = [measure(stand, profile, case.room) for profile in fitted(case.data, profile_chance(stand))]
    if disturbed_K > 0.0:
        runs = [_disturbed(stand, run, disturbed_K) for run in runs]
    trials = fresh_runs(stand, case.room)
    paths: list[Path] = []
    for measured in (*runs, *trials):
        paths.append(folder / f"{measured.profile.name}.csv")
        write(paths[-1], measured.columns, measured.notes)
    return Written(case, stand, tuple(paths[: len(runs)]), tuple(paths[len(runs) :]), floor(stand.plant, trials))


def _disturbed(stand: Bench, run: Measured, size_K: float) -> Measured:
    """The same with all readings of the motor's parts off by something slow."""
    time_s = np.asarray(run.columns["time_s"], dtype=np.float64)
    names = [f"{stand.plant.names[node]}_degC" for node in stand.plant.sensed]
    added = size_K * disturbance(time_s, len(names), stand.chance("disturbance", run.profile.name))
    columns = {name: np.asarray(run.columns[name] + added[:, k]) for k, name in enumerate(names)}
    return replace(run, columns={**run.columns, **columns})


def profile_chance(stand: Bench) -> Callable[[str], np.random.Generator]:
    """Each profile's own chance: whatever the room does, the same is done with the motor."""
    return lambda name: stand.chance("profile", name)


def fresh_runs(stand: Bench, room: RoomKind) -> tuple[Measured, ...]:
    """The runs to test with: the same for all data that identification is given."""
    return tuple(measure(stand, profile, room) for profile in fresh(profile_chance(stand)))


def floor(plant: Plant, runs: Iterable[Measured]) -> float:
    """Root mean square of measured minus true at the sensed nodes, K."""
    errors = [
        run.columns[f"{plant.names[node]}_degC"] - run.run.temperature[:, node] for run in runs for node in plant.sensed
    ]
    every = np.concatenate(errors)
    return float(np.sqrt(np.nanmean(every**2)))
