"""A healthy motor's deviations from its model, as an alarm rule would see them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.lowering.alarms import COLD_mK, start_wait
from gen.lowering.heat import block_samples
from gen.reference.heat_blocks import Blocks, blocks_of
from gen.reference.sampled import sampled
from gen.reference.simulate import simulate_run
from gen.runs import Run

MEAN_S = 60.0
"""Deviations are means over so long: the converter's noise is no deviation, and rules have a persistence."""
SETTLE_S = 600.0
"""What lies so soon after a change of PWM is left out, as by a rule with this ``settle_s``."""
LEAST_OF_USUAL = 0.5
"""Of the readings that a mean usually has: what has fewer is none."""
COLD_K = COLD_mK / 1000.0
"""A run that starts within so much of ambient starts cold, as on the board."""


@dataclass(frozen=True, eq=False)
class HealthyRun:
    """One run beside its model.

    Attributes
    ----------
    name
        The run's file.
    pwm
        |PWM| of each mean, shape (n,).
    deviation_K
        Measured minus model by component, shape (n,); NaN where the rule would sleep or nothing was measured.
    hottest_rise_K
        Highest measured rise over ambient by component.
    cold
        Whether every part started at the ambient.
    blocks
        Of all components, for rules on missing heat; None for a difference of two.
    """

    name: str
    pwm: IntArray
    deviation_K: dict[str, FloatArray]
    hottest_rise_K: dict[str, float]
    cold: bool = False
    blocks: Blocks | None = None


def compare(coefficients: Coefficients, run: Run, name: str) -> HealthyRun:
    """Hold a run against the exact solution of its model.

    Parameters
    ----------
    coefficients
        The model.
    run
        Measured on the healthy motor; starts from its first measured temperatures.
    name
        The run's file, for messages.

    Raises
    ------
    InputError
        If no ambient is known, or no part of the model was measured.
    """
    model = coefficients.model
    if not any(np.isfinite(run.temps[part]).any() for part in model.component_names if part in run.temps):
        expected = ", ".join(f"{part}_degC" for part in model.component_names)
        raise InputError(f"no component's temperature was measured; expected {expected}", file=name)
    shown = simulate_run(coefficients, run, "exact", "auto", name)
    magnitude = np.abs(run.pwm)
    since = _since_change(run.time_s, magnitude)
    window = np.floor(run.time_s / MEAN_S).astype(np.int64)
    begins = np.flatnonzero((np.diff(window, prepend=window[0] - 1) != 0) | (np.diff(magnitude, prepend=-1) != 0))
    cold = all(
        abs(shown[f"{part}_degC"][0] - _ambient(coefficients, run)[0]) <= COLD_K
        for part in model.component_names
        if part in run.temps
    )
    low, high = model.validity
    deviations, hottest = {}, {}
    for component in model.component_names:
        measured = run.temps.get(component)
        if measured is None:
            continue
        wait = 0.0 if cold else start_wait(model, component, range(max(low, 1), high + 1)) * model.sample_time
        seen = (since >= SETTLE_S) & (run.time_s - run.time_s[0] >= wait)
        deviations[component] = _means(measured - shown[f"{component}_degC"], begins, seen)
        hottest[component] = float(np.nanmax(measured - _ambient(coefficients, run), initial=0.0))
    given = sampled(model, run, {part: shown[f"{part}_degC"].astype(np.float64) for part in model.component_names})
    blocks = blocks_of(
        block_samples(model.sample_time),
        range(len(model.component_names)),
        given.pwm,
        given.measured_mC - given.model_mC,
        given.valid,
    )
    return HealthyRun(name, magnitude[begins].astype(np.int64), deviations, hottest, cold, blocks)


def differences(runs: Iterable[HealthyRun], component: str, other: str) -> list[HealthyRun]:
    """The runs with the difference of two components' deviations in the first one's place."""
    return [
        HealthyRun(run.name, run.pwm, {component: run.deviation_K[component] - run.deviation_K[other]}, {})
        for run in runs
        if component in run.deviation_K and other in run.deviation_K
    ]


def _ambient(coefficients: Coefficients, run: Run) -> FloatArray:
    fixed = coefficients.model.ambient_fixed
    if run.ambient is not None and not np.all(np.isnan(run.ambient)):
        known = ~np.isnan(run.ambient)
        return np.interp(run.time_s, run.time_s[known], run.ambient[known])
    return np.full(len(run.time_s), np.nan if fixed is None else fixed)


def _since_change(time_s: FloatArray, magnitude: IntArray) -> FloatArray:
    """Time for which |PWM| has been what it is, s."""
    changed = np.flatnonzero(np.diff(magnitude, prepend=-1) != 0)
    return time_s - time_s[changed[np.searchsorted(changed, np.arange(len(time_s)), side="right") - 1]]


def _means(values: FloatArray, begins: IntArray, seen: BoolArray) -> FloatArray:
    """Means over the windows of what was read, shape (windows,).

    NaN for one in which the rule sleeps in any row, or with less than half of the usual number of readings.

    Parameters
    ----------
    values
        NaN where nothing was read, shape (N,).
    begins
        First row of each window.
    seen
        Rows in which the rule does not sleep, shape (N,).
    """
    read = np.isfinite(values)
    counts = np.add.reduceat(read.astype(np.int64), begins)
    usual = float(np.median(counts[counts > 0])) if read.any() else 0.0
    sums = np.add.reduceat(np.where(read, values, 0.0), begins)
    awake = np.logical_and.reduceat(seen, begins)
    enough = awake & (counts > 0) & (counts >= LEAST_OF_USUAL * usual)
    return np.where(enough, sums / np.maximum(counts, 1), np.nan)
