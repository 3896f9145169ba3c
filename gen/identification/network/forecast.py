"""What the model is declared to be off by: its errors on what was left out."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Inputs
from gen.identification.network.left_out import LeftOut

WINDOW_S = 600.0
"""Errors are means over this time (or an eighth of the run): a sensor's noise is not the model's error."""
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
    level = inputs.level
    valid = np.arange(level.shape[1])[None, :] < inputs.length[:, None]
    at_rest = (inputs.levels.rest > 0.99)[level] & valid
    pwm = np.rint(inputs.levels.speed * full_scale)[level]
    turning = valid & (inputs.levels.rest < 0.5)[level]
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


def _band(
    inputs: Inputs, judged: LeftOut, mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]], pwm: tuple[int, int]
) -> Band:
    sensors = judged.error.shape[2]
    low, high, rms = (np.full(sensors, np.nan) for _ in range(3))
    for s in range(sensors):
        means: list[float] = []
        square = time = 0.0
        for r, run in enumerate(inputs.runs):
            k = run.width.size
            error = -judged.error[r, :k, s]
            used = mask[r, :k] & np.isfinite(error)
            if not used.any():
                continue
            window = max(min(WINDOW_S, run.duration / 8.0), 1.0)
            index = (run.edges[:-1][used] // window).astype(np.int64)
            cover = run.covered[used, s] + 1e-9
            total, weight = np.bincount(index, error[used] * cover), np.bincount(index, cover)
            means += (total[weight > 0.2 * weight.max()] / weight[weight > 0.2 * weight.max()]).tolist()
            square += float(np.sum(cover * error[used] ** 2))
            time += float(cover.sum())
        if means:
            low[s], high[s] = min(means), max(means)
            rms[s] = np.sqrt(square / time)
    return Band(pwm, low, high, rms)
