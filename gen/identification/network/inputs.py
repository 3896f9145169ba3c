"""What drives the network, run beside run: arrays of one length, and the distinct inputs among all bins.

PWM takes few values and bins few widths, so few matrix exponentials are needed: one for each distinct input.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.identification.network.bins import Binned, FloatArray, IntArray

MOST_LEVELS = 1500
"""Where more distinct inputs occur, speeds are rounded."""
ROOM_S = 3600.0
"""Distance of the points between which the unknown part of an unmeasured ambient is a straight line."""


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
    """

    width: FloatArray
    rest: FloatArray
    speed: FloatArray
    square: FloatArray

    @property
    def count(self) -> int:
        """How many."""
        return self.width.size


def held(pwm: FloatArray, full_scale: int) -> Levels:
    """Give the inputs of PWM that is held, shape (L,)."""
    speed = np.abs(np.asarray(pwm, dtype=np.float64)) / full_scale
    return Levels(np.ones_like(speed), (speed == 0.0).astype(np.float64), speed, speed**2)


@dataclass(frozen=True, eq=False)
class Inputs:
    """R runs of at most T bins; L distinct inputs.

    Attributes
    ----------
    runs
        Where they come from.
    level
        Which distinct input holds in each bin, shape (R, T); 0 behind a run's end.
    length
        Bins of each run, shape (R,).
    ambient
        Mean ambient over each bin, shape (R, T), degC.
    room
        The unknown part of the ambient: the mean over each bin of each of its hats, shape (R, T, B); B may be 0.
    levels
        The distinct inputs.
    target, share, weight
        Readings, where in the bin their time lies, and how much they count (1/K^2), shape (R, T, S).
    begin
        Temperatures that the nodes begin at, before any parameter, shape (R, S), degC.
    loose
        How far the inner temperatures may be from the sensed ones at the beginning, shape (R,), K.
    """

    runs: tuple[Binned, ...]
    level: IntArray
    length: IntArray
    ambient: FloatArray
    room: FloatArray
    levels: Levels
    target: FloatArray
    share: FloatArray
    weight: FloatArray
    begin: FloatArray
    loose: FloatArray


def inputs_of(runs: Sequence[Binned]) -> Inputs:
    """Put runs beside each other; the readings weigh nothing yet."""
    most = max(run.width.size for run in runs)
    count, sensors = len(runs), runs[0].reading.shape[1]
    level, distinct = _levels(runs)
    ambient = np.zeros((count, most))
    target, share = np.zeros((count, most, sensors)), np.full((count, most, sensors), 0.5)
    for r, run in enumerate(runs):
        k = run.width.size
        ambient[r, :k] = run.ambient
        ambient[r, k:] = run.ambient[-1]
        target[r, :k] = np.where(run.covered > 0, run.reading, 0.0)
        share[r, :k] = run.share
    starts = [_begin(run) for run in runs]
    return Inputs(
        runs=tuple(runs),
        level=level,
        length=np.array([run.width.size for run in runs]),
        ambient=ambient,
        room=_room(runs, most),
        levels=Levels(*(np.ascontiguousarray(column) for column in distinct.T)),
        target=target,
        share=share,
        weight=np.zeros_like(target),
        begin=np.array([start for start, _ in starts]),
        loose=np.array([loose for _, loose in starts]),
    )


def _levels(runs: Sequence[Binned]) -> tuple[IntArray, FloatArray]:
    """Number the distinct inputs; where there are too many, those that are alike share their mean."""
    table = np.concatenate([np.column_stack([run.width, run.rest, run.speed, run.square]) for run in runs])
    key = np.round(table, 6)
    for coarse in (1.0, 4.0, 16.0, 64.0):
        _, index = np.unique(key, axis=0, return_inverse=True)
        index = np.ravel(index)
        if index.max() < MOST_LEVELS:
            break
        steps = np.array([1e-6, 0.002, 0.004, 0.004]) * coarse
        key = np.round(np.column_stack([table[:, 0], table[:, 1:] / steps[1:]]))
        # A width has to stay as it is: only the inputs are rounded.
        key[:, 0] = np.round(table[:, 0], 6)
    number = np.bincount(index).astype(np.float64)
    distinct = np.column_stack([np.bincount(index, column) / number for column in table.T])
    most = max(run.width.size for run in runs)
    level = np.zeros((len(runs), most), dtype=np.int64)
    at = 0
    for r, run in enumerate(runs):
        level[r, : run.width.size] = index[at : at + run.width.size]
        at += run.width.size
    return level, distinct


def _begin(run: Binned) -> tuple[FloatArray, float]:
    """Temperatures that sensed nodes begin at, and how far those that nobody sees may be from them."""
    known = np.isfinite(run.begin)
    ambient = float(run.ambient[0])
    level = float(np.mean(run.begin[known])) if known.any() else ambient
    begin = np.where(known, run.begin, level)
    spread = float(np.max(np.abs(run.begin[known] - ambient))) if known.any() else 5.0
    return begin, 0.3 + 0.5 * spread


def _room(runs: Sequence[Binned], most: int) -> FloatArray:
    """Hats over time for runs whose ambient was not measured."""
    unknown = [run for run in runs if not run.ambient_known]
    if not unknown:
        return np.zeros((len(runs), most, 0))
    knots = max(2, 1 + int(np.ceil(max(run.duration for run in unknown) / ROOM_S)))
    knots = min(knots, 12)
    room = np.zeros((len(runs), most, knots))
    for r, run in enumerate(runs):
        if run.ambient_known:
            continue
        at = np.linspace(0.0, run.duration, knots)
        middle = 0.5 * (run.edges[1:] + run.edges[:-1])
        for b in range(knots):
            room[r, : middle.size, b] = np.interp(middle, at, np.eye(knots)[b])
    return room
