"""The ambient along a record: its changes pass the part's own dynamics, so it is part of what the part settles to.

It is taken as constant over pieces, so that the response stays exact (:mod:`gen.identification.parts.response`): a room
changes slowly, and what a piece leaves out passes the part's time constants. Single readings of its sensor take no
part.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray

STEP_K = 0.1
"""A new piece begins where the ambient has moved by this, or by more where there would be too many."""
MOST_PIECES = 120
SMOOTHED_S = 60.0
"""The ambient is averaged over this long, or over a thousandth of the run, before its changes count."""
_BINS = 1000


@dataclass(frozen=True, eq=False)
class Pieces:
    """Stretches of constant |PWM| and, as far as it matters, constant ambient.

    Attributes
    ----------
    start, length
        Since the record's first row, shape (S,), s.
    segment
        Which segment of the record each lies in, shape (S,).
    over
        Mean ambient less that of the first piece, shape (S,), K.
    """

    start: FloatArray
    length: FloatArray
    segment: IntArray
    over: FloatArray

    def of(self, time: FloatArray) -> IntArray:
        """The piece that each time lies in, shape as the times (s since the record's first row)."""
        return np.clip(np.searchsorted(self.start, time, side="right") - 1, 0, len(self.start) - 1)


def pieces_of(
    start: FloatArray, length: FloatArray, time: FloatArray, ambient: FloatArray | float
) -> tuple[Pieces, float]:
    """Cut a record's segments where the ambient moves.

    Parameters
    ----------
    start, length
        Of the segments, shape (S,), s.
    time
        Of the rows, not decreasing, s.
    ambient
        At the rows, or one for all, degC.

    Returns
    -------
    pieces, reference
        The pieces, and the first one's ambient, degC.
    """
    every = np.arange(len(start))
    if isinstance(ambient, float) or np.ptp(ambient) == 0.0:
        return Pieces(start, length, every, np.zeros(len(start))), float(np.ravel(ambient)[0])
    end = float(start[-1] + length[-1])
    cuts = _cuts(time, ambient, end)
    edges = np.union1d(np.append(start, end), cuts[(cuts > start[0]) & (cuts < end)])
    owner = np.clip(np.searchsorted(start, edges[:-1], side="right") - 1, 0, len(start) - 1)
    # The mean over each room's piece, not over each piece: a short segment's own few readings would be noise.
    rooms = np.searchsorted(cuts, time, side="right")
    total, count = np.bincount(rooms, ambient, len(cuts) + 1), np.bincount(rooms, minlength=len(cuts) + 1)
    mean = total / np.maximum(count, 1)
    level = mean[np.searchsorted(cuts, edges[:-1], side="right")]
    return Pieces(edges[:-1], np.diff(edges), owner, level - level[0]), float(level[0])


def _cuts(time: FloatArray, ambient: FloatArray, end: float) -> FloatArray:
    """Times at which a new piece of the room begins, increasing; every piece holds a row."""
    width = max(SMOOTHED_S, end / _BINS)
    index = np.floor((time - time[0]) / width).astype(np.int64)
    used, place = np.unique(index, return_inverse=True)
    mean = np.bincount(place, ambient) / np.bincount(place)
    step = STEP_K
    while True:
        found = _moved(mean, step)
        if len(found) <= MOST_PIECES:
            return np.asarray(time[0] + used[found] * width, dtype=np.float64)
        step *= 1.5


def _moved(values: FloatArray, step: float) -> list[int]:
    """Where the value has moved by a step since the last of these places, the first one left out."""
    found, last = [], float(values[0])
    for place, value in enumerate(values.tolist()):
        if abs(value - last) >= step:
            found.append(place)
            last = value
    return found
