"""A small motor as a coefficient file, and runs of it or of what has become of it, from the exact solution."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients, parse
from gen.model.network_solution import NetworkSolution
from gen.runs import Run

Tree = dict[str, Any]
ROW_S, HOURS = 4.0, 4.0
NOISE_K = 0.1

TREE: Tree = {
    "format": "gen-coefficients",
    "version": 2,
    "name": "small",
    "sample_time_s": 0.25,
    "input": {"name": "pwm", "full_scale": 255, "nominal_speed_rpm": 2650},
    "ambient": {"fixed_degC": 25, "channel": "ambient_degC"},
    "validity": {"pwm": [0, 255], "outside": "extrapolate"},
    "domain": {"pwm": [0, 255], "ambient_degC": [-10, 50], "temperature_degC": [-10, 200]},
    "provenance": {"source": "a test", "fit": {n: {"left_out_rms_K": 0.1} for n in ("winding", "casing")}},
    "network": {
        "nodes": [
            {"name": "winding", "capacity_J_per_K": 120, "sensor": {}},
            {"name": "casing", "capacity_J_per_K": 400, "sensor": {}},
        ],
        "paths": [
            {"between": ["winding", "casing"], "conductance_W_per_K": {"poly": [0.5]}},
            {
                "between": ["casing", "ambient"],
                "conductance_W_per_K": {
                    "power": {"constant": 0.2, "forced": 0.3, "exponent": 0.8},
                    "at_rest": 0.18,
                },
            },
        ],
        "heats": [
            {"node": "winding", "power_W": {"poly": [0.00015, 0.01, 0.0]}},
            {"node": "casing", "power_W": {"poly": [0.015, 0.0]}},
        ],
    },
}


def tree() -> Tree:
    """A copy of the file, to be changed."""
    return copy.deepcopy(TREE)


def finned() -> Tree:
    """The motor with a part more, which has no sensor."""
    motor = tree()
    motor["network"]["nodes"].append({"name": "fins", "capacity_J_per_K": 300})
    motor["network"]["paths"] += [
        {"between": ["casing", "fins"], "conductance_W_per_K": {"poly": [0.25]}},
        {"between": ["fins", "ambient"], "conductance_W_per_K": {"poly": [0.1]}},
    ]
    return motor


def read(tree: Tree) -> Coefficients:
    """Check a file."""
    return parse(json.dumps(tree).encode())


def profile(seed: int) -> IntArray:
    """Holds of five minutes to forty, with stops and turns backwards."""
    chance = np.random.default_rng(seed)
    rows = int(HOURS * 3600.0 / ROW_S)
    pwm, at = np.zeros(rows, dtype=np.int64), 0
    while at < rows:
        length = int(chance.uniform(300.0, 2400.0) / ROW_S)
        level = int(chance.integers(50, 256)) * int(chance.choice([1, 1, -1]))
        pwm[at : at + length] = 0 if at and chance.random() < 0.25 else level
        at += length
    return pwm


def run(motor: Coefficients, seed: int, channels: dict[str, FloatArray] | None = None, noise_K: float = NOISE_K) -> Run:
    """One run of a motor in a room that swings.

    Parameters
    ----------
    motor
        What is run.
    seed
        Of the profile and the noise.
    channels
        What else is logged, and read by the motor where it has such a channel.
    noise_K
        Of readings.
    """
    pwm = profile(seed)
    time = ROW_S * np.arange(pwm.size, dtype=np.float64)
    room = 24.0 + 2.0 * np.sin(time / 3000.0 + seed)
    told = {**(channels or {}), "pwm": pwm.astype(np.float64)}
    known = [channel.column for channel in motor.model.network.channels] if motor.model.network else []
    temps = NetworkSolution(motor.model).simulate_times(
        time, pwm, room, {name: told[name] for name in known}, {n: float(room[0]) for n in motor.model.component_names}
    )
    chance = np.random.default_rng([seed, 1])
    read_as = {name: values + chance.normal(0.0, noise_K, values.size) for name, values in temps.items()}
    return Run(time, pwm, read_as, room, dict(channels or {}))


def wave(seed: int, low: float, high: float) -> FloatArray:
    """A channel that wanders between two values."""
    time = ROW_S * np.arange(int(HOURS * 3600.0 / ROW_S), dtype=np.float64)
    chance = np.random.default_rng([seed, 2])
    shape = np.sin(time / chance.uniform(500.0, 900.0) + chance.uniform(0.0, 6.0))
    return np.asarray(0.5 * (low + high) + 0.5 * (high - low) * shape)


def write(run: Run, path: Path) -> Path:
    """Write a run file."""
    import pandas as pd

    pd.DataFrame(run.columns()).to_csv(path, index=False, float_format="%.6g")
    return path
