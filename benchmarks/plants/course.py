"""A motor's true temperatures along a profile in a room."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchmarks.plants.plant import Plant, Running
from benchmarks.plants.profiles import Profile
from benchmarks.plants.rooms import Room

FloatArray = NDArray[np.float64]
LEAD_S = 10800.0
"""For how long a motor stood in its room before anything was done with it: it lags a room that moves."""
RELATIVE, ABSOLUTE_K = 1e-6, 1e-5
"""Tolerances of the integration: far below a sensor's step."""


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
        Of all nodes before that PWM has acted, degC, shape (N, nodes).
    ambient
        Of the room, degC, shape (N,).
    """

    time: FloatArray
    pwm: NDArray[np.int64]
    temperature: FloatArray
    ambient: FloatArray


def course(plant: Plant, profile: Profile, room: Room, row_s: float) -> Course:
    """Follow a motor from rest in its room.

    Parameters
    ----------
    plant, profile, room
        What is run, how, and where. The room's time is that of the run: what came before is at negative times.
    row_s
        From row to row, s; holds last multiples of it.
    """
    before = sum(seconds for _, seconds in profile.before)
    state = np.full(plant.size, float(room.at(np.array([-before - LEAD_S]))[0]))
    state = _follow(plant, ((0, LEAD_S), *profile.before), room, -before - LEAD_S, state, None)[-1]
    rows = round(profile.duration / row_s)
    time = np.arange(rows + 1, dtype=np.float64) * row_s
    edges = np.cumsum([seconds for _, seconds in profile.holds])
    levels = np.array([pwm for pwm, _ in profile.holds], dtype=np.int64)
    pwm = levels[np.minimum(np.searchsorted(edges, time, side="right"), levels.size - 1)]
    return Course(time, pwm, _follow(plant, profile.holds, room, 0.0, state, time), room.at(time))


def _follow(
    plant: Plant,
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
        running = plant.at(pwm)
        cuts = [begin, *(when for when, _ in room.jumps if begin < when < end), end]
        for first, last in pairwise(cuts):
            inside = rows[(rows >= first) & (rows < last)] if rows is not None else np.empty(0)
            solved = solve_ivp(
                _rates(running, _smooth(room, first)),
                (first, last),
                state,
                method="LSODA",
                t_eval=np.append(inside, last),
                rtol=RELATIVE,
                atol=ABSOLUTE_K,
                max_step=900.0,
            )
            if not solved.success:
                raise RuntimeError(f"the integration failed at {solved.t[-1]:.0f} s: {solved.message}")
            state = solved.y[:, -1]
            if rows is not None:
                found.append(solved.y[:, :-1].T)
        begin = end
    return np.concatenate([*found, state[None, :]])


def _rates(running: Running, ambient: Callable[[float], float]) -> Callable[[float, FloatArray], FloatArray]:
    """How fast the temperatures change, by time and temperatures, K/s."""
    return lambda time, temperature: running.rates(temperature, ambient(time))


def _smooth(room: Room, begin: float) -> Callable[[float], float]:
    """The room's temperature from one jump to the next."""
    level = room.mean + sum(size for when, size in room.jumps if when <= begin)
    half, rate = 0.5 * room.swing, 2.0 * math.pi / room.period
    return lambda t: level + half * math.sin(rate * t + room.phase)
