"""The room around a motor: held, moving, or drifting where nobody measures it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class RoomKind(StrEnum):
    """What the room does, and whether it is measured."""

    HELD = "held"
    MOVING = "moving"
    UNMEASURED = "unmeasured"


SWING_K, JUMP_K = 5.0, 4.0
"""From the lowest to the highest of a moving room's swing, and its jumps."""
OFFSET_K, DRIFT_K = 0.5, 0.5
"""How far a room that nobody measures lies from its mean in a run, and how far it swings in it, at most."""


@dataclass(frozen=True)
class Room:
    """Temperature over a run: a swing about a mean, and jumps.

    Parameters
    ----------
    mean, swing
        degC, and from the lowest to the highest of the swing, K.
    period, phase
        Of the swing, s and rad.
    jumps
        Times in s and what the room changes by at each, K.
    measured
        Whether the run file has it.
    """

    mean: float
    swing: float = 0.0
    period: float = 7200.0
    phase: float = 0.0
    jumps: tuple[tuple[float, float], ...] = ()
    measured: bool = True

    def at(self, time: FloatArray) -> FloatArray:
        """Temperature at times in s, degC; at a jump it has jumped."""
        value = self.mean + 0.5 * self.swing * np.sin(2.0 * np.pi * time / self.period + self.phase)
        for when, size in self.jumps:
            value = value + size * (time >= when)
        return np.asarray(value, dtype=np.float64)


def random_room(rng: np.random.Generator, kind: RoomKind, usual: float, duration: float, lead: float) -> Room:
    """Draw the room of one run.

    Parameters
    ----------
    rng
        Where chance comes from.
    kind
        What it does.
    usual
        Its usual temperature, degC.
    duration, lead
        Of the run and of the time before it, s.
    """
    if kind is RoomKind.HELD:
        return Room(usual)
    phase = float(rng.uniform(0.0, 2.0 * np.pi))
    if kind is RoomKind.UNMEASURED:
        mean = usual + float(rng.uniform(-OFFSET_K, OFFSET_K))
        period = float(rng.uniform(6.0, 12.0)) * 3600.0
        return Room(mean, 2.0 * float(rng.uniform(0.0, DRIFT_K)), period, phase, measured=False)
    period = float(rng.uniform(1.0, 5.0)) * 3600.0
    return Room(usual, SWING_K, period, phase, _jumps(rng, duration, lead))


def _jumps(rng: np.random.Generator, duration: float, lead: float) -> tuple[tuple[float, float], ...]:
    """A door that is opened and shut in turn, every half to two hours."""
    when, size = -lead, JUMP_K * float(rng.choice([-1.0, 1.0]))
    found: list[tuple[float, float]] = []
    while True:
        when += float(rng.uniform(0.5, 2.0)) * 3600.0
        if when >= duration:
            return tuple(found)
        found.append((when, size if len(found) % 2 == 0 else -size))
