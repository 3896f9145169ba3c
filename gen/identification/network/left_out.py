"""The error on runs that took no part in the fit, or on stretches where there are too few runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from gen.arrays import BoolArray, FloatArray, SingleArray
from gen.identification.network.fitting.fit import settle
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.fitting.problem import Evaluated
from gen.identification.network.search import Found
from gen.side_by_side import side_by_side

MOST_FOLDS = 5
STRETCHES = 8
"""Where there are few runs each is cut into so many; each fold leaves out every fourth."""
FEW = 2
ALIKE, MOST_ALONE = 0.05, 0.5
"""Speeds within this of each other are alike; runs have speeds of their own where more than this share of
the time that turns is at speeds that no other run has."""
AT_EACH = 5
"""Linearisations of a fold, from where all runs lead."""


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Errors of predictions.

    Attributes
    ----------
    error
        Reading minus prediction, shape (N, S), K; NaN where nothing was predicted.
    by_fold
        Mean square by fold and sensed node, shape (F, S), K^2.
    """

    error: FloatArray
    by_fold: FloatArray

    @property
    def score_K(self) -> float:
        """Root of the mean square over folds and nodes, K."""
        return float(np.sqrt(np.nanmean(self.by_fold)))


def folds_of(inputs: Inputs) -> list[BoolArray]:
    """Give what each fold leaves out, shape (N,) each."""
    runs = len(inputs.runs)
    if runs <= FEW:
        # Half of the data, and speeds that no other run has, would be too much to leave out.
        return stretches_of(inputs)
    # Neighbours in the list are often alike (speeds in order): a fold takes runs from all over it.
    count = min(runs, MOST_FOLDS)
    return [inputs.run % count == k for k in range(count)]


def folds_for_nodes(inputs: Inputs) -> list[BoolArray]:
    """Give what to leave out to see how many nodes there are, shape (N,) each.

    Where each run has a speed of its own, one that is left out tells how well speeds between others are met, which has
    nothing to do with the nodes and is the larger by far; stretches tell of the nodes.
    """
    return stretches_of(inputs) if each_alone(inputs) else folds_of(inputs)


def stretches_of(inputs: Inputs) -> list[BoolArray]:
    """Give stretches of all runs, shape (N,) each: each fold leaves out every fourth."""
    duration = np.array([run.duration for run in inputs.runs])[inputs.run]
    part = (inputs.begins / duration * STRETCHES).astype(np.int64)
    return [(part % (STRETCHES // 2)) == k for k in range(STRETCHES // 2)]


def second_half(inputs: Inputs) -> BoolArray | None:
    """Give the second half of the only run, shape (N,); None where there are more, which tell of each other.

    Stretches lie between what takes part in the fit, which holds them from both sides; nothing holds what comes later.
    """
    return inputs.begins >= 0.5 * inputs.runs[0].duration if len(inputs.runs) == 1 else None


def each_alone(inputs: Inputs) -> bool:
    """Whether most of the time that turns is at speeds which no other run has, and no run changes speed much."""
    turning = inputs.turns
    alone = total = 0.0
    for r in range(len(inputs.runs)):
        own = turning & (inputs.run == r)
        others = np.unique(inputs.speed[turning & (inputs.run != r)])
        speeds = inputs.speed[own]
        if speeds.size and np.ptp(speeds) > ALIKE:
            return False
        far = np.all(np.abs(speeds[:, None] - others) > ALIKE, axis=1)
        alone += float(inputs.width[own][far].sum())
        total += float(inputs.width[own].sum())
    return len(inputs.runs) > FEW and alone > MOST_ALONE * total


def left_out(found: Found, folds: Sequence[BoolArray]) -> LeftOut:
    """Fit without each fold and predict it, side by side."""
    return together(found, folds, side_by_side(predictions(found, folds)))


def all_left_out(found: Sequence[Found], folds: Sequence[BoolArray]) -> list[LeftOut]:
    """Give the same of several networks, all side by side."""
    made = side_by_side([task for one in found for task in predictions(one, folds)])
    count = len(folds)
    return [together(one, folds, made[k * count : (k + 1) * count]) for k, one in enumerate(found)]


def predictions(found: Found, folds: Sequence[BoolArray]) -> list[Callable[[], FloatArray]]:
    """Give what :func:`predicted` gives of each fold, to be done side by side."""
    known = found.problem.slopes(found.vector)
    return [partial(predicted, found, known, mask) for mask in folds]


def predicted(found: Found, known: tuple[Evaluated, SingleArray], mask: BoolArray) -> FloatArray:
    """Fit without a fold and predict it.

    Parameters
    ----------
    found
        Fitted to all runs.
    known
        What `slopes` of its problem gives there: folds differ by their weights alone.
    mask
        What is left out, shape (N,).

    Returns
    -------
    FloatArray
        Reading minus prediction, shape (N, S), K; NaN where nothing was left out, or nothing read.
    """
    problem, inputs = found.problem, found.problem.inputs
    without = problem.weighed(np.where(mask[:, None], 0.0, inputs.weight))
    start = found.vector.copy()
    for r, row in enumerate(inputs.rows):
        if mask[row].all():
            # A new run: nothing is known of it but where it begins.
            own = without.columns(r)[problem.structure.size :]
            start[own] = problem.prior.mean[own]
    # Another start of runs that are left out changes nothing of the others.
    begun = without.weighed_up(*known)
    evaluated = problem.evaluate(settle(without, start, AT_EACH, begun=begun).vector)
    return np.where(mask[:, None] & (inputs.covered > 0.0), evaluated.residual, np.nan)


def together(found: Found, folds: Sequence[BoolArray], errors: Sequence[FloatArray]) -> LeftOut:
    """Put the folds' errors together."""
    covered = found.problem.inputs.covered
    error = np.full(covered.shape, np.nan)
    by_fold = np.full((len(folds), covered.shape[1]), np.nan)
    for f, (mask, own) in enumerate(zip(folds, errors, strict=True)):
        cover = np.where(mask[:, None], covered, 0.0)
        error[cover > 0.0] = own[cover > 0.0]
        total = cover.sum(axis=0)
        square = np.sum(cover * np.nan_to_num(own) ** 2, axis=0)
        by_fold[f] = np.where(total > 0.0, square / np.maximum(total, 1e-9), np.nan)
    return LeftOut(error, by_fold)
