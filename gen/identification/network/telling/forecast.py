"""What the model is declared to be off by: its errors on what was left out."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gen.identification.network.fitting.bins import FloatArray
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.left_out import LeftOut, Mask

WINDOWS = 60
"""Errors are means over this share of a run: a sensor's noise is not the model's error."""
LEAST_SHARE = 0.2
"""Windows that are covered less than others by this factor do not count."""
MOST_BANDS = 6


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
    at_rest = inputs.rest > 0.99
    pwm = np.rint(inputs.speed * full_scale)
    turning = inputs.rest < 0.5
    made = []
    if at_rest.any():
        made.append(_band(inputs, judged, at_rest, (0, 0)))
    for low, high in _ranges(pwm[turning]):
        made.append(_band(inputs, judged, turning & (pwm >= low) & (pwm <= high), (low, high)))
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


def _band(inputs: Inputs, judged: LeftOut, mask: Mask, pwm: tuple[int, int]) -> Band:
    sensors = judged.error.shape[1]
    low, high, rms = (np.full(sensors, np.nan) for _ in range(3))
    for s in range(sensors):
        means: list[float] = []
        square = time = 0.0
        for run, row in zip(inputs.runs, inputs.rows, strict=True):
            used = row[mask[row] & np.isfinite(judged.error[row, s])]
            if not used.size:
                continue
            error, cover = -judged.error[used, s], inputs.covered[used, s]
            window = run.duration / WINDOWS
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
