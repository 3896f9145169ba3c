"""A run as the board would be given it: what the alarm rules see at each sample."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.lowering.alarms import COLD_mK
from gen.model import ThermalModel
from gen.runs import Run
from gen.runs.gaps import gaps

_ON_GRID = 1e-6
"""A row this close to a sample, in samples, counts as on it (decimal times are not exact in binary)."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """A run in samples.

    Attributes
    ----------
    time_s
        When each sample ends, s, shape (K,).
    pwm
        What acted over it, shape (K,).
    measured_mC, model_mC
        Temperatures at its end, shape (components, K), in thousandths of a degree Celsius.
    valid
        Bit masks of the components that were measured, shape (K,).
    trusted
        Whether the model starts with the right slopes: from cold.
    """

    time_s: FloatArray
    pwm: IntArray
    measured_mC: IntArray
    model_mC: IntArray
    valid: IntArray
    trusted: bool


def sampled(model: ThermalModel, run: Run, model_degC: Mapping[str, FloatArray]) -> Sampled:
    """Give a run in the board's samples.

    Between rows what was measured is held, and the model runs straight. In a gap nothing is measured.

    Parameters
    ----------
    model, run
        The model, and what was measured.
    model_degC
        The model's temperatures at the run's rows by component, shape (N,) each.
    """
    names, step_s = model.component_names, model.sample_time
    samples = int(np.floor((run.time_s[-1] - run.time_s[0]) / step_s + _ON_GRID))
    grid = run.time_s[0] + step_s * np.arange(1, samples + 1)
    row = np.searchsorted(run.time_s, grid + _ON_GRID * step_s, side="right") - 1
    acting = np.searchsorted(run.time_s, grid - (1.0 - _ON_GRID) * step_s, side="right") - 1
    measured, valid = _seen(run, names, row)
    shown_mC = np.array([np.rint(1000.0 * np.interp(grid, run.time_s, model_degC[name])) for name in names])
    return Sampled(grid, run.pwm[acting], measured, shown_mC.astype(np.int64), valid, _starts_cold(run, names))


def _held(values: FloatArray) -> FloatArray:
    """Each missing sample replaced by the latest before it; NaN before the first."""
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(values.size), -1))
    return np.where(last >= 0, values[last], np.nan)


def _seen(run: Run, names: Sequence[str], row: NDArray[np.intp]) -> tuple[IntArray, IntArray]:
    """What was measured at each sample: thousandths of a degree, shape (parts, K), and the bits of the valid."""
    measured = np.zeros((len(names), row.size), dtype=np.int64)
    valid = np.zeros(row.size, dtype=np.int64)
    for i, name in enumerate(names):
        values = run.temps.get(name)
        if values is None or not np.isfinite(values).any():
            continue
        held = _held(values)[row]
        there = np.isfinite(held) & ~_in_gap(run.time_s, values)[row]
        measured[i] = np.rint(1000.0 * np.nan_to_num(held)).astype(np.int64)
        valid |= there.astype(np.int64) << i
    return measured, valid


def _in_gap(time_s: FloatArray, values: FloatArray) -> BoolArray:
    """Rows that lie in a gap of a column; a value's own row does not."""
    known = np.flatnonzero(np.isfinite(values))
    after = gaps(time_s, values)
    latest = np.searchsorted(known, np.arange(values.size), side="right") - 1
    inside: BoolArray = np.where(latest >= 0, after[latest], True) & ~np.isfinite(values)
    return inside


def _starts_cold(run: Run, names: Sequence[str]) -> bool:
    """Whether every part starts within so much of the measured ambient that its slopes are known, as on the board."""
    if run.ambient is None or not np.isfinite(run.ambient).any():
        return False
    room = run.ambient[np.isfinite(run.ambient)][0]
    firsts = []
    for name in names:
        values = run.temps.get(name)
        if values is None or not np.isfinite(values).any():
            return False
        firsts.append(values[np.isfinite(values)][0])
    return bool(np.all(np.abs(np.array(firsts) - room) <= COLD_mK / 1000.0))
