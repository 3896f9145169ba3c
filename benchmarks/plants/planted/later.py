"""The later runs of a bench on which something has been changed: what truly happens, and what is logged of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.cases import Bench, Columns, kept, profile_chance
from benchmarks.plants.course import Course, course
from benchmarks.plants.decoys import decoys
from benchmarks.plants.planted.altered import Altered
from benchmarks.plants.planted.change import Change, Steps
from benchmarks.plants.planted.paths import fan, metered
from benchmarks.plants.profiles import Profile, later
from benchmarks.plants.rooms import Room, RoomKind, random_room

FloatArray = NDArray[np.float64]
FIT_NAMES = tuple(f"later_{i}" for i in range(1, 21))
TEST_NAMES = ("test_1", "test_2")
ALL_NAMES = (*FIT_NAMES[:6], *TEST_NAMES, *FIT_NAMES[6:])
"""By number: what happens in a run may go with it."""
SOMETIMES = ("current_A", "voltage_V", "airflow_mps")
"""Channels that a bench may log of its later runs, whatever happens there: that one is logged tells nothing."""


@dataclass(frozen=True, eq=False)
class Followed:
    """What truly happened in one run.

    Parameters
    ----------
    profile, room
        What was done, and where.
    motor
        As it was changed.
    run
        Of it, evenly spaced.
    seen, room_seen
        What the sensors and the room's thermometer were at, degC, shape (N, sensed nodes) and (N,).
    """

    profile: Profile
    room: Room
    motor: Altered
    run: Course
    seen: FloatArray
    room_seen: FloatArray


def follow(
    stand: Bench,
    planted: Sequence[Change],
    name: str,
    row_s: float,
    start: FloatArray | None = None,
    instead: Profile | None = None,
) -> Followed:
    """Follow a run of a bench with changes.

    Parameters
    ----------
    stand, planted
        The bench, and what has been changed on it.
    name
        Of the run: one of `FIT_NAMES` and `TEST_NAMES`.
    row_s
        From row to row, s.
    start
        State at the first row; by itself what came before tells it.
    instead
        What is done in the place of the run's own profile; its room and its signals stay.
    """
    profile = used(stand, name) if instead is None else instead
    number = ALL_NAMES.index(name)
    for change in planted:
        profile = change.profile(stand.chance("before", name, type(change).__name__), profile)
    kind = RoomKind.HELD if stand.chance("later room").random() < 0.5 else RoomKind.MOVING
    if any(change.else_held for change in planted):
        kind = RoomKind.HELD
    room = random_room(stand.chance("room", name), kind, stand.usual, profile.duration, 0.0)
    signals: dict[str, Steps] = {}
    for change in planted:
        kind_of_it = type(change).__name__
        room = change.room(stand.chance("changed room", name, kind_of_it), room, profile.duration)
        signals |= change.signals(stand.chance("signals", name, kind_of_it), number, profile.duration)
    motor = Altered(stand.plant, planted, signals)
    run = course(motor, profile, room, row_s, start)
    seen = run.temperature[:, list(stand.plant.sensed)].copy()
    room_seen = run.ambient
    for change in planted:
        room_seen = change.room_seen(room_seen, run.temperature, run.time)
        for column, node in enumerate(stand.plant.sensed):
            seen[:, column] = change.seen(node, seen[:, column], run.time, run.ambient)
    return Followed(profile, room, motor, run, seen, room_seen)


def used(stand: Bench, name: str) -> Profile:
    """What is done with a motor in one of its later runs."""
    (profile,) = later(profile_chance(stand), (name,))
    return profile


@dataclass(frozen=True, eq=False)
class Logged:
    """A later run as its file has it.

    Parameters
    ----------
    name
        Of the file.
    followed
        What truly happened, with the rows that were lost.
    rows
        Which of them the file has.
    columns
        Of the file.
    """

    name: str
    followed: Followed
    rows: NDArray[np.bool_]
    columns: Columns

    def error(self, stand: Bench) -> FloatArray:
        """Read minus what a perfect model of what happened says, K, shape (rows, sensed nodes)."""
        read = [self.columns[f"{stand.plant.names[node]}_degC"] for node in stand.plant.sensed]
        return np.asarray(np.stack(read, axis=1) - self.followed.seen[self.rows])


def log(stand: Bench, planted: Sequence[Change], name: str, instead: Profile | None = None) -> Logged:
    """Run a motor and log it; with another profile in the place of the run's own, where one is given."""
    followed = follow(stand, planted, name, stand.row_s, instead=instead)
    run, rng = followed.run, stand.chance("sensors", name)
    columns: Columns = {"time_s": run.time, "pwm": run.pwm}
    for sensor, node, seen in zip(stand.sensors, stand.plant.sensed, followed.seen.T, strict=True):
        columns[f"{stand.plant.names[node]}_degC"] = sensor.read(rng, seen, stand.row_s)
    columns["ambient_degC"] = stand.thermometer.read(rng, followed.room_seen, stand.row_s)
    which = channels(stand, planted)
    columns |= decoys(rng, followed.motor.electric(run.time, run.pwm), run, which)
    varies = {signal: steps.along(run.time) for signal, steps in followed.motor.signals.items()}
    if "airflow_mps" in which:  # a fan that blows elsewhere, if none blows at the motor
        elsewhere = stand.chance("fan elsewhere", name)
        columns["airflow_mps"] = metered(rng, fan(elsewhere, followed.profile.duration).along(run.time))
    for change in planted:
        columns |= change.columns(rng, varies)
    rows = kept(rng, run.pwm, stand.lost)
    return Logged(name, followed, rows, {column: values[rows] for column, values in columns.items()})


def channels(stand: Bench, planted: Sequence[Change]) -> tuple[str, ...]:
    """Which channels the later runs have beside the temperatures: those of the bench, some more, and what is needed."""
    sometimes = [name for name in SOMETIMES if stand.chance("logged", name).random() < 0.5]
    needed = [name for change in planted for name in change.needs if name != "ambient_degC"]
    lacking = {name for change in planted for name in change.lacks}
    return tuple(dict.fromkeys(name for name in (*stand.channels, *sometimes, *needed) if name not in lacking))


def floor(stand: Bench, runs: Sequence[Logged]) -> float:
    """Root mean square of read minus what a perfect model says, in the runs' samples, K."""
    every = np.concatenate([run.error(stand).ravel() for run in runs])
    return float(np.sqrt(np.nanmean(every**2)))
