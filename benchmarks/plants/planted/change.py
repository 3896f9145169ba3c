"""What a change of a bench can do: to the motor, while it runs, to its surroundings, to what is read and logged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.plant import FULL_PWM, Plant, Running
from benchmarks.plants.profiles import Profile
from benchmarks.plants.rooms import Room

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Steps:
    """A quantity that jumps from value to value.

    Parameters
    ----------
    before
        Its value before the run.
    times, values
        From when on in s, ascending, and what it is from then on.
    """

    before: float
    times: tuple[float, ...] = ()
    values: tuple[float, ...] = ()

    def at(self, time: float) -> float:
        """Its value at a time in s."""
        index = int(np.searchsorted(self.times, time, side="right"))
        return self.values[index - 1] if index else self.before

    def along(self, time: FloatArray) -> FloatArray:
        """Its values at many times."""
        return np.array([self.before, *self.values])[np.searchsorted(self.times, time, side="right")]


@dataclass(frozen=True)
class Now:
    """What holds until the next jump.

    Parameters
    ----------
    pwm
        Counts.
    time
        Since when, s from the run's first row.
    signals
        What varies in this run, by name.
    """

    pwm: int
    time: float
    signals: Mapping[str, float]

    @property
    def duty(self) -> float:
        """Share of full PWM."""
        return abs(self.pwm) / FULL_PWM


class Acting(NamedTuple):
    """What a change adds at some temperatures.

    Parameters
    ----------
    heat, capacity
        To each node, W and J/K.
    own
        Rates of the change's own states, 1/s.
    """

    heat: FloatArray | float = 0.0
    capacity: FloatArray | float = 0.0
    own: FloatArray | float = 0.0


Act = Callable[[FloatArray, FloatArray, float], Acting]
"""By the nodes' temperatures, the change's own states, and the room's temperature."""


@dataclass(frozen=True)
class Change:
    """What is otherwise in the later runs; this one changes nothing.

    Attributes
    ----------
    states
        How many states of its own it has.
    longest_s
        Step of the integration in s, in which something of it may come and go unseen if it is longer.
    needs, lacks
        Channels that the later runs log for it, and that they do not log.
    else_held
        Whether the room is held without it, and nobody measured it while the motor was identified.
    """

    states: ClassVar[int] = 0
    longest_s: ClassVar[float] = 900.0
    needs: ClassVar[tuple[str, ...]] = ()
    lacks: ClassVar[tuple[str, ...]] = ()
    else_held: ClassVar[bool] = False

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:
        """What varies in a later run, which is the `number`-th of them and lasts `duration` s."""
        return {}

    def plant(self, plant: Plant) -> Plant:
        """The motor, in all later runs."""
        return plant

    def under(self, plant: Plant, now: Now) -> Plant:
        """The motor, from now to the next jump."""
        return plant

    def act(self, plant: Plant, running: Running, now: Now) -> Act | None:
        """What else happens from now to the next jump."""
        return None

    def begin(self, ambient: float) -> tuple[float, ...]:
        """Its own states after a long rest in a room."""
        return ()

    def profile(self, rng: np.random.Generator, profile: Profile) -> Profile:
        """What is done with the motor."""
        return profile

    def room(self, rng: np.random.Generator, room: Room, duration: float) -> Room:
        """What the room does."""
        return room

    def seen(self, node: int, true: FloatArray, time: FloatArray, ambient: FloatArray) -> FloatArray:
        """What the sensor of a node is at, degC; rows are evenly spaced."""
        return true

    def room_seen(self, ambient: FloatArray, temperature: FloatArray, time: FloatArray) -> FloatArray:
        """What the room's thermometer is at, degC, where the nodes have temperatures of shape (N, nodes)."""
        return ambient

    def columns(self, rng: np.random.Generator, signals: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """What is logged beside what every logger has, by what varies at each row."""
        return {}


def jumps(
    rng: np.random.Generator, duration: float, minutes: tuple[float, float], draw: Callable[[], float], before: float
) -> Steps:
    """Values drawn anew after some minutes each, from a run's first row on."""
    times, values, time = [], [], 0.0
    while time < duration:
        times.append(time)
        values.append(draw())
        time += round(60.0 * float(rng.uniform(*minutes)))
    return Steps(before, tuple(times), tuple(values))
