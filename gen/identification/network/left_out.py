"""The error on runs that took no part in the fit, or on stretches where there are too few runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.identification.network.bins import FloatArray
from gen.identification.network.fit import settle
from gen.identification.network.inputs import Inputs
from gen.identification.network.search import Found

MOST_FOLDS = 5
STRETCHES = 8
"""A run that is alone is cut into so many; each fold leaves out every fourth."""
AT_EACH = 6
"""Linearisations of a fold, from where all runs lead."""

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Errors of predictions.

    Attributes
    ----------
    error
        Reading minus prediction, shape (R, T, S), K; NaN where nothing was predicted.
    by_fold
        Mean square by fold and sensed node, shape (F, S), K^2.
    """

    error: FloatArray
    by_fold: FloatArray

    @property
    def score_K(self) -> float:
        """Root of the mean square over folds and nodes, K."""
        return float(np.sqrt(np.nanmean(self.by_fold)))


def folds_of(inputs: Inputs) -> list[Mask]:
    """Give what each fold leaves out, shape (R, T) each."""
    runs, bins = inputs.level.shape
    made = []
    if runs == 1:
        part = np.arange(bins) * STRETCHES // bins
        return [((part % (STRETCHES // 2)) == k)[None, :] for k in range(STRETCHES // 2)]
    # Neighbours in the list are often alike (speeds in order): a fold takes runs from all over it.
    count = min(runs, MOST_FOLDS)
    for k in range(count):
        mask = np.zeros((runs, bins), dtype=bool)
        mask[k::count] = True
        made.append(mask)
    return made


def left_out(found: Found, folds: list[Mask]) -> LeftOut:
    """Fit without each fold and predict it."""
    problem, inputs = found.problem, found.problem.inputs
    structure = problem.structure
    cover = inputs.weight > 0.0
    error = np.full(inputs.target.shape, np.nan)
    by_fold = np.full((len(folds), len(structure.sensed)), np.nan)
    time = inputs.levels.width[inputs.level]
    for f, mask in enumerate(folds):
        without = problem.weighed(np.where(mask[:, :, None], 0.0, inputs.weight))
        start = found.vector.copy()
        whole = np.flatnonzero(mask.all(axis=1))
        for r in whole.tolist():
            # A new run: nothing is known of it but where it begins.
            own = without.columns(r)[structure.size :]
            start[own] = problem.prior.mean[own]
        vector = settle(without, start, AT_EACH).vector
        evaluated = problem.evaluate(vector)
        shown = mask[:, :, None] & cover
        error[shown] = evaluated.residual[shown]
        for s in range(len(structure.sensed)):
            weight = np.where(shown[:, :, s], time, 0.0)
            total = float(weight.sum())
            if total > 0.0:
                by_fold[f, s] = float(np.sum(weight * evaluated.residual[:, :, s] ** 2)) / total
    return LeftOut(error, by_fold)
