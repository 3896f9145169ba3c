"""Residuals of a free run: what the sensors measured minus what the model says, from the start of each log.

A run is condensed when it is read: slow signals become means over bins, so that hours at 4 Hz cost little. The model is
solved at every row of the run first, and only the difference is averaged: a change of PWM costs no accuracy.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.errors import InputError
from gen.identification.logs.believed import believed_run
from gen.model.dynamics import PWM_LEVELS, ThermalModel
from gen.model.exact import ExactSolution
from gen.model.extended import FINEST_S, ExtendedSolution, own_rate
from gen.replay import Inputs, ambient_column, check_inputs, check_meaning, inputs_of, read_for
from gen.runs import Run, check_run, noted_in
from gen.runs.run import board_columns

BINS = 240
"""Aimed at for a run of some time constants."""

MOST_ROWS = 100_000
"""A run of more than twice as many rows is thinned to about as many: they say all that the bins can hold."""
LONGEST_BIN_S = 60.0
FEWEST_ROWS = 8
START_WINDOW_S = 60.0
"""The start of the free run is the first measured temperature, its noise averaged over this time."""


@dataclass(frozen=True)
class Trace:
    """One component's condensed residual and drive in one run; K bins.

    Parameters
    ----------
    residual
        Measured minus baseline, mean of each bin, K; NaN where nothing was measured, shape (K,).
    noise_K, resolution_K
        Standard deviation of single samples about their bin's trend, and the step of the readings.
    base
        The baseline's rise at the ends of the bins, K, shape (K + 1,).
    fading
        What is left of 1 K at the start, by the own rate (K + 1).
    rate, heat
        The component's own rate (1/s) and the baseline's heating (K/s), mean of each bin.
    start_rise
        Measured rise at the start, K.
    """

    residual: FloatArray
    noise_K: float
    resolution_K: float
    base: FloatArray
    fading: FloatArray
    rate: FloatArray
    heat: FloatArray
    start_rise: float


@dataclass(frozen=True)
class Condensed:
    """One run as the tracing sees it; K bins.

    Parameters
    ----------
    name
        The run's file name as the user gave it.
    edges
        Times of the bins' ends, s, shape (K + 1,).
    weight
        Samples in each bin.
    pwm, reverse, standstill
        Mean |PWM| in counts, share of time with PWM < 0 and with PWM = 0.
    ambient, measured_ambient
        At the bins' ends, degC.
    channels
        Extra channels, mean of each bin.
    traces
        By component.
    comments
        The run file's.
    left_out
        What was left out of the file, as a sentence; empty for nothing.
    """

    name: str
    edges: FloatArray
    weight: FloatArray
    pwm: FloatArray
    reverse: FloatArray
    standstill: FloatArray
    ambient: FloatArray
    measured_ambient: FloatArray | None
    channels: dict[str, FloatArray]
    traces: dict[str, Trace]
    comments: Mapping[str, str]
    left_out: str = ""


def condense(coefficients: Coefficients, path: Path) -> Condensed:
    """Read a run, solve the baseline along it and keep bins only.

    Raises
    ------
    InputError
        When the file is not a run, holds no temperature of any component, or lacks a column that the model needs.
    """
    run = read_measured(coefficients, path)
    return _condensed(coefficients, run, str(path))


def check_apart(fit_paths: Sequence[Path], test_paths: Sequence[Path]) -> None:
    """Check that no test run takes part in a fit.

    Raises
    ------
    InputError
        With the first file that is in both, by the name under which it was given as a test run.
    """
    fitted = {path.resolve() for path in fit_paths}
    for path in test_paths:
        if path.resolve() in fitted:
            raise InputError("is given as --fit and as --test; test runs must take no part", file=str(path))


def check_measured(coefficients: Coefficients, path: Path) -> None:
    """Find out whether a run could be judged, and learn nothing else of it: none of its values is kept.

    Raises
    ------
    InputError
        When the file is not a run, is too short, or lacks a column that the model needs.
    """
    model = coefficients.model
    found = check_run(path)
    check_meaning(coefficients, found.comments, str(path))
    _check_measured(model, found.filled, found.rows, str(path))
    # As `read_for` has it: a comment stands for a column where the file has no fixed ambient.
    said = model.ambient_fixed is None and noted_in(found.comments, str(path)) is not None
    ambient = said or ambient_column(coefficients) in found.filled
    check_inputs(coefficients, found.filled - board_columns(found.filled), ambient, str(path))


def _check_measured(model: ThermalModel, filled: Collection[str], rows: int, file: str) -> None:
    expected = [f"{name}_degC" for name in model.component_names]
    if not any(column in filled for column in expected):
        raise InputError(f"no component's temperature was measured; expected {', '.join(expected)}", file=file)
    if rows < FEWEST_ROWS:
        raise InputError(f"found {rows} rows, expected at least {FEWEST_ROWS}", file=file)


def read_measured(coefficients: Coefficients, path: Path) -> Run:
    """Read a run and keep the components that were measured in it, without readings that none can have shown.

    Raises
    ------
    InputError
        When the file is not a run, is too short, or holds no temperature of any component.
    """
    return measured_in(coefficients, read_for(coefficients, path, most_rows=MOST_ROWS), str(path))


def measured_in(coefficients: Coefficients, run: Run, name: str) -> Run:
    """Keep the components that were measured in a run, without readings that none can have shown.

    Raises
    ------
    InputError
        When the run is too short, or holds no temperature of any component; `name` says which run.
    """
    run = believed_run(run, _rates(coefficients))
    measured = {name: values for name, values in run.temps.items() if np.any(np.isfinite(values))}
    _check_measured(coefficients.model, {f"{part}_degC" for part in measured}, run.time_s.size, name)
    own = board_columns([*(f"{part}_degC" for part in run.temps), *run.extras])
    extras = {column: values for column, values in run.extras.items() if column not in own}
    return replace(run, temps=measured, extras=extras)


def _rates(coefficients: Coefficients) -> dict[str, float]:
    """What the file says of each thermocouple's part: it cannot change faster, K/s."""
    wiring = coefficients.document.wiring
    return {} if wiring is None else {one.channel: one.max_rate_K_per_s for one in wiring.thermocouples}


