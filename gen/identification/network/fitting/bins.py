"""Runs condensed for the fit: means of the readings over bins of 5 to 30 s, and what drove the motor in each.

A bin begins wherever PWM changes and is short after a change, so that PWM is constant within it. Where PWM changes
more often than every few seconds (ramps, chopping) a bin holds the mean of what occurs in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.identification.logs.records import quantiser_bias, resolution, scatter
from gen.runs import Run

SHORTEST_S, LONGEST_S = 5.0, 30.0
"""Widths of the bins: short after a change of PWM, then growing."""
GROWTH = 0.15
"""Largest bin, as a share of the time since PWM changed."""
MOST_BINS = 12_000
"""Of all runs together; more are made longer."""
WINDOW_S = 60.0
"""The start is the mean of the readings over this time, or where the line through them begins."""
BENT, FEWEST = 3.0, 5
"""Standard deviations from which readings are no straight line, and how many it takes; fewer say what the first of them
says."""


@dataclass(frozen=True, eq=False)
class Binned:
    """One run over K bins; S sensed nodes.

    Attributes
    ----------
    name
        The run's.
    edges
        Ends of the bins, shape (K + 1,), s since the first row.
    rest
        Share of time at PWM 0, shape (K,).
    speed
        Mean |PWM| while it turns over full scale, shape (K,).
    square
        Mean square of the same, shape (K,).
    ambient
        Mean ambient, shape (K,), degC.
    reading
        Mean of each sensor's readings, shape (K, S), degC; NaN where there is none.
    share
        Where in the bin the mean of their times lies, 0..1, shape (K, S).
    covered
        Time that the readings stand for, shape (K, S), s; 0 where there is none.
    begin
        Where each sensor begins, shape (S,), degC; NaN for a node that this run does not measure.
    first
        The first reading of each, scatter and all, shape (S,), degC: whoever uses a file starts from that.
    noise_K
        Standard deviation of a single reading, shape (S,), K.
    sample_s
        Distance of the readings, shape (S,), s.
    ambient_known
        Whether the ambient was measured.
    further
        Means of whatever else drives the motor, shape (K, E); E may be 0.
    room_K
        Where nothing says the ambient: what all such runs may be off by together, standard deviation, K; else 0.
    cold
        Whether nothing says the ambient, and the run is known to begin as warm as its room.
    """

    name: str
    edges: FloatArray
    rest: FloatArray
    speed: FloatArray
    square: FloatArray
    ambient: FloatArray
    reading: FloatArray
    share: FloatArray
    covered: FloatArray
    begin: FloatArray
    first: FloatArray
    noise_K: FloatArray
    sample_s: FloatArray
    ambient_known: bool
    further: FloatArray
    room_K: float = 0.0
    cold: bool = False

    @property
    def width(self) -> FloatArray:
        """Length of each bin, shape (K,), s."""
        return np.asarray(np.diff(self.edges))

    @property
    def duration(self) -> float:
        """Of the run, s."""
        return float(self.edges[-1])


def binned(
    name: str,
    run: Run,
    names: Sequence[str],
    ambient: FloatArray | float,
    full_scale: int,
    longest: float = LONGEST_S,
    further: Sequence[FloatArray] = (),
    room_K: float = 0.0,
    cold: bool = False,
) -> Binned:
    """Condense one run.

    Parameters
    ----------
    name
        The run's.
    run
        Its rows.
    names
        The sensed nodes.
    ambient
        At each row, or one for all, degC.
    full_scale
        The count that is 100 %.
    longest
        Longest bin, s.
    further
        What else drives the motor, at each row.
    room_K
        What the ambient may be off by where nothing says it, standard deviation, K.
    cold
        Whether the run is known to begin as warm as a room that nothing says.
    """
    time = run.time_s - run.time_s[0]
    level = np.abs(run.pwm).astype(np.float64)
    edges = _edges(time, level, longest)
    around = np.broadcast_to(np.asarray(ambient, dtype=np.float64), time.shape)
    turning = level > 0.0
    share = _means(edges, time, turning.astype(np.float64))
    driven = np.maximum(share, 1e-12)
    speed = np.where(share > 0.0, _means(edges, time, level) / driven, 0.0) / full_scale
    square = np.where(share > 0.0, _means(edges, time, level**2) / driven, 0.0) / full_scale**2
    columns = [_readings(edges, time, run.temps.get(n)) for n in names]
    return Binned(
        name=name,
        edges=edges,
        rest=np.clip(1.0 - share, 0.0, 1.0),
        speed=speed,
        square=square,
        ambient=_means(edges, time, around),
        reading=np.column_stack([c[0] for c in columns]),
        share=np.column_stack([c[1] for c in columns]),
        covered=np.column_stack([c[2] for c in columns]),
        begin=np.array([_begin(time, run.temps.get(n)) for n in names]),
        first=np.array([_first(run.temps.get(n)) for n in names]),
        noise_K=np.array([_noise(run.temps.get(n)) for n in names]),
        sample_s=np.array([_distance(time, run.temps.get(n)) for n in names]),
        ambient_known=not isinstance(ambient, float),
        further=np.array([_means(edges, time, values) for values in further]).reshape(len(further), edges.size - 1).T,
        room_K=room_K,
        cold=cold,
    )


def longest_bin(runs: Sequence[Run]) -> float:
    """Give the longest bin with which all runs together keep to `MOST_BINS`, s."""
    total = sum(float(run.time_s[-1] - run.time_s[0]) for run in runs)
    return max(LONGEST_S, 1.5 * total / MOST_BINS)


def _edges(time: FloatArray, level: FloatArray, longest: float) -> FloatArray:
    """Ends of the bins; each is at least as long as the distance of the rows."""
    end = float(time[-1])
    row = float(np.median(np.diff(time)))
    shortest = max(SHORTEST_S * longest / LONGEST_S, row)
    longest = max(longest, shortest)
    changes = time[np.flatnonzero(np.diff(level)) + 1]
    kept = [0.0]
    for at in changes.tolist():
        if at - kept[-1] >= shortest and end - at >= 0.5 * shortest:
            kept.append(at)
    edges: list[float] = []
    for start, stop in zip(kept, [*kept[1:], end], strict=True):
        edges.append(start)
        at, width = start, shortest
        while stop - at >= 1.5 * width:
            at += width
            edges.append(at)
            while 2.0 * width <= longest and GROWTH * (at - start) >= 2.0 * width:
                width *= 2.0
            if 2.0 * width > longest and GROWTH * (at - start) >= longest:
                width = longest
    edges.append(end)
    return np.array(edges)


def _means(edges: FloatArray, time: FloatArray, values: FloatArray) -> FloatArray:
    """Mean over each bin of what is held from row to row, shape (K,)."""
    total = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(time))])
    at = np.interp(edges, time, total)
    return np.asarray(np.diff(at) / np.diff(edges))


def _readings(
    edges: FloatArray, time: FloatArray, values: FloatArray | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean reading, its place in the bin and the time covered, shape (K,) each."""
    count = edges.size - 1
    if values is None:
        return np.full(count, np.nan), np.full(count, 0.5), np.zeros(count)
    good = np.isfinite(values)
    at, value = time[good], values[good]
    owner = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, count - 1)
    number = np.bincount(owner, minlength=count).astype(np.float64)
    some = np.maximum(number, 1.0)
    width = np.diff(edges)
    mean = np.where(number > 0, np.bincount(owner, value, count) / some, np.nan)
    place = (np.bincount(owner, at - edges[owner], count) / some) / width
    covered = np.minimum(number * _distance(time, values), width)
    return mean, np.where(number > 0, place, 0.5), covered


