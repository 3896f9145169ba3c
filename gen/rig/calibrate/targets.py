"""The published numbers that the motor is set to, from ``gen/rig/targets.json``."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
from scipy import signal

from gen.arrays import FloatArray
from gen.rig.parameters import MEASURED
from gen.rig.profiles import FULL_SCALE


@dataclass(frozen=True)
class FaultTarget:
    """Signature of one fault at steady state, K over the healthy motor, at `Targets.fault_speeds`."""

    brush: FloatArray
    casing_at_least: FloatArray


@dataclass(frozen=True)
class Targets:
    """What the calibration compares with.

    Attributes
    ----------
    speeds
        Fractions of the rated speed, shape (5,).
    ambient_degC, current_A_max
        Conditions of the experiment.
    end_degC
        Table 4.1 by component, shape (5,).
    time_s
        Grid of the step responses from cold, s, shape (T,).
    curves
        Step responses of the Table 4.3 transfer functions by component, K, shape (5, T).
    fault_speeds
        Fractions of the rated speed, shape (F,).
    faults
        By kind.
    """

    speeds: FloatArray
    ambient_degC: float
    current_A_max: float
    end_degC: dict[str, FloatArray]
    time_s: FloatArray
    curves: dict[str, FloatArray]
    fault_speeds: FloatArray
    faults: dict[str, FaultTarget]


@cache
def load() -> Targets:
    """Read the targets and compute the transfer functions' step responses."""
    data = json.loads((resources.files("gen.rig") / "targets.json").read_text(encoding="utf-8"))
    speeds = np.array(data["speed_percent"]) / 100.0
    time_s = np.arange(0.0, data["duration_s"] + 5.0, 10.0)
    curves = {
        name: np.array(
            [
                FULL_SCALE * speed * signal.step(([entry["numerator"]], entry["denominator"]), T=time_s)[1]
                for speed, entry in zip(speeds, data["table_4_3"][name], strict=True)
            ]
        )
        for name in MEASURED
    }
    faults = {
        kind: FaultTarget(
            brush=np.array(data["faults"][kind]["brush"], dtype=float),
            casing_at_least=np.array(data["faults"][kind]["casing_at_least"], dtype=float),
        )
        for kind in ("bearing", "brush")
    }
    return Targets(
        speeds=speeds,
        ambient_degC=data["ambient_degC"],
        current_A_max=data["no_load_current_A_max"],
        end_degC={name: np.array(data["table_4_1_degC"][name]) for name in MEASURED},
        time_s=time_s,
        curves=curves,
        fault_speeds=np.array(data["faults"]["speed_percent"]) / 100.0,
        faults=faults,
    )


def time_to_63(time_s: FloatArray, rise: FloatArray) -> float:
    """Time at which a step response has made 1 - 1/e of its way to its last value, s, between samples linearly."""
    level = -np.expm1(-1.0) * rise[-1]
    k = int(np.argmax(rise >= level))
    return float(time_s[k - 1] + (level - rise[k - 1]) / (rise[k] - rise[k - 1]) * (time_s[k] - time_s[k - 1]))
