"""A motor's true temperatures along a profile in a room."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.plants.plant import FollowedRates
from benchmarks.plants.profiles import Profile
from benchmarks.plants.rooms import Room

FloatArray = NDArray[np.float64]
LEAD_S = 10800.0
"""For how long a motor stood in its room before anything was done with it: it lags a room that moves."""
RELATIVE, ABSOLUTE_K = 1e-6, 1e-5
"""Tolerances of the integration: far below a sensor's step."""


class Motor(Protocol):
    """What can be followed: a plant, or one of which something has been changed."""

    @property
    def changes(self) -> Sequence[float]:
        """Times at which something of it jumps beside PWM, s."""

    @property
    def longest_s(self) -> float:
        """Step of the integration that may be too long to see something that happens within it, s."""

    def rest(self, ambient: float) -> FloatArray:
        """State after a long rest in a room of this temperature (degC); temperatures of the nodes first."""

    def rates(self, pwm: int, begin: float) -> FollowedRates:
        """How its state changes at a PWM, from a time in s to the next change."""


@dataclass(frozen=True, eq=False)
class Course:
    """What happened.

    Attributes
    ----------
    time
        s, from 0, shape (N,).
    pwm
        Counts, held until the next row, shape (N,).
    temperature
        Of all nodes before that PWM has acted, degC, shape (N, nodes); whatever else a motor's state has comes after
        them.
    ambient
        Of the room, degC, shape (N,).
    """

    time: FloatArray
    pwm: NDArray[np.int64]
    temperature: FloatArray
    ambient: FloatArray


def course(motor: Motor, profile: Profile, room: Room, row_s: float, start: FloatArray | None = None) -> Course:
    """Follow a motor from rest in its room.

    Parameters
    ----------
    motor, profile, room
        What is run, how, and where. The room's time is that of the run: what came before is at negative times.
    row_s
        From row to row, s; holds last multiples of it.
    start
        State at the run's first row, whatever came before; by itself what came before tells it.
    """
    state = begun(motor, profile, room) if start is None else start
    rows = round(profile.duration / row_s)
    time = np.arange(rows + 1, dtype=np.float64) * row_s
    edges = np.cumsum([seconds for _, seconds in profile.holds])
    levels = np.array([pwm for pwm, _ in profile.holds], dtype=np.int64)
    pwm = levels[np.minimum(np.searchsorted(edges, time, side="right"), levels.size - 1)]
    return Course(time, pwm, _follow(motor, profile.holds, room, 0.0, state, time), room.at(time))


def begun(motor: Motor, profile: Profile, room: Room) -> FloatArray:
    """State at a run's first row: after a long rest in the room, and what was done right before the run."""
    begin = -LEAD_S - sum(seconds for _, seconds in profile.before)
    state = motor.rest(float(room.at(np.array([begin]))[0]))
    return np.asarray(_follow(motor, ((0, LEAD_S), *profile.before), room, begin, state, None)[-1])


def _follow(
    motor: Motor,
    holds: tuple[tuple[int, float], ...],
    room: Room,
    begin: float,
    state: FloatArray,
    rows: FloatArray | None,
) -> FloatArray:
    """Temperatures at the rows, or only at the end, shape (rows, nodes)."""
    found = [state[None, :]] if rows is None else []
    for pwm, seconds in holds:
        end = begin + seconds
        jumps = {*motor.changes, *(when for when, _ in room.jumps)}
        cuts = [begin, *sorted(when for when in jumps if begin < when < end), end]
        for first, last in pairwise(cuts):
            inside = rows[(rows >= first) & (rows < last)] if rows is not None else np.empty(0)
            solved = solve_ivp(
                _rates(motor.rates(pwm, first), _smooth(room, first)),
                (first, last),
                state,
                method="LSODA",
                t_eval=np.append(inside, last),
                rtol=RELATIVE,
                atol=ABSOLUTE_K,
                max_step=motor.longest_s,
            )
            if not solved.success:
                raise RuntimeError(f"the integration failed at {solved.t[-1]:.0f} s: {solved.message}")
            state = solved.y[:, -1]
            if rows is not None:
                found.append(solved.y[:, :-1].T)
        begin = end
    return np.concatenate([*found, state[None, :]])


def _rates(rates: FollowedRates, ambient: Callable[[float], float]) -> Callable[[float, FloatArray], FloatArray]:
    """How fast the state changes, by time and state."""
    return lambda time, state: rates(state, ambient(time))


def _smooth(room: Room, begin: float) -> Callable[[float], float]:
    """The room's temperature from one jump to the next."""
    level = room.mean + sum(size for when, size in room.jumps if when <= begin)
    half, rate = 0.5 * room.swing, 2.0 * math.pi / room.period
    return lambda t: level + half * math.sin(rate * t + room.phase)
