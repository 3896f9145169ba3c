"""Whether runs are missed by no more than the file declares to be off by: then what is left need be no fault."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.coefficients.provenance import ERROR_WINDOWS
from gen.runs import Run

FEWEST = 3
"""Readings that a mean is of."""
NEARLY_ALL = 0.95
"""Of the means that a declared error holds: it is one of 95 %."""


@dataclass(frozen=True)
class Held:
    """How many means are within what a file declares, of how many."""

    inside: int = 0
    of: int = 0

    def __add__(self, other: Held) -> Held:
        """Count both."""
        return Held(self.inside + other.inside, self.of + other.of)

    @property
    def sentence(self) -> str:
        """That the declared error holds, or nothing: too many means are beyond it, or it says nothing of them."""
        if not self.of or self.inside < NEARLY_ALL * self.of:
            return ""
        return (
            f"what the file declares to be off by holds in these runs ({self.inside} of {self.of} means over a "
            f"{ERROR_WINDOWS}th of a run): what is missed may be the model's own error, or a room that is not the same "
            "all over, and no fault"
        )


def held(model: Coefficients, run: Run, shown: Mapping[str, FloatArray]) -> Held:
    """Hold a run against what its model's file declares.

    Parameters
    ----------
    model
        The file.
    run
        What was measured.
    shown
        What the file gives, by component, degC, at the run's rows.
    """
    provenance = model.document.provenance
    bands = provenance.error if provenance is not None else ()
    time, speed = run.time_s, np.abs(run.pwm)
    window = np.floor((time - time[0]) / max(float(time[-1] - time[0]), 1e-9) * ERROR_WINDOWS)
    # Where PWM changes a new mean begins.
    starts = np.flatnonzero((np.diff(window) != 0.0) | (np.diff(speed) != 0)) + 1
    counted = Held()
    for name, values in shown.items():
        own = [band for band in bands if band.component == name]
        error = values - run.temps[name]
        for first, last in pairwise([0, *starts.tolist(), time.size]):
            known = error[first:last][np.isfinite(error[first:last])]
            band = next((each for each in own if each.pwm[0] <= speed[first] <= each.pwm[1]), None)
            if band is not None and known.size >= FEWEST:
                low, high = band.model_minus_measured_K
                counted += Held(int(low <= float(known.mean()) <= high), 1)
    return counted
