"""How the two kinds compare on what was left out: by how much, and how sure that is.

Each run that was left out (of a single run each stretch) gives one number, the logarithm of the parts' error over the
network's. Their mean, with the 95 % interval of Student's t, says how the two compare: runs are what is drawn anew next
time, and readings within one run are no further evidence. A ratio counts every run alike, whether it moves by 5 K or
by 100.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from gen.arrays import FloatArray
from gen.identification.choice.left_out import Judged

Kind = Literal["parts", "network"]
NETWORK: Kind = "network"
PARTS: Kind = "parts"
KINDS = (NETWORK, PARTS)
SURE = 0.95
LEAST_K = 1e-3
"""Errors below this are the same."""

Errors = Mapping[Judged, FloatArray]
"""Mean square errors by run and part, shape (BLOCKS,) each, K^2."""


@dataclass(frozen=True)
class Comparison:
    """Both kinds on what was left out, over the same runs and parts.

    Attributes
    ----------
    error_K
        Root mean square error by kind, each run and part counting alike, K.
    by_run
        The same in each run (or stretch), K, in one order.
    """

    error_K: Mapping[Kind, float]
    by_run: Mapping[Kind, tuple[float, ...]]

    @property
    def logs(self) -> FloatArray:
        """Logarithm of the parts' error over the network's in each run, shape (n,)."""
        parts, network = (np.maximum(self.by_run[kind], LEAST_K) for kind in (PARTS, NETWORK))
        return np.asarray(np.log(parts / network), dtype=np.float64)

    @property
    def ratio(self) -> float:
        """Geometric mean over the runs of the parts' error over the network's."""
        return math.exp(float(np.mean(self.logs)))

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the ratio; (0, inf) for one run."""
        logs = self.logs
        if logs.size < 2:
            return 0.0, math.inf
        half = _sure(logs.size) * float(np.std(logs, ddof=1)) / math.sqrt(logs.size)
        return self.ratio * math.exp(-min(half, 700.0)), self.ratio * math.exp(min(half, 700.0))

    def may_show_parts(self, further: int) -> bool:
        """Whether so many further runs could still make it sure that parts are better.

        With L of n runs, t^2 = (n - 1) A / (n - A), A = (sum L)^2 / sum L^2. Of m further ones those serve best that
        are alike, and then A is at most m + S^2 / Q of the sum S and the sum of squares Q of those known; m, if S is
        not negative.
        """
        logs = self.logs
        total, square = float(np.sum(logs)), float(np.sum(logs**2))
        most = further + (total**2 / square if total < 0.0 else 0.0)
        count = logs.size + further
        return (count - 1) * most > _sure(count) ** 2 * (count - most)


def comparison(errors: Mapping[Kind, Sequence[Errors | None]]) -> Comparison | None:
    """Compare both kinds over the runs and parts that both predict; None where there is none.

    Parameters
    ----------
    errors
        By kind: of each fold, or None where its fit was refused.
    """
    squares: dict[Kind, list[float]] = {kind: [] for kind in KINDS}
    runs: dict[Kind, list[float]] = {kind: [] for kind in KINDS}
    for folds in zip(*(errors[kind] for kind in KINDS), strict=True):
        known = [fold for fold in folds if fold is not None]
        if len(known) < len(KINDS):
            continue
        both = [one for one in known[0] if one in known[1]]
        for run in dict.fromkeys(one.run for one in both):
            for kind, fold in zip(KINDS, known, strict=True):
                own = [float(np.nanmean(fold[one])) for one in both if one.run == run]
                squares[kind] += own
                runs[kind].append(math.sqrt(float(np.mean(own))))
    if not runs[NETWORK]:
        return None
    error_K = {kind: math.sqrt(float(np.mean(squares[kind]))) for kind in KINDS}
    return Comparison(error_K, {kind: tuple(runs[kind]) for kind in KINDS})


def _sure(count: int) -> float:
    """Student's t for so many numbers."""
    return float(stdtrit(max(count - 1, 1), 0.5 + SURE / 2.0))
