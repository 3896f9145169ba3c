"""Runs condensed for fitting: segments of held PWM, and block means of the rise.

Thermal signals are slow, so neighbouring samples are averaged. A block spans at most a share of the time since PWM
last changed, and at most a share of the run; the mean of a block then differs from the value at its middle by
T'' d^2 / 24 < 3e-5 of the step's height. Nothing is averaged across a change of PWM.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.logs.room import Pieces, pieces_of

GROWTH = 0.03
"""Largest block, as a share of the time since PWM changed."""
FINEST = 1.0 / 180.0
"""Largest block, as a share of the run."""
MOST_SEGMENTS = 400
"""A run with more changes of PWM is averaged over windows, half as many as this (see `response.mixed_poles`)."""


@dataclass(frozen=True)
class Segments:
    """Held PWM of one run.

    Attributes
    ----------
    start
        Beginning of each segment since the run's first row, shape (S,), s.
    length
        Shape (S,), s.
    pwm
        |PWM| of a segment where it is held, -1 where it is mixed, shape (S,).
    mixed
        For each mixed segment its |PWM| values with their share of time.
    """

    start: FloatArray
    length: FloatArray
    pwm: IntArray
    mixed: dict[int, dict[int, float]] = field(default_factory=dict)

    def dwell(self) -> dict[int, float]:
        """Total time by |PWM| of held segments, s."""
        total: dict[int, float] = {}
        for level, length in zip(self.pwm.tolist(), self.length.tolist(), strict=True):
            if level >= 0:
                total[level] = total.get(level, 0.0) + length
        return total


@dataclass(frozen=True, eq=False)
class Record:
    """One component in one run, condensed.

    Attributes
    ----------
    run
        The run's name.
    segments
        From the component's first sample on.
    time
        Middle of each block since the first sample, shape (m,), s, increasing.
    rise
        Mean rise over ambient in the block, shape (m,), K.
    count
        Samples in the block, shape (m,).
    over
        Mean ambient in the block less that of the first piece, shape (m,), K.
    segment
        The segment that each block lies in, shape (m,).
    pieces
        The segments, cut where the ambient moves.
    sample_s
        Median distance of the samples, s.
    noise_K
        Scatter of a single sample about its neighbours, standard deviation, K; without that of the ambient.
    quantum_K
        The sensor's resolution as seen in the data, K; 0 where none is visible.
    raw_time, raw_rise, raw_over, raw_segment
        The samples themselves.
    """

    run: str
    segments: Segments
    time: FloatArray
    rise: FloatArray
    over: FloatArray
    count: FloatArray
    segment: IntArray
    pieces: Pieces
    sample_s: float
    noise_K: float
    quantum_K: float
    raw_time: FloatArray
    raw_rise: FloatArray
    raw_over: FloatArray
    raw_segment: IntArray

    @property
    def duration(self) -> float:
        """From the first sample to the end, s."""
        return float(self.segments.start[-1] + self.segments.length[-1])

    def since(self, *, raw: bool = False) -> tuple[FloatArray, IntArray]:
        """Time since the beginning of the piece, and the piece, of each block (or sample), shape (m,)."""
        time = self.raw_time if raw else self.time
        piece = self.pieces.of(time)
        return time - self.pieces.start[piece], piece

    @property
    def weight(self) -> FloatArray:
        """One over the variance of each block mean, 1/K^2.

        White scatter averages out; the quantiser's bias does not where too little noise dithers it (`quantiser_bias`).
        """
        correlated = quantiser_bias(self.noise_K, self.quantum_K) ** 2 + (0.05 * self.quantum_K) ** 2 + 1e-6
        return np.asarray(1.0 / (self.noise_K**2 / self.count + correlated), dtype=np.float64)


def quantiser_bias(noise: float, quantum: float) -> float:
    """Give the standard deviation of the mean error that a quantiser leaves in a constant signal with noise, K.

    The error of the mean is a sine of the signal with amplitude (q / pi) exp(-2 (pi sigma / q)^2), its first harmonic
    (Widrow and Kollar, Quantization Noise, chapter 4); without noise it is the sawtooth, q/sqrt(12).
    """
    if quantum <= 0.0:
        return 0.0
    dithered = quantum / (np.pi * np.sqrt(2.0)) * np.exp(-2.0 * (np.pi * noise / quantum) ** 2)
    return float(min(dithered, quantum / np.sqrt(12.0)))


def segments_of(time: FloatArray, pwm: IntArray, end: float) -> Segments:
    """Find the segments of held |PWM|; merge short ones where there are too many.

    Parameters
    ----------
    time, pwm
        Rows, time from 0 on, s; PWM in counts.
    end
        Where the last one ends, s.
    """
    level = np.abs(pwm)
    change = np.flatnonzero(np.diff(level, prepend=level[0] - 1))
    start = time[change]
    length = np.diff(np.append(start, end))
    level = level[change]
    keep = length > 0.0
    start, length, level = start[keep], length[keep], level[keep]
    if len(start) <= MOST_SEGMENTS:
        return Segments(start, length, level)
    return _merged(start, length, level, float(length.sum()) / MOST_SEGMENTS * 2.0)


def _merged(start: FloatArray, length: FloatArray, level: IntArray, window: float) -> Segments:
    starts: list[float] = []
    lengths: list[float] = []
    levels: list[int] = []
    mixed: dict[int, dict[int, float]] = {}
    pending: dict[int, float] = {}

    def flush() -> None:
        if pending:
            total = sum(pending.values())
            if len(pending) > 1:
                mixed[len(starts)] = {value: share / total for value, share in pending.items()}
            levels.append(next(iter(pending)) if len(pending) == 1 else -1)
            starts.append(starts[-1] + lengths[-1] if starts else float(start[0]))
            lengths.append(total)
            pending.clear()

    for duration, value in zip(length.tolist(), level.tolist(), strict=True):
        if duration >= window:
            flush()
        pending[value] = pending.get(value, 0.0) + duration
        if duration >= window or sum(pending.values()) >= window:
            flush()
    flush()
    return Segments(np.array(starts), np.array(lengths), np.array(levels, dtype=np.int64), mixed)


def condense(
    name: str, time: FloatArray, pwm: IntArray, measured: FloatArray, ambient: FloatArray | float
) -> Record | None:
    """Condense one component of one run.

    Parameters
    ----------
    name
        The run's name.
    time, pwm
        All rows of the run, s and counts.
    measured
        Temperature at these times, NaN where missing, degC.
    ambient
        Ambient at these times, or one for all, degC.

    Returns
    -------
    Record or None
        None with fewer than three samples.
    """
    rise = measured - ambient
    valid = np.flatnonzero(np.isfinite(rise))
    if valid.size < 3:
        return None
    first, last = valid[0], valid[-1]
    # The rows' clock starts at the component's first sample; PWM before it is the initial state's business.
    clock = np.maximum(time - time[first], 0.0)[first : last + 1]
    segments = segments_of(clock, pwm[first : last + 1], float(clock[-1]))
    around = ambient if isinstance(ambient, float) else ambient[first : last + 1]
    pieces, reference = pieces_of(segments.start, segments.length, clock, around)
    over = np.zeros(valid.size) if isinstance(ambient, float) else ambient[valid] - reference
    at = time[valid] - time[first]
    value = rise[valid]
    # A sample at the moment of a change is the new segment's first; the response is continuous, so either would do.
    owner = np.clip(np.searchsorted(segments.start, at, side="right") - 1, 0, len(segments.start) - 1)
    block = _blocks(at, owner, segments)
    edges = np.flatnonzero(np.diff(block, prepend=-1))
    count = np.diff(np.append(edges, at.size)).astype(np.float64)
    sample = float(np.median(np.diff(at)))
    return Record(
        run=name,
        segments=segments,
        time=np.add.reduceat(at, edges) / count,
        rise=np.add.reduceat(value, edges) / count,
        over=np.add.reduceat(over, edges) / count,
        count=count,
        segment=owner[edges],
        pieces=pieces,
        sample_s=sample,
        noise_K=scatter(measured[valid]),
        quantum_K=resolution(measured[valid]),
        raw_time=at,
        raw_rise=value,
        raw_over=over,
        raw_segment=owner,
    )


def _blocks(at: FloatArray, owner: IntArray, segments: Segments) -> IntArray:
    """Number the blocks: they grow with the time since the segment began, up to a share of the run."""
    since = at - segments.start[owner]
    largest = max(float(at[-1]) * FINEST, 1e-9)
    knee = largest / GROWTH
    floor = max(float(np.median(np.diff(at))) * 4.0, 1e-9)
    early = floor / GROWTH
    # The integral of 1 / width: linear at first, then logarithmic, then linear again.
    index = np.where(
        since < early,
        since / floor,
        early / floor + np.log(np.maximum(np.minimum(since, knee), early) / early) / GROWTH,
    ) + np.maximum(since - max(knee, early), 0.0) / max(largest, floor)
    number = np.floor(index).astype(np.int64)
    new = (np.diff(owner, prepend=owner[0]) != 0) | (np.diff(number, prepend=number[0]) != 0)
    return np.cumsum(new)


def scatter(value: FloatArray) -> float:
    """Give the standard deviation of a sample about the line through its neighbours, K.

    Second differences cancel a slope; their variance is 6 times the sample's where errors are independent.
    """
    if value.size < 5:
        return 0.0
    return float(np.sqrt(np.mean(np.diff(value, n=2) ** 2) / 6.0))


def resolution(value: FloatArray) -> float:
    """Give the step of which all differences are multiples, or 0, K."""
    sample = value[:200_000]
    steps = np.unique(np.round(np.abs(np.diff(np.sort(sample))), 9))
    steps = steps[steps > 1e-6]
    if not steps.size or np.unique(np.round(sample, 6)).size > 0.5 * sample.size:
        return 0.0
    smallest = float(steps[0])
    multiples = steps / smallest
    return smallest if np.max(np.abs(multiples - np.round(multiples))) < 0.05 else 0.0


def levels_of(records: Sequence[Record]) -> IntArray:
    """Give every |PWM| that occurs, increasing."""
    found: set[int] = set()
    for record in records:
        found.update(record.segments.dwell())
        for shares in record.segments.mixed.values():
            found.update(shares)
    return np.array(sorted(found), dtype=np.int64)
