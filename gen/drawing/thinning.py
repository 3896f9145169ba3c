"""Fewer points of a curve, among them its extremes; gaps stay gaps.

Unlike :mod:`gen.runs.thinning` this is for the eye alone: nothing is computed from what is left.
"""

from __future__ import annotations

import numpy as np
from tsdownsample import MinMaxDownsampler

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.runs.gaps import gaps

_SHARE_OF_GAPS = 8


def line(time_s: FloatArray, values: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """Give a line's points: all, or of each stretch the lowest and the highest.

    Parameters
    ----------
    time_s, values
        Shape (N,); NaN where nothing was measured.
    most
        No more points are given, at least 64.

    Returns
    -------
    tuple of FloatArray
        Times and values, shape (M,), M <= most; a NaN parts what a gap parts. Where there are very many gaps the
        longest are kept.
    """
    known = np.flatnonzero(np.isfinite(values))
    after = gaps(time_s, values)
    x, y = np.ascontiguousarray(time_s[known]), np.ascontiguousarray(values[known], dtype=np.float64)
    if x.size + np.count_nonzero(after) <= most:
        return _parted(x, y, after)
    after = _longest(x, after, most // _SHARE_OF_GAPS)
    ends = np.flatnonzero(after)
    spare = most - 2 - 3 * ends.size
    kept = np.unique(np.concatenate([[0, x.size - 1], ends, ends + 1, _extremes(y, spare)])).astype(np.int64)
    return _parted(x[kept], y[kept], after[kept])


def steps(time_s: FloatArray, values: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """Give the points of what is held from row to row, as a line with upright flanks.

    Parameters
    ----------
    time_s, values
        Shape (N,); NaN where there is none.
    most
        No more points are given, at least 64.

    Returns
    -------
    tuple of FloatArray
        Times and values, shape (M,), M <= most.
    """
    same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    begins = np.flatnonzero(np.concatenate([[True], ~same]))
    if 2 * begins.size > most:
        filled = np.nan_to_num(values[begins])
        begins = begins[np.unique(np.concatenate([[0, begins.size - 1], _extremes(filled, most // 2 - 2)]))]
    ends = np.append(time_s[begins[1:]], time_s[-1])
    return np.stack([time_s[begins], ends], axis=1).ravel(), np.repeat(values[begins], 2)


def lonely(values: FloatArray) -> BoolArray:
    """Find the values of a line that no line leads to or from: only a dot shows them."""
    known = np.isfinite(values)
    beside = np.zeros(values.size, dtype=np.bool_)
    beside[1:] |= known[:-1]
    beside[:-1] |= known[1:]
    return known & ~beside


def _extremes(values: FloatArray, most: int) -> IntArray:
    """Places of the lowest and the highest value of each of as many equal stretches as give no more than `most`."""
    even = max(2, most // 2 * 2)
    if values.size <= even:
        return np.arange(values.size, dtype=np.int64)
    chosen = MinMaxDownsampler().downsample(np.ascontiguousarray(values), n_out=even)  # type: ignore[no-untyped-call]
    return np.asarray(chosen, dtype=np.int64)


def _longest(x: FloatArray, after: BoolArray, most: int) -> BoolArray:
    places = np.flatnonzero(after)
    if places.size <= most:
        return after
    length = x[places + 1] - x[places]
    kept = np.zeros_like(after)
    kept[places[np.argsort(-length, kind="stable")[:most]]] = True
    return kept


def _parted(x: FloatArray, y: FloatArray, after: BoolArray) -> tuple[FloatArray, FloatArray]:
    """The line with a NaN behind every point that a gap follows."""
    places = np.flatnonzero(after) + 1
    middle = (x[places - 1] + x[places]) / 2.0
    return np.insert(x, places, middle), np.insert(y, places, np.nan)
