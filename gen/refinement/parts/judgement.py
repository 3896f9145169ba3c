"""Is an improvement on runs left out more than chance?

The test: on every run that a fit did not see, the squared residual without and with the effect is compared in blocks
(six a run, more where runs are few; whole runs left out in turn); a one-sided test on the blocks' differences gives p.
The level is 5 %, divided by the number of hypotheses tried (Bonferroni).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.model.effects import Applied, Free
from gen.refinement.gains import LEAST_GAIN, LEVEL, TOO_LITTLE, p_of_gains
from gen.refinement.parts.simulation_fit import HypothesisFit
from gen.refinement.parts.stacked_runs import StackedRuns

ALONE = "what drives it is in one left-out part alone, so that no other can confirm it"
RUNS_AWAY = "with it the temperature would grow without end"
WORSE_RUN = 1.05
"""No left-out run may get worse by more than this factor (beside a third of the noise)."""
TIE_LEVEL = 0.05
SAME = 0.2
"""An effect's size must have one sign in every fold, and the smallest be at least this share of the largest."""


@dataclass(frozen=True)
class Judgement:
    """What the left-out runs say of a hypothesis at one component.

    Parameters
    ----------
    p_value
        Of the one-sided test that it lowers the squared error.
    before_K, after_K
        RMSE on left-out runs, the sensor's noise included, K.
    reasons
        Why it is not accepted; empty if it is.
    """

    p_value: float
    before_K: float
    after_K: float
    reasons: tuple[str, ...]

    @property
    def accepted(self) -> bool:
        """Accepted."""
        return not self.reasons


def p_better(problem: StackedRuns, c: int, worse: HypothesisFit, better: HypothesisFit) -> float:
    """One-sided p-value that `better` has the smaller squared error in left-out blocks at component c."""
    w = problem.weight[:, c, 0, :]
    gain = w * (worse.left_out[:, c] ** 2 - better.left_out[:, c] ** 2)
    good = (problem.blocks >= 0) & (w > 0)
    total = np.bincount(problem.blocks[good], gain[good])
    size = np.bincount(problem.blocks[good], w[good])
    d = total[size > 0] / size[size > 0]
    return p_of_gains(d)


def judge(problem: StackedRuns, c: int, null: HypothesisFit, found: HypothesisFit, tried: int, added: int) -> Judgement:
    """Decide on the hypothesis `found` against `null` at component c.

    Parameters
    ----------
    problem, c
        The data and the component's index.
    null, found
        Fits without and with the effect.
    tried
        Number of hypotheses tried, for the correction of the level.
    added
        Index of the first free parameter of the effect in question.
    """
    variance = float(problem.noise_K[c]) ** 2
    before, after = (float(np.sqrt(f.loss[c] + variance)) for f in (null, found))
    p = p_better(problem, c, null, found)
    reasons = []
    if after > (1.0 - LEAST_GAIN) * before:
        reasons.append(TOO_LITTLE)
    if p > LEVEL / tried:
        reasons.append("not more than chance")
    worse = _worse_run(problem, c, null, found, variance)
    if worse:
        reasons.append("makes a run worse where it was left out")
    reasons += _parameters(found, c, added)
    if not reasons and problem.runs_away(_applied(problem.components[c], found, c)):
        reasons.append(RUNS_AWAY)
    return Judgement(p, before, after, tuple(reasons))


def _applied(component: str, found: HypothesisFit, c: int) -> list[Applied]:
    values = found.values(c)
    return [Applied(term.effect, component, each) for term, each in zip(found.terms, values, strict=True)]


def _worse_run(problem: StackedRuns, c: int, null: HypothesisFit, found: HypothesisFit, variance: float) -> bool:
    w = problem.weight[:, c, 0, :]
    size = np.maximum(w.sum(axis=0), 1e-9)
    old = np.sum(w * null.left_out[:, c] ** 2, axis=0) / size
    new = np.sum(w * found.left_out[:, c] ** 2, axis=0) / size
    many = bool(np.any(new + variance > WORSE_RUN**2 * (old + variance) + 0.1 * variance))
    return many and bool(np.sum(new) > 0.25 * np.sum(old))


def _parameters(found: HypothesisFit, c: int, added: int) -> list[str]:
    """What speaks against the parameters of the terms that were added, beginning with free parameter `added`."""
    reasons = []
    sizes = (found.size(at) for at in range(len(found.terms)) if found.first_free(at) >= added)
    size = next((place for place in sizes if place is not None), None)
    for i, free in enumerate(found.free[added:], start=added):
        if free.low == free.high:
            continue
        if i == size:
            reasons += _size(found, c, i)
        if free.role == "time constant":
            reasons += _time_constant(free, float(found.numbers[c, i]), float(found.spread[c, i]))
    return reasons


def _size(found: HypothesisFit, c: int, i: int) -> list[str]:
    """What speaks against an effect's size: no different from none, not the same in every fold, at its limit."""
    free, each = found.free[i], found.folds[c, :, i]
    level = free.role == "level"
    one_sign = bool(np.all(each > 0.0) or np.all(each < 0.0))
    steady = one_sign and np.min(np.abs(each)) > SAME * np.max(np.abs(each))
    reasons = []
    if not level and np.any(np.abs(each - _starts(found)[i]) < 1e-9):
        reasons.append(ALONE)  # without that group the fit stayed where it began, which says nothing
    elif not told_from_none(found, c, i) or not (steady or level):
        reasons.append(f"{free.name} cannot be told from no effect")
    if not free.log and float(found.numbers[c, i]) >= free.high * 0.999:
        reasons.append(f"{free.name} is at its physical limit")
    return reasons


def _time_constant(free: Free, value: float, spread: float) -> list[str]:
    """A time constant of which the data say nothing, or that they push to its limit, is no part's.

    The hypothesis then lends its form to something else.
    """
    if 4.0 * (spread if free.log else spread / max(value, 1e-12)) > np.log(free.high / free.low):
        return [f"{free.name} is not determined"]
    inside = 1.01 * free.low < value < free.high / 1.01
    return [] if inside else [f"{free.name} is at its limit"]


def told_from_none(found: HypothesisFit, c: int, at: int) -> bool:
    """Whether the 95 % interval of an effect's size leaves out zero.

    Parameters
    ----------
    found, c
        The fit and the component's index.
    at
        Index of the size among the free parameters. Sizes by logarithm and levels have no zero to be told from, and
        only have to be determined.
    """
    free, spread = found.free[at], float(found.spread[c, at])
    if not np.isfinite(spread):
        return False
    return free.log or free.role == "level" or abs(float(found.numbers[c, at])) > 2.0 * spread


def _starts(found: HypothesisFit) -> list[float]:
    """Where the fits began, in their own scale."""
    pairs = ((free, x) for term in found.terms for free, x in zip(term.variant.free, term.start, strict=True))
    return [float(np.log(max(x, 1e-12))) if free.log else x for free, x in pairs]
