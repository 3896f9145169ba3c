"""Errors of a model on run files, row by row, in a free run from the start of each log.

Of a log that is thinned when it is read they are the errors of the rows kept.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gen.coefficients import Coefficients
from gen.refinement.condense import free_run
from gen.runs.run import FloatArray


@dataclass(frozen=True)
class Score:
    """Error of one component in one run.

    Parameters
    ----------
    square_sum, samples
        Squared error, K^2, summed over the samples, and their number.
    max_abs_K
        Largest error, K.
    """

    square_sum: float
    samples: int
    max_abs_K: float

    @property
    def rmse_K(self) -> float:
        """Root mean square error, K."""
        return float(np.sqrt(self.square_sum / max(self.samples, 1)))

    def summary(self) -> dict[str, float]:
        """As the JSON summary has it."""
        return {"rmse_K": self.rmse_K, "max_abs_K": self.max_abs_K}


def total(scores: Iterable[Score]) -> Score:
    """All samples together."""
    every = list(scores)
    return Score(
        sum(s.square_sum for s in every), sum(s.samples for s in every), max((s.max_abs_K for s in every), default=0.0)
    )


@dataclass(frozen=True)
class Curve:
    """Thinned time series for the report, and what was left out of the run's file before, as a sentence."""

    time_s: FloatArray
    pwm: FloatArray
    measured: dict[str, FloatArray] = field(default_factory=dict)
    model: dict[str, FloatArray] = field(default_factory=dict)
    left_out: str = ""


def run_errors(
    baseline: Coefficients, model: Coefficients, path: Path, most_points: int = 600
) -> tuple[dict[str, Score], Curve]:
    """Simulate a run and compare.

    Parameters
    ----------
    baseline
        Its file says what the columns are.
    model
        The model to judge; it starts from the same measured temperatures as the baseline.
    path
        The run file.
    most_points
        Of the curve that is given back.
    """
    run, shown = free_run(baseline, model, path)
    scores = {}
    thin = np.unique(np.linspace(0, run.time_s.size - 1, most_points).astype(int))
    curve = Curve(run.time_s[thin], run.pwm[thin].astype(np.float64), left_out=run.thinned)
    for name, values in shown.items():
        error = run.temps[name] - values
        error = error[np.isfinite(error)]
        scores[name] = Score(float(np.sum(error**2)), error.size, float(np.max(np.abs(error), initial=0.0)))
        curve.measured[name] = run.temps[name][thin]
        curve.model[name] = values[thin]
    return scores, curve
