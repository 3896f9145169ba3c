"""Thinning of long runs: a thermal model does not need every row of a month at 4 Hz.

Rows are taken out, none is changed: a temperature that is kept is a single sample as it was, so its noise is a single
sample's. Every change of PWM keeps its row; channels are held, so a row that is kept carries their mean until the next.
Only where PWM changes more often than rows are to be kept is it averaged, too (its magnitude, over time).
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray, IntArray

_STRETCHES = 100
"""Of a run, along which rows with the most temperatures are looked for."""
_MOST_CHANGES = 0.5
"""As a share of the rows that are to be kept."""


def thinned(channels: dict[str, NDArray[Any]], sampled: Collection[str], most_rows: int) -> dict[str, NDArray[Any]]:
    """Thin a run.

    Parameters
    ----------
    channels
        Columns by name, among them ``time_s`` and ``pwm``, shape (N,) each. The dictionary is emptied on the way, so
        that memory is given back.
    sampled
        Columns whose values belong to their row's time; others (but time and PWM) are held until the next row.
    most_rows
        About how many rows to keep; changes of PWM come on top.

    Returns
    -------
    dict
        Columns in float64, PWM as int64.
    """
    time, pwm = channels.pop("time_s"), channels.pop("pwm")
    kept = _informative(channels, sampled, time.size)
    kept = kept[:: _prime(-(-kept.size // most_rows))]
    changed = np.flatnonzero(pwm[1:] != pwm[:-1]) + 1
    held = changed.size <= _MOST_CHANGES * most_rows
    kept = np.unique(np.concatenate([[0], kept, changed if held else changed[:0], [time.size - 1]]))
    made: dict[str, NDArray[Any]] = {"time_s": time[kept]}
    made["pwm"] = pwm[kept].astype(np.int64) if held else _averaged(time, pwm, kept)
    del time, pwm
    for name in list(channels):
        values = channels.pop(name)
        made[name] = values[kept].astype(np.float64) if name in sampled else _means(values, kept)
    return made


def _informative(channels: dict[str, NDArray[Any]], sampled: Collection[str], rows: int) -> IntArray:
    """Rows with as many measured temperatures as any other about them: a log may have them in every tenth row only.

    About them, and not in all of the run: a sensor may be lost for good, or come late.
    """
    from scipy.ndimage import maximum_filter1d  # slow to import: what is wrong with a file was told before

    measured = np.zeros(rows, dtype=np.int16)
    for name in sampled:
        measured += np.isfinite(channels[name])
    if not measured.size:
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(measured == maximum_filter1d(measured, 1 + rows // _STRETCHES))


def _prime(least: int) -> int:
    """A stride that is prime: sensors that take turns from row to row all keep their share."""
    return next(n for n in count(max(least, 1)) if all(n % d for d in range(2, int(n**0.5) + 1)))


def _means(values: NDArray[Any], kept: IntArray) -> FloatArray:
    """Mean from each kept row to the next, NaN where nothing was measured."""
    good = np.isfinite(values)
    number = np.add.reduceat(good, kept, dtype=np.int64)
    total = np.add.reduceat(np.where(good, values, np.zeros(1, values.dtype)), kept, dtype=np.float64)
    return np.asarray(np.where(number > 0, total / np.maximum(number, 1), np.nan))


def _averaged(time: FloatArray, pwm: NDArray[Any], kept: IntArray) -> IntArray:
    """Mean |PWM| over time until the next kept row, commoner sign; the rounded rest goes to the next."""
    step = np.diff(time, append=2.0 * time[-1] - time[-2])  # the last row counts, too
    span = np.maximum(np.add.reduceat(step, kept), 1e-12)
    mean = np.add.reduceat(np.abs(pwm) * step, kept) / span
    backward = np.add.reduceat((pwm < 0) * step, kept) > np.add.reduceat((pwm > 0) * step, kept)
    whole = np.floor(np.cumsum(mean) + 0.5)
    counts = np.diff(whole, prepend=0.0).astype(np.int64)
    return np.where(backward, -counts, counts)
