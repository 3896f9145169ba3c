"""Changes of where a motor stands and of what was done with it before: its room, and heat that is left inside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.plant import Plant, Running
from benchmarks.plants.planted.change import Act, Acting, Change, Now
from benchmarks.plants.profiles import Profile
from benchmarks.plants.rooms import Room

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class InitialState(Change):
    """The runs begin after others: outside the motor has cooled, inside it has not.

    Parameters
    ----------
    ran
        For how long it ran before, at the most, s.
    """

    ran: float

    def profile(self, rng: np.random.Generator, profile: Profile) -> Profile:  # noqa: D102
        level, rested = int(rng.integers(140, 256)), 60.0 * float(rng.uniform(0.5, 5.0))
        return replace(profile, before=((level, self.ran * float(rng.uniform(0.5, 1.0))), (0, rested)))


@dataclass(frozen=True)
class Ambient(Change):
    """The room moves, which was held while the motor was identified; its thermometer is new.

    Parameters
    ----------
    swing
        From the lowest to the highest, K; a door that is opened and shut adds half of it.
    walls, lag
        The share of what the motor gives off that goes to walls, and with what time constant these follow the room, s.
    """

    needs: ClassVar[tuple[str, ...]] = ("ambient_degC",)
    states: ClassVar[int] = 1
    else_held: ClassVar[bool] = True
    swing: float
    walls: float
    lag: float

    def room(self, rng: np.random.Generator, room: Room, duration: float) -> Room:  # noqa: D102
        when, size = float(rng.uniform(0.5, 1.5)) * 3600.0, 0.5 * self.swing * float(rng.choice([-1.0, 1.0]))
        doors = []
        while when < duration:
            doors.append((when, size))
            when, size = when + float(rng.uniform(0.5, 2.0)) * 3600.0, -size
        period, phase = float(rng.uniform(2.0, 6.0)) * 3600.0, float(rng.uniform(0.0, 2.0 * np.pi))
        return Room(room.mean, self.swing, period, phase, tuple(doors))

    def begin(self, ambient: float) -> tuple[float, ...]:  # noqa: D102
        return (ambient,)

    def act(self, plant: Plant, running: Running, now: Now) -> Act | None:  # noqa: D102
        def act(temperature: FloatArray, own: FloatArray, ambient: float) -> Acting:
            return Acting(self.walls * running.outlet * (own[0] - ambient), own=(ambient - own) / self.lag)

        return act
