"""What drives the network, run beside run: arrays of one length, and the distinct inputs among all bins.

PWM takes few values and bins few widths, so few matrix exponentials are needed: one for each distinct input.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.identification.network.fitting.bins import Binned

MOST_LEVELS = 1500
"""Where more distinct inputs occur, speeds are rounded."""
ROOM_S = 3600.0
"""Distance of the points between which the unknown part of an unmeasured ambient is a straight line."""
MOST_HATS = 12
COLD_K = 2.5
"""A motor whose parts all read the ambient to within this began cold: sensors may be off by as much."""
STILL_K = 0.5
"""In a room that moves by more (standard deviation) parts lag behind it: then they are not as warm as the room."""
ALIKE = 0.5
"""Of what parts differ by at the start: how far a hidden node may be from them."""
START_K = 0.2
"""Standard deviation of a start about what is said of it, K."""
WARM_K = 10.0
"""Of the start of a node of which nothing is known, K."""
TURNS = 0.1
"""Share of what turns at most in any bin, from which a bin is one in which the motor turns: an input that is switched
on and off within seconds, as a heater's is, may rest for most of every bin."""


@dataclass(frozen=True, eq=False)
class Levels:
    """L distinct inputs, shape (L,) each.

    Attributes
    ----------
    width
        Length of the bin, s.
    rest
        Share of time at PWM 0.
    speed, square
        |PWM| over full scale while it turns, and its square.
    further
        What else drives the motor, shape (L, E).
    """

    width: FloatArray
    rest: FloatArray
    speed: FloatArray
    square: FloatArray
    further: FloatArray

    @property
    def count(self) -> int:
        """How many."""
        return self.width.size

    @property
    def turns(self) -> BoolArray:
        """Whether they count as speeds, shape (L,); the others are rest. None does where the motor never turned."""
        share = 1.0 - self.rest
        return np.asarray(share > TURNS * share.max(initial=0.0))


def held(pwm: FloatArray, full_scale: int) -> Levels:
    """Give the inputs of PWM that is held, shape (L,)."""
    speed = np.abs(np.asarray(pwm, dtype=np.float64)) / full_scale
    return Levels(np.ones_like(speed), (speed == 0.0).astype(np.float64), speed, speed**2, np.empty((speed.size, 0)))


def turning(pwm: FloatArray, full_scale: int) -> Levels:
    """Give the inputs of a motor that turns, the slowest turning at PWM 0 included, shape (L,)."""
    speed = np.abs(np.asarray(pwm, dtype=np.float64)) / full_scale
    return Levels(np.ones_like(speed), np.zeros_like(speed), speed, speed**2, np.empty((speed.size, 0)))


def joined(first: Levels, second: Levels) -> Levels:
    """Give the inputs of both, one after the other."""
    pairs = (
        (first.width, second.width),
        (first.rest, second.rest),
        (first.speed, second.speed),
        (first.square, second.square),
        (first.further, second.further),
    )
    return Levels(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True, eq=False)
class Inputs:
    """All bins of all runs in one row: the first bin of each run, then the second of each, and so on.

    N bins, R runs, S sensed nodes. The longest run comes first, so those that still go on stand together.

    Attributes
    ----------
    runs
        Where they come from.
    order
        The runs, longest first, shape (R,).
    first
        Where each step begins, shape (T + 1,): at step k the first ``first[k + 1] - first[k]`` runs of the order go on.
    run, level
        Of each bin: the run that it belongs to, and which distinct input holds, shape (N,).
    begins
        When it begins, shape (N,), s.
    levels
        The distinct inputs.
    ambient
        Mean ambient over it, shape (N,), degC.
    room
        The unknown part of the ambient: mean over the bin of each of its hats, shape (N, B); B may be 0.
    target, share, weight
        Readings, where in the bin their time lies, and how much they count (1/K^2), shape (N, S).
    covered
        The time that they stand for, shape (N, S), s.
    begin
        Temperatures that the nodes begin at, before any parameter, shape (R, S + 1), degC; the last is a hidden one's.
    loose
        How far sensed nodes, and hidden ones, may be from that, shape (R, 2), K.
    warm
        By how much parts differ from each other or from the ambient at the start of a run that does not begin cold, and
        whose start was read, shape (R,), K; 0 for others.
    """

    runs: tuple[Binned, ...]
    order: IntArray
    first: IntArray
    run: IntArray
    level: IntArray
    begins: FloatArray
    levels: Levels
    ambient: FloatArray
    room: FloatArray
    target: FloatArray
    share: FloatArray
    weight: FloatArray
    covered: FloatArray
    begin: FloatArray
    loose: FloatArray
    warm: FloatArray

    @cached_property
    def rows(self) -> tuple[IntArray, ...]:
        """The bins of each run, in time."""
        return tuple(np.flatnonzero(self.run == r) for r in range(len(self.runs)))

    @property
    def width(self) -> FloatArray:
        """Length of each bin, shape (N,), s."""
        return self.levels.width[self.level]

    @property
    def rest(self) -> FloatArray:
        """Share of each bin at PWM 0, shape (N,)."""
        return self.levels.rest[self.level]

    @property
    def turns(self) -> BoolArray:
        """Whether the motor turns in each bin, shape (N,)."""
        return self.levels.turns[self.level]

    @property
    def speed(self) -> FloatArray:
        """Mean |PWM| over full scale while it turns, shape (N,)."""
        return self.levels.speed[self.level]