def free_run(baseline: Coefficients, model: Coefficients, path: Path) -> tuple[Run, dict[str, FloatArray]]:
    """Simulate a model, with its effects, along a run.

    Parameters
    ----------
    baseline
        Says from which temperatures a run starts.
    model
        What to simulate.
    path
        The run file.

    Returns
    -------
    run, shown
        The run with its measured components, and what their sensors would show, degC.
    """
    run = read_measured(baseline, path)
    of_baseline = inputs_of(baseline, run, str(path))
    first, _ = _solved(baseline, run, of_baseline)
    inputs = inputs_of(model, run, str(path))
    own, sensed = inputs.ambient, inputs.measured_ambient
    smooth = own if sensed is None else _smooth(sensed, run.time_s)
    if model.model.ambient_channel is not None and sensed is not None:
        own = smooth
    start = {name: value + float(of_baseline.ambient[0] - own[0]) for name, value in first.items()}
    # Without a measured ambient an effect that brings it does nothing, as on the board.
    check_inputs(model, inputs.channels, True, str(path))
    # The effects' states are integrated in steps of 1 s: over a month this would be more steps than rows were kept.
    finest = max(FINEST_S, float(run.time_s[-1] - run.time_s[0]) / (4 * MOST_ROWS))
    shown = ExtendedSolution(model.model, model.effects, finest).simulate_times(
        run.time_s, run.pwm, own, smooth, inputs.channels, start
    )
    return run, {name: shown[name] for name in run.temps}


def _condensed(coefficients: Coefficients, run: Run, name: str) -> Condensed:
    model = coefficients.model
    time, measured = run.time_s, run.temps
    inputs = inputs_of(coefficients, run, name)
    ambient, sensed = inputs.ambient, inputs.measured_ambient
    check_inputs(coefficients, inputs.channels, sensed is not None, name)
    start_rise, base = _solved(coefficients, run, inputs)
    index, edges = _bins(time, run.pwm)
    count = edges.size - 1
    step = np.diff(time)
    at = index[:-1]
    length = np.bincount(at, step, count)
    length = np.where(length > 0.0, length, 1.0)

    def held(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(at, values[:-1] * step, count) / length)

    counts = np.abs(run.pwm)
    traces = {}
    for component in model.components:
        if component.name not in measured:
            continue
        rate = own_rate(component)
        heat = rate * component.steady_rise(np.arange(PWM_LEVELS))
        residual = measured[component.name] - ambient - base[component.name]
        means, noise = _binned(residual, time, index, count)
        traces[component.name] = Trace(
            residual=means,
            noise_K=noise,
            resolution_K=_resolution(measured[component.name]),
            base=np.interp(edges, time, base[component.name]),
            fading=np.exp(-np.concatenate([[0.0], np.cumsum(held(rate[counts]) * np.diff(edges))])),
            rate=held(rate[counts]),
            heat=held(heat[counts]),
            start_rise=start_rise[component.name],
        )
    return Condensed(
        name=name,
        edges=edges,
        weight=np.bincount(index, minlength=count).astype(np.float64),
        pwm=held(counts.astype(np.float64)),
        reverse=held((run.pwm < 0).astype(np.float64)),
        standstill=held((run.pwm == 0).astype(np.float64)),
        ambient=np.interp(edges, time, ambient),
        measured_ambient=None if sensed is None else np.interp(edges, time, _smooth(sensed, time)),
        channels={key: held(values) for key, values in inputs.channels.items()},
        traces=traces,
        comments=run.comments,
        left_out=run.left_out,
    )


