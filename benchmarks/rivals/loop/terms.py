"""Residuals of runs against the model that they were planted on, and terms by the names of effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gen.coefficients import Coefficients
from gen.reference.simulate import simulate_run
from gen.runs import Run, read_run

FloatArray = NDArray[np.float64]
BLOCK_S = 60.0
KELVIN = 273.15
ROOM_DEGC = 30.0
SETTLING = ("own", "own x drive", "drive")
"""Terms of the model itself, which are no effect."""


@dataclass(frozen=True)
class Course:
    """One part in one run, in means over `BLOCK_S`.

    Attributes
    ----------
    residual
        Measured less modelled, K, shape (n,).
    names
        Of the terms: `SETTLING`, then those by the names of effects.
    terms
        Shape (n, terms): what acts on the residual's rate, each of the order of 1.
    """

    residual: FloatArray
    names: tuple[str, ...]
    terms: FloatArray


def courses(coefficients: Coefficients, paths: Sequence[Path]) -> dict[str, list[Course]]:
    """By component, its course in each run."""
    found: dict[str, list[Course]] = {name: [] for name in coefficients.model.component_names}
    for path in paths:
        run = read_run(path)
        shown = simulate_run(coefficients, run, "exact", "auto", path.name)
        index = ((run.time_s - run.time_s[0]) // BLOCK_S).astype(np.int64)
        model = {name: _means(np.asarray(shown[f"{name}_degC"], dtype=np.float64), index) for name in found}
        for name in found:
            found[name].append(_course(run, index, name, model))
    return found


def _course(run: Run, index: NDArray[np.int64], name: str, model: dict[str, FloatArray]) -> Course:
    measured = {part: _means(run.temps[part], index) for part in model}
    own = measured[name] - ROOM_DEGC
    residual = measured[name] - model[name]
    drive = _means(np.abs(run.pwm) / 255.0, index)
    extra = {column: _means(values, index) for column, values in run.extras.items()}
    hot, cold = measured[name] + KELVIN, ROOM_DEGC + KELVIN
    columns = {
        "own": residual / 10.0,
        "own x drive": residual / 10.0 * drive,
        "drive": drive,
        "load_heating": (extra["current_A"] / 5.0) ** 2,
        "airflow": own / 30.0 * extra["fan_contact"],
        "radiation": (hot**4 - cold**4) / 4e9,
        "standstill_cooling": own / 30.0 * (drive == 0.0),
        "temperature_dependent_loss": own / 30.0 * drive,
        "supply_voltage": ((extra["voltage_V"] / 24.0) ** 2 - 1.0) * 5.0 * drive,
        "direction": _means((run.pwm < 0) * 1.0, index) * drive,
    }
    columns |= {f"coupling {other}": (measured[other] - measured[name]) / 10.0 for other in model if other != name}
    return Course(residual, tuple(columns), np.column_stack(list(columns.values())))


def _means(values: NDArray[np.floating], index: NDArray[np.int64]) -> FloatArray:
    good = np.isfinite(values)
    total = np.bincount(index[good], values[good], index[-1] + 1)
    return np.asarray(total / np.maximum(np.bincount(index[good], minlength=index[-1] + 1), 1), dtype=np.float64)