def inputs_of(runs: Sequence[Binned]) -> Inputs:
    """Put all runs in one row; the readings weigh nothing yet."""
    lengths = np.array([run.width.size for run in runs])
    order = np.argsort(-lengths, kind="stable")
    step = np.concatenate([np.arange(lengths[r]) for r in order])
    # By step, and within it in the order of the runs.
    row = np.argsort(step, kind="stable")
    run = np.repeat(order, lengths[order])[row]

    def flat(values: Callable[[Binned], FloatArray]) -> FloatArray:
        return np.ascontiguousarray(np.concatenate([values(runs[r]) for r in order])[row])

    level, distinct = _levels(flat(lambda r: np.column_stack([r.width, r.rest, r.speed, r.square, r.further])))
    covered = flat(lambda r: r.covered)
    starts = [_begin(own) for own in runs]
    hats = _hats(runs)
    return Inputs(
        runs=tuple(runs),
        order=order,
        first=np.concatenate([[0], np.cumsum(np.bincount(step))]),
        run=run,
        level=level,
        begins=flat(lambda r: r.edges[:-1]),
        levels=_as_levels(distinct),
        ambient=flat(lambda r: r.ambient),
        room=flat(lambda r: _room(r, hats)),
        target=np.where(covered > 0.0, flat(lambda r: r.reading), 0.0),
        share=flat(lambda r: r.share),
        weight=np.zeros_like(covered),
        covered=covered,
        begin=np.array([start.degC for start in starts]),
        loose=np.array([start.loose_K for start in starts]),
        warm=np.array([start.warm_K for start in starts]),
    )


def _as_levels(table: FloatArray) -> Levels:
    width, rest, speed, square = np.ascontiguousarray(table[:, :4].T)
    return Levels(width, rest, speed, square, table[:, 4:])


def _levels(table: FloatArray) -> tuple[IntArray, FloatArray]:
    """Number the distinct inputs; where there are too many, those that are alike share their mean.

    Parameters
    ----------
    table
        Width, rest, speed and square of each bin, and what else drives the motor, shape (N, 4 + E).
    """
    key = np.round(table, 6)
    if table.shape[1] > 4:
        # Each bin has channels of its own: rounding would not make them fewer.
        distinct, index = np.unique(key, axis=0, return_inverse=True)
        return np.ravel(index), distinct
    index = np.ravel(np.unique(key, axis=0, return_inverse=True)[1])
    for coarse in (1.0, 4.0, 16.0, 64.0):
        if index.max() < MOST_LEVELS:
            break
        # A width has to stay as it is: only the inputs are rounded.
        steps = np.array([0.002, 0.004, 0.004]) * coarse
        key = np.column_stack([np.round(table[:, 0], 6), np.round(table[:, 1:] / steps)])
        index = np.ravel(np.unique(key, axis=0, return_inverse=True)[1])
    number = np.bincount(index).astype(np.float64)
    return index, np.column_stack([np.bincount(index, column) / number for column in table.T])


class _Begin(NamedTuple):
    """Temperatures that the sensed nodes begin at, then a hidden one, and how far both kinds may be from that."""

    degC: FloatArray
    loose_K: tuple[float, float]
    warm_K: float = 0.0


def _begin(run: Binned) -> _Begin:
    """Say where a run begins."""
    known = np.isfinite(run.begin)
    ambient = float(run.ambient[0])
    if not known.any():
        return _Begin(np.full(known.size + 1, ambient), (WARM_K, WARM_K))
    spread = float(np.max(np.abs(run.begin[known] - ambient)))
    moves = float(np.std(run.ambient))
    if spread < COLD_K and moves < STILL_K:
        # It has stood for long: all parts are as warm as the room, and what sensors read beside that is their offset.
        within = START_K if run.ambient_known else 2.0 * START_K
        return _Begin(np.full(known.size + 1, ambient), (within, within))
    level = float(np.mean(run.begin[known]))
    begin = np.append(np.where(known, run.begin, level), level)
    loose = (2.0 * START_K if known.all() else WARM_K, START_K + ALIKE * (spread + moves))
    return _Begin(begin, loose, spread + moves)


def _hats(runs: Sequence[Binned]) -> int:
    """How many hats the longest run without a measured ambient needs."""
    unknown = [run.duration for run in runs if not run.ambient_known]
    return min(max(2, 1 + int(np.ceil(max(unknown) / ROOM_S))), MOST_HATS) if unknown else 0


def _room(run: Binned, hats: int) -> FloatArray:
    """Hats over the run's time where its ambient was not measured, else nothing, shape (K, hats)."""
    if run.ambient_known or not hats:
        return np.zeros((run.width.size, hats))
    at = np.linspace(0.0, run.duration, hats)
    middle = 0.5 * (run.edges[1:] + run.edges[:-1])
    return np.column_stack([np.interp(middle, at, own) for own in np.eye(hats)])