def _solved(coefficients: Coefficients, run: Run, inputs: Inputs) -> tuple[dict[str, float], dict[str, FloatArray]]:
    """Start and baseline: the first measured temperature, its noise averaged over the first minute."""
    first = dict(inputs.first_rise)
    span = min(START_WINDOW_S, 0.01 * float(run.time_s[-1] - run.time_s[0]))
    window = max(int(np.searchsorted(run.time_s, run.time_s[0] + span, side="right")), 1)
    solution = ExactSolution(coefficients.model)
    if window > 2:
        early = solution.over_ambient(run.time_s[:window], run.pwm[:window], inputs.ambient[:window], first)
        for name in first:
            off = (run.temps[name] - inputs.ambient)[:window] - early[name]
            if np.any(np.isfinite(off)):
                first[name] += float(np.nanmean(off))
    return first, solution.over_ambient(run.time_s, run.pwm, inputs.ambient, first)


def _bins(time: FloatArray, pwm: IntArray) -> tuple[IntArray, FloatArray]:
    """Bin of each row, and the bins' ends; every bin holds a row, so a long gap is one bin.

    Where PWM is held for long, a change begins a bin.
    """
    span = float(time[-1] - time[0])
    typical = float(np.median(np.diff(time)))
    width = max(min(span / BINS, LONGEST_BIN_S), typical)
    raw = np.floor((time - time[0]) / width).astype(np.int64)
    changed = np.diff(pwm, prepend=pwm[0]) != 0
    if np.count_nonzero(changed) <= BINS // 4:
        raw = raw + np.cumsum(changed)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(raw)) + 1])
    index = np.cumsum(np.diff(raw, prepend=raw[0]) > 0)
    if starts[-1] == time.size - 1 and starts.size > 1:  # the last row alone ends the bin before it
        starts = starts[:-1]
        index[-1] = index[-2]
    return index, np.concatenate([time[starts], time[-1:]])


def _binned(residual: FloatArray, time: FloatArray, index: IntArray, count: int) -> tuple[FloatArray, float]:
    """Means, and the scatter about each bin's own straight line."""
    good = np.isfinite(residual)
    r, t, i = residual[good], time[good], index[good]
    n = np.bincount(i, minlength=count).astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(i, r, count) / n
        centre = np.bincount(i, t, count) / n
        dt, dr = t - centre[i], r - mean[i]
        stt = np.bincount(i, dt * dt, count)
        slope = np.where(stt > 0.0, np.bincount(i, dt * dr, count) / np.where(stt > 0.0, stt, 1.0), 0.0)
    left = dr - slope[i] * dt
    enough = n >= 5.0
    freedom = float(np.sum(n[enough] - 2.0))
    if freedom >= 20.0:
        noise = float(np.sqrt(np.sum((left * left)[enough[i]]) / freedom))
    elif r.size >= 6:
        noise = float(np.std(np.diff(r, 3)) / np.sqrt(20.0))
    else:
        noise = 0.0
    return mean, noise


def _resolution(values: FloatArray) -> float:
    """Step of the readings: the smallest distance between different ones, 0 if they are as good as continuous."""
    distinct = np.unique(values[np.isfinite(values)])
    if distinct.size < 2:
        return 0.0
    step = float(np.min(np.diff(distinct)))
    return step if step > 0.02 else 0.0


def _smooth(values: FloatArray, time: FloatArray) -> FloatArray:
    """Mean over two minutes: a room changes slowly, its sensor's noise does not matter."""
    half = round(60.0 / max(float(np.median(np.diff(time))), 1e-6))
    if half == 0 or values.size <= 2 * half + 1:
        return values
    total = np.concatenate([[0.0], np.cumsum(values)])
    low = np.clip(np.arange(values.size) - half, 0, values.size)
    high = np.clip(np.arange(values.size) + half + 1, 0, values.size)
    return np.asarray((total[high] - total[low]) / (high - low))
