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
"""Where nobody measured it."""
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
    runs = [courses_of(coefficients, read_run(path), path.name) for path in paths]
    return {name: [run[name] for run in runs] for name in coefficients.model.component_names}


def courses_of(coefficients: Coefficients, run: Run, file: str) -> dict[str, Course]:
    """By component, its course in one run."""
    shown = simulate_run(coefficients, run, "exact", "auto", file)
    index = ((run.time_s - run.time_s[0]) // BLOCK_S).astype(np.int64)
    names = coefficients.model.component_names
    model = {name: _means(np.asarray(shown[f"{name}_degC"], dtype=np.float64), index) for name in names}
    return {name: _course(run, index, name, model) for name in names}


def _course(run: Run, index: NDArray[np.int64], name: str, model: dict[str, FloatArray]) -> Course:
    measured = {part: _means(run.temps[part], index) for part in model}
    room = np.full_like(measured[name], ROOM_DEGC) if run.ambient is None else _means(run.ambient, index)
    own = measured[name] - room
    residual = measured[name] - model[name]
    drive = _means(np.abs(run.pwm) / 255.0, index)
    columns = {
        "own": residual / 10.0,
        "own x drive": residual / 10.0 * drive,
        "drive": drive,
        "radiation": ((measured[name] + KELVIN) ** 4 - (room + KELVIN) ** 4) / 4e9,
        "standstill_cooling": own / 30.0 * (drive == 0.0),
        "temperature_dependent_loss": own / 30.0 * drive,
        "direction": _means((run.pwm < 0) * 1.0, index) * drive,
    }
    for column, values in run.extras.items():
        columns |= _of_channel(column, _means(values, index), own, drive)
    columns |= {f"coupling {other}": (measured[other] - measured[name]) / 10.0 for other in model if other != name}
    return Course(residual, tuple(columns), np.column_stack(list(columns.values())))


def _of_channel(column: str, values: FloatArray, own: FloatArray, drive: FloatArray) -> dict[str, FloatArray]:
    """What whoever knows the meaning of a column would try with it."""
    match column:
        case "current_A":
            return {"load_heating": (values / 5.0) ** 2}
        case "fan_contact":
            return {"airflow": own / 30.0 * values}
        case "airflow_mps":
            return {"airflow": own / 30.0 * values / 3.0}
        case "voltage_V":
            return {"supply_voltage": ((values / 24.0) ** 2 - 1.0) * 5.0 * drive}
    return {}


def _means(values: NDArray[np.floating], index: NDArray[np.int64]) -> FloatArray:
    """Means over blocks; one in which nothing was read is taken from its neighbours."""
    good = np.isfinite(values)
    blocks = np.arange(index[-1] + 1)
    total = np.bincount(index[good], values[good], blocks.size)
    count = np.bincount(index[good], minlength=blocks.size)
    read = count > 0
    return np.asarray(np.interp(blocks, blocks[read], total[read] / count[read]), dtype=np.float64)
