"""What the runs show at first sight: how fast each sensed part settles, and how far it rises.

Each part alone as one capacity between heat (w and w^2) and ambient, over a grid of time constants: linear least
squares for each.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Inputs

_GRID = 16
LEAST = 0.5
"""A part rises at full speed by this share of what it moves by at least, even where no rise goes with speed."""


@dataclass(frozen=True, eq=False)
class Scale:
    """What each part does alone.

    Attributes
    ----------
    settling
        Time constants, shape (S,), s.
    rise
        Rise at full speed, shape (S,), K, positive.
    """

    settling: FloatArray
    rise: FloatArray

    @property
    def settling_s(self) -> float:
        """Of the whole, s."""
        return float(np.exp(np.mean(np.log(self.settling))))

    @property
    def rise_K(self) -> float:
        """Of the whole, K."""
        return float(np.max(self.rise))


def scale_of(inputs: Inputs) -> Scale:
    """Fit each part alone."""
    longest = max(run.duration for run in inputs.runs)
    taus = np.geomspace(max(longest / 200.0, 20.0), 3.0 * longest, _GRID)
    decay = np.exp(-inputs.levels.width[:, None] / taus)  # (L, G)
    turning = 1.0 - inputs.levels.rest
    by_speed = np.stack([turning * inputs.levels.speed, turning * inputs.levels.square], axis=-1)
    drive = np.hstack([by_speed, inputs.levels.further])  # (L, D)
    count = drive.shape[1]
    # Filtered: ambient, w, w^2, what else drives, and what is left of the start.
    into = np.column_stack([inputs.ambient, drive[inputs.level], np.zeros(inputs.level.size)])[:, None, :]
    keep = decay[inputs.level][:, :, None]
    state = np.zeros((len(inputs.runs), taus.size, count + 2))
    state[:, :, -1] = 1.0
    middle = np.empty((inputs.level.size, taus.size, count + 2))
    for low, high in pairwise(inputs.first.tolist()):
        state = state[: high - low]
        after = into[low:high] + keep[low:high] * (state - into[low:high])
        middle[low:high] = 0.5 * (state + after)
        state = after
    settling, rise, least = [], [], []
    for s in range(inputs.target.shape[1]):
        weight = np.sqrt(inputs.covered[:, s])
        used = weight > 0.0
        if not used.any():
            settling.append(longest / 3.0)
            rise.append(10.0)
            least.append(1.0)
            continue
        begin = inputs.begin[inputs.run, s]
        errors, rises = [], []
        for g in range(taus.size):
            target = inputs.target[:, s] - middle[:, g, 0] - begin * middle[:, g, -1]
            columns = middle[:, g, 1:-1][used] * weight[used][:, None]
            right = target[used] * weight[used]
            ridge = 1e-4 * np.sqrt(np.sum(columns**2) / count) * np.eye(count)
            solved = np.linalg.lstsq(np.vstack([columns, ridge]), np.append(right, np.zeros(count)), rcond=None)[0]
            errors.append(float(np.sum((right - columns @ solved) ** 2)))
            rises.append(float(solved[:2].sum()))
        best = int(np.argmin(errors))
        settling.append(float(taus[best]))
        rise.append(rises[best])
        least.append(max(LEAST * float(np.ptp(inputs.target[used, s])), 1.0))
    return Scale(np.array(settling), np.maximum(np.array(rise), np.array(least)))
