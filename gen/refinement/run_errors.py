"""Errors of a model on run files, row by row, in a free run from the start of each log.

Of a log that is thinned when it is read they are the errors of the rows kept.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.refinement.condense import free_run
from gen.refinement.thinning import Samples, held, measured
from gen.runs import Run


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
    """A run as the report draws it.

    Parameters
    ----------
    start_s, span_s
        Time of the first row, and from there to the last one.
    pwm
        In counts, signed, held until the next sample.
    measured, model
        Temperatures by component, degC.
    error
        Measured minus model, K, at rows spread evenly.
    left_out
        What was left out of the run's file before, as a sentence.
    """

    start_s: float
    span_s: float
    pwm: Samples
    measured: dict[str, Samples] = field(default_factory=dict)
    model: dict[str, Samples] = field(default_factory=dict)
    error: dict[str, Samples] = field(default_factory=dict)
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
        Of each series of the curve that is given back.
    """
    return compared(*free_run(baseline, model, path), most_points)


def compared(run: Run, shown: dict[str, FloatArray], most_points: int = 600) -> tuple[dict[str, Score], Curve]:
    """Compare what a model shows with what was measured.

    Parameters
    ----------
    run
        The run.
    shown
        By measured component, degC, at the run's rows.
    most_points
        Of each series of the curve that is given back.
    """
    time_s = run.time_s
    pwm = held(time_s, run.pwm.astype(np.float64)).thinned(most_points)
    curve = Curve(float(time_s[0]), float(time_s[-1] - time_s[0]), pwm, left_out=run.left_out)
    scores = {}
    for name, values in shown.items():
        error = run.temps[name] - values
        curve.measured[name] = measured(time_s, run.temps[name]).thinned(most_points)
        curve.model[name] = measured(time_s, values).thinned(most_points)
        known = np.flatnonzero(np.isfinite(error))
        rows = known[np.unique(np.linspace(0, known.size - 1, most_points).astype(int))]
        curve.error[name] = Samples(time_s[rows], error[rows])
        error = error[known]
        scores[name] = Score(float(np.sum(error**2)), error.size, float(np.max(np.abs(error), initial=0.0)))
    return scores, curve
