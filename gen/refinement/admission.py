"""Which runs may teach the model: a fault must not be learnt into the healthy baseline.

The rule: a run is admitted to a refinement unless its own comments name a fault (``# fault: bearing``), or say that the
motor was not healthy (``# healthy: no``). Runs in which the file's alarm rules would be raised for a good part of their
speed window, while other runs at the same speeds are free of it, are admitted with a warning: an effect acts in every
run that excites it, a fault from one day on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, TypeVar

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.coefficients.alarms import Deviation, window_counts
from gen.coefficients.checks.alarm_checks import healthy_end_K
from gen.errors import InputError
from gen.refinement.condense import Condensed
from gen.runs.faults import called_unhealthy, declared_faults

_LEAST_K = 2.0
"""Rules closer to the model trip on the model's own error; they say nothing of a fault here. Those that count from the
healthy range (`"beyond": "error_band"`) have that error in them already."""
_FEWEST_BINS = 5


def admitted(coefficients: Coefficients, runs: Sequence[Condensed]) -> tuple[list[Condensed], list[str]]:
    """Apply the rule.

    Returns
    -------
    runs, warnings
        The admitted runs, and sentences for the user.

    Raises
    ------
    InputError
        If none is left.
    """
    named, warnings = healthy([(run.name, run) for run in runs])
    kept = [run for _, run in named]
    return kept, warnings + _signatures(coefficients, kept)


class Commented(Protocol):
    """A run with its file's comments."""

    @property
    def comments(self) -> Mapping[str, str]:
        """By key."""


AnyRun = TypeVar("AnyRun", bound=Commented)


def healthy(runs: Sequence[tuple[str, AnyRun]]) -> tuple[list[tuple[str, AnyRun]], list[str]]:
    """Leave out runs whose own comments name a fault.

    Parameters
    ----------
    runs
        By name.

    Returns
    -------
    runs, warnings
        What is left, and sentences for the user.

    Raises
    ------
    InputError
        If none is left.
    """
    kept, warnings = [], []
    for name, run in runs:
        declared = declared_faults(run.comments)
        if declared or called_unhealthy(run.comments):
            said = ", ".join(declared) or "healthy: no"
            warnings.append(f"{name}: left out, its comments name a fault ({said})")
        else:
            kept.append((name, run))
    if not kept:
        raise InputError("no run is left to fit: all of them name a fault in their comments", file=runs[0][0])
    return kept, warnings


def _signatures(coefficients: Coefficients, runs: Sequence[Condensed]) -> list[str]:
    warnings = []
    for rule in coefficients.document.alarms:
        banded = isinstance(rule, Deviation) and rule.beyond == "error_band"
        if not isinstance(rule, Deviation) or (rule.threshold_K < _LEAST_K and not banded):
            continue
        window = window_counts(rule, coefficients.document.input.full_scale)
        if not window:
            continue
        threshold = np.full(window[-1] + 1, rule.threshold_K)
        if banded:
            ends = healthy_end_K(coefficients.document, rule, window)
            threshold[list(ends)] += list(ends.values())
        every = {run.name: _share_beyond(rule, run, window, threshold) for run in runs}
        shares = {name: share for name, share in every.items() if share is not None}
        tripped = [name for name, share in shares.items() if share > 0.2]
        if not tripped:
            continue
        some = "in these runs only" if len(tripped) < len(shares) else "in every run at these speeds"
        side = "over" if rule.kind == "above_model" else "under"
        than = f", farther than {rule.relative_to}," if rule.relative_to is not None else ""
        beyond = " beyond the healthy range" if banded else ""
        warnings.append(
            f'the residual looks like the fault that the rule "{rule.name}" watches for ({rule.component} '
            f"{side} the model{than} by more than {rule.threshold_K:g} K{beyond}), {some}: "
            f"{', '.join(tripped)}; refine with runs of a motor known to be healthy only"
        )
    return warnings


def _share_beyond(rule: Deviation, run: Condensed, window: range, threshold: FloatArray) -> float | None:
    """Share of a run's bins within a rule's speeds that lie beyond its threshold (K by |PWM|); None where few tell."""
    own = run.traces.get(rule.component)
    other = run.traces.get(rule.relative_to) if rule.relative_to is not None else None
    if own is None or (rule.relative_to is not None and other is None):
        return None
    deviation = own.residual - (other.residual if other is not None else 0.0)
    inside = (run.pwm >= window[0]) & (run.pwm <= window[-1]) & np.isfinite(deviation)
    if np.count_nonzero(inside) < _FEWEST_BINS:
        return None
    off = deviation[inside] if rule.kind == "above_model" else -deviation[inside]
    return float(np.mean(off > threshold[np.rint(run.pwm[inside]).astype(np.int64)]))
