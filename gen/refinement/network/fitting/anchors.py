"""What the file itself stands for, as runs: its own predictions at the speeds that it is valid for.

A model that was identified is known along what it was identified from, and not number by number: a capacity may be off
by a factor where a conductance makes up for it. Runs of the model itself, weighed by the errors that its file declares,
say that.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.model.network_solution import NetworkSolution
from gen.refinement.network.changing.freed import gains
from gen.runs import Run

SPEEDS = 5
ROW_S = 20.0
LONGEST_S, COOLING_S = 10800.0, 3600.0
USUAL_K = 0.5
"""Error of a file that declares none."""
LASTS_S = 900.0
"""For how long such errors last."""
USUAL_AMBIENT = 25.0


def anchors(coefficients: Coefficients) -> list[Run]:
    """Give runs of the model from cold: a speed each, then rest where the file is valid there."""
    model = coefficients.model
    validity = coefficients.document.validity.pwm
    low, high = max(validity[0], 1), validity[1]
    speeds = np.unique(np.rint(np.linspace(max(low, 0.15 * high), high, SPEEDS)).astype(np.int64))
    rests = validity[0] == 0
    ambient = model.ambient_fixed if model.ambient_fixed is not None else _usual_ambient(coefficients)
    solution = NetworkSolution(model)
    made = []
    for speed in speeds.tolist():
        driven = int(LONGEST_S / ROW_S)
        pwm = np.concatenate([np.full(driven, speed), np.zeros(int(COOLING_S / ROW_S) if rests else 0)]).astype(
            np.int64
        )
        time = ROW_S * np.arange(pwm.size, dtype=np.float64)
        temps = solution.simulate_times(time, pwm, ambient)
        made.append(Run(time, pwm, temps, np.full(time.size, ambient)))
    return made


def _usual_ambient(coefficients: Coefficients) -> float:
    """Of the runs that the file came from, degC, where it says so."""
    room = identified_ambient(coefficients)
    return USUAL_AMBIENT if room is None else float(np.mean(room))


def identified_ambient(coefficients: Coefficients) -> tuple[float, float] | None:
    """Give the lowest and the highest ambient of the runs that the file came from, degC, where it says so."""
    provenance = coefficients.document.provenance
    return None if provenance is None else provenance.ambient_degC


def declared_density(coefficients: Coefficients) -> FloatArray:
    """Give the density of the errors that the file declares, shape (sensed nodes,), K^2 s, as freed of wrong gains."""
    provenance = coefficients.document.provenance
    fit = provenance.fit if provenance is not None else {}
    names = coefficients.model.component_names
    off = [fit.get(name, {}).get("left_out_rms_K", USUAL_K) for name in names]
    assert coefficients.model.network is not None
    return np.asarray((np.maximum(np.array(off), 0.1) / gains(coefficients.model.network)) ** 2 * LASTS_S)