def _distance(time: FloatArray, values: FloatArray | None) -> float:
    good = np.isfinite(values) if values is not None else np.zeros(time.size, dtype=bool)
    return float(np.median(np.diff(time[good]))) if np.count_nonzero(good) > 1 else float(np.median(np.diff(time)))


def _first(values: FloatArray | None) -> float:
    known = np.zeros(0) if values is None else values[np.isfinite(values)]
    return float(known[0]) if known.size else float("nan")


def _begin(time: FloatArray, values: FloatArray | None) -> float:
    """Give where a sensor begins: by its first minute, or by as much of it as is a straight line, degC."""
    if values is None or not np.isfinite(values).any():
        return float("nan")
    good = np.flatnonzero(np.isfinite(values))
    early = good[time[good] <= time[good[0]] + WINDOW_S]
    noise = _noise(values)
    while early.size >= FEWEST:
        at, value = time[early] - time[good[0]], values[early]
        slope, level = np.polyfit(at, value, 1)
        if _straight(at, value, noise):
            # A part may warm from the first second on.
            ramp = abs(slope) * at[-1] > 2.0 * float(np.std(value))
            return float(level) if ramp else float(np.mean(value))
        early = early[: early.size // 2]
    return float(values[good[0]])


def _straight(at: FloatArray, value: FloatArray, noise: float) -> bool:
    """Whether readings lie about a straight line: what a square of time adds is within what noise does to it."""
    square = at**2 - np.polyval(np.polyfit(at, at**2, 1), at)
    length = float(square @ square)
    return abs(float(square @ value)) <= BENT * noise * float(np.sqrt(length))


def _noise(values: FloatArray | None) -> float:
    """Scatter of a reading and what the quantiser leaves, standard deviation, K."""
    if values is None:
        return 0.1
    value = values[np.isfinite(values)]
    noise, step = scatter(value), resolution(value)
    return float(max(np.hypot(noise, quantiser_bias(noise, step)), 0.02))
