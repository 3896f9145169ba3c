"""What a residual correlates with: asked of what no effect explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gen.refinement.condense import Condensed
from gen.refinement.parts.candidates import Tracing

_CLASSES = 8


@dataclass(frozen=True)
class Remains:
    """What is left at one component.

    Parameters
    ----------
    rms_K, noise_K
        Of the bins' means left by the final model on left-out runs, and of single samples' noise.
    shares
        Quantity -> share of the remaining variance that its classes explain, largest first.
    """

    rms_K: float
    noise_K: float
    shares: dict[str, float]

    def summary(self) -> dict[str, object]:
        """For the JSON summary."""
        return {"rms_K": self.rms_K, "noise_K": self.noise_K, "share_of_variance": self.shares}


def leftover(tracing: Tracing, runs: Sequence[Condensed], name: str) -> Remains:
    """Correlation ratios of what is left with time, speed, temperature, its slope, each channel and the run."""
    fit = tracing.final[name]
    c = tracing.problem.components.index(name)
    weight = tracing.problem.weight[:, c, 0, :]
    left = fit.error[:, 0, :]
    quantities: dict[str, list[np.ndarray]] = {}
    errors = []
    for r, run in enumerate(runs):
        if name not in run.traces:
            continue
        size = run.edges.size - 1
        good = weight[:size, r] > 0
        errors.append(left[:size, r][good])
        base = run.traces[name].base
        own = {
            "time": run.edges[1:] - run.edges[0],
            "speed": run.pwm,
            "temperature": 0.5 * (base[1:] + base[:-1]),
            "slope of temperature": np.diff(base) / np.diff(run.edges),
            "direction": run.reverse,
            "run": np.full(size, float(r)),
            **{key: values for key, values in run.channels.items() if all(key in other.channels for other in runs)},
        }
        for key, values in own.items():
            quantities.setdefault(key, []).append(values[good])
    error = np.concatenate(errors)
    shares = {key: _ratio(np.concatenate(values), error) for key, values in quantities.items()}
    ordered = dict(sorted(shares.items(), key=lambda item: -item[1]))
    return Remains(float(np.sqrt(fit.loss[0])), float(tracing.problem.noise_K[c]), ordered)


def _ratio(values: np.ndarray, error: np.ndarray) -> float:
    """Share of the variance between classes of equal size (eta squared), less what chance gives."""
    distinct = np.unique(values)
    if distinct.size < 2 or error.size < 4 * _CLASSES:
        return 0.0
    if distinct.size <= 2 * _CLASSES:
        index = np.searchsorted(distinct, values)
    else:
        index = np.searchsorted(np.quantile(values, np.linspace(0, 1, _CLASSES + 1)[1:-1]), values)
    count = np.bincount(index)
    mean = np.bincount(index, error) / np.maximum(count, 1)
    total = float(np.sum((error - error.mean()) ** 2))
    between = float(np.sum(count * (mean - error.mean()) ** 2))
    return max(0.0, between / total) if total > 0.0 else 0.0
