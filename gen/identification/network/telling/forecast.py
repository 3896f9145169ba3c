"""What the model is declared to be off by: its errors on what was left out."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gen.arrays import BoolArray, FloatArray
from gen.coefficients.provenance import ERROR_WINDOWS
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.left_out import LeftOut

LEAST_SHARE = 0.2
"""Windows that are covered less than others by this factor do not count."""
MOST_BANDS = 6
AT_REST = 0.99
"""Share of a bin at PWM 0 from which it is one of rest."""


@dataclass(frozen=True, eq=False)
class Band:
    """Model minus measured on left-out data in a range of speeds.

    Attributes
    ----------
    pwm
        Lowest and highest |PWM|.
    low, high
        Shape (S,), K; NaN where nothing was predicted there.
    rms
        Shape (S,), K.
    """

    pwm: tuple[int, int]
    low: FloatArray
    high: FloatArray
    rms: FloatArray


def bands(inputs: Inputs, judged: LeftOut, full_scale: int) -> list[Band]:
    """Give the errors by speed, rest first where it was measured."""
    pwm = np.rint(inputs.speed * full_scale)
    ranges = [(0, 0)] if (inputs.rest > AT_REST).any() else []
    ranges += _ranges(pwm[inputs.turns])
    return [_band(inputs, judged.error, one, full_scale) for one in ranges]


def widened(found: list[Band], inputs: Inputs, residual: FloatArray, full_scale: int) -> list[Band]:
    """Let bands hold what the file errs by in its own runs, too.

    Parameters
    ----------
    found
        Of data left out.
    inputs, residual
        Bins of the runs, and reading minus model there, shape (N, S), K.
    full_scale
        The count that is 100 %.
    """
    error = np.where(inputs.covered > 0.0, residual, np.nan)
    made = []
    for band in found:
        own = _band(inputs, error, band.pwm, full_scale)
        low, high = np.fmin(band.low, own.low), np.fmax(band.high, own.high)
        told = np.isfinite(band.low)
        made.append(Band(band.pwm, np.where(told, low, np.nan), np.where(told, high, np.nan), band.rms))
    return made


def _ranges(pwm: FloatArray) -> list[tuple[int, int]]:
    """Ranges of |PWM| that meet each other, around speeds that occur."""
    speeds = np.unique(pwm).astype(np.int64)
    if speeds.size > MOST_BANDS:
        quantiles = np.quantile(pwm, np.linspace(0.0, 1.0, MOST_BANDS - 1))
        ends = np.unique(np.rint(quantiles).astype(np.int64))
        ends = ends if ends.size > 1 else np.array([speeds[0], speeds[-1]])
        return [(int(a) + (k > 0), int(b)) for k, (a, b) in enumerate(pairwise(ends.tolist()))]
    middles = (speeds[1:] + speeds[:-1]) // 2
    lows = [int(speeds[0]), *(int(m) + 1 for m in middles)]
    highs = [*(int(m) for m in middles), int(speeds[-1])]
    return list(zip(lows, highs, strict=True))


def _within(inputs: Inputs, pwm: tuple[int, int], full_scale: int) -> BoolArray:
    """Bins of a range of |PWM|, rest being one of its own, shape (N,)."""
    if pwm == (0, 0):
        return np.asarray(inputs.rest > AT_REST)
    level = np.rint(inputs.speed * full_scale)
    return np.asarray(inputs.turns & (level >= pwm[0]) & (level <= pwm[1]))


def _band(inputs: Inputs, errors: FloatArray, pwm: tuple[int, int], full_scale: int) -> Band:
    sensors, mask = errors.shape[1], _within(inputs, pwm, full_scale)
    low, high, rms = (np.full(sensors, np.nan) for _ in range(3))
    for s in range(sensors):
        means: list[float] = []
        square = time = 0.0
        for run, row in zip(inputs.runs, inputs.rows, strict=True):
            used = row[mask[row] & np.isfinite(errors[row, s])]
            if not used.size:
                continue
            error, cover = -errors[used, s], inputs.covered[used, s]
            window = run.duration / ERROR_WINDOWS
            index = (inputs.begins[used] // window).astype(np.int64)
            total, weight = np.bincount(index, error * cover), np.bincount(index, cover)
            whole = weight > LEAST_SHARE * weight.max()
            means += (total[whole] / weight[whole]).tolist()
            square += float(np.sum(cover * error**2))
            time += float(cover.sum())
        if means:
            low[s], high[s] = min(means), max(means)
            rms[s] = np.sqrt(square / time)
    return Band(pwm, low, high, rms)
