"""Whether what is gained on runs that were left out is more than chance, and more than a little."""

from __future__ import annotations

import numpy as np
from scipy import stats

from gen.arrays import FloatArray

LEVEL = 0.05
LEAST_GAIN = 0.05
"""An effect must lower the left-out RMSE, the sensor's noise included, by this share: less is not worth its cost."""
TOO_LITTLE = f"lowers the error on left-out runs by less than {LEAST_GAIN:.0%}"


def p_of_gains(gains: FloatArray) -> float:
    """One-sided p-value that gains, one for each block of what was left out, are above 0 by more than chance.

    Parameters
    ----------
    gains
        Shape (B,).
    """
    if gains.size < 3 or not np.any(gains != 0.0):
        return 1.0
    spread = np.std(gains, ddof=1) / np.sqrt(gains.size)
    if spread == 0.0:
        return 0.0 if gains.mean() > 0 else 1.0
    # Gains of a real effect are skewed (nothing in some blocks, much in others), which makes t small though every
    # difference is positive; Wilcoxon's signed ranks see that. The smaller p counts, doubled for the choice.
    by_mean = float(stats.t.sf(gains.mean() / spread, gains.size - 1))
    moved = gains[np.abs(gains) > 1e-12]
    by_rank = float(stats.wilcoxon(moved, alternative="greater").pvalue) if moved.size >= 6 else 1.0
    return min(1.0, 2.0 * min(by_mean, by_rank)) if gains.mean() > 0.0 else 1.0
