"""Whether a network settles where a file with transfer functions does: else the motor is another, or the file wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.coefficients import Coefficients
from gen.identification.network.telling.summary import INTERVAL, Summary

LEAST_K = 1.0
"""By which two thermocouples on one part may differ, K."""
SHARE = 0.05
"""Of a rise, where a file does not declare by how much it is off."""


@dataclass(frozen=True)
class Elsewhere:
    """A part that a network has settle elsewhere than a file with transfer functions.

    Attributes
    ----------
    part
        Which.
    pwm
        The |PWM| at which the two are furthest apart, counts.
    network_K, file_K
        Its reading over the ambient there once it has settled; by the file, the nearest that its error allows.
    """

    part: str
    pwm: int
    network_K: float
    file_K: float

    @property
    def sentence(self) -> str:
        """What is otherwise."""
        by = self.network_K - self.file_K
        way = "warmer" if by > 0.0 else "colder"
        allowed = (
            f"at PWM {self.pwm} than the file and its error allow ({self.network_K:.3g} K, not {self.file_K:.3g} K)"
        )
        return f"{self.part} settles {abs(by):.2g} K {way} {allowed}"


def elsewhere(baseline: Coefficients, summary: Summary) -> list[Elsewhere]:
    """Compare where parts settle at the speeds that the runs held.

    Parameters
    ----------
    baseline
        The file with transfer functions.
    summary
        Of the network that was identified from later runs of the motor.

    Returns
    -------
    list of Elsewhere
        For each part that is off by more than both are unsure of, where it is off by most: the file by the error that
        it declares there, the network by its 95 % interval.
    """
    found, steady = summary.result.found, summary.steady
    parts = {part.name: part for part in baseline.model.components}
    made = []
    for s, name in enumerate(found.structure.sensed):
        offset = float(found.vector[found.structure.offsets[s]])
        told: list[tuple[float, Elsewhere]] = []
        for k, pwm in enumerate(summary.speeds):
            own = float(steady.rise[k, s]) + offset
            file = float(parts[name].steady_rise([pwm])[0])
            unsure = LEAST_K + INTERVAL * float(steady.deviation[k, s])
            low, high = _declared(baseline, name, pwm) or (-SHARE * abs(file), SHARE * abs(file))
            allowed = float(np.clip(own, file - high, file - low))
            beyond = abs(own - allowed) - unsure
            if beyond > 0.0:
                told.append((beyond, Elsewhere(name, pwm, own, allowed)))
        if told:
            made.append(max(told, key=lambda one: one[0])[1])
    return made


def _declared(baseline: Coefficients, part: str, pwm: int) -> tuple[float, float] | None:
    """By how much the file says that it is above a reading at a PWM, from .. to, K; None where it says nothing."""
    provenance = baseline.document.provenance
    bands = [] if provenance is None else [band for band in provenance.error if band.component == part]
    own = [band.model_minus_measured_K for band in bands if band.pwm[0] <= pwm <= band.pwm[1]]
    return (min(low for low, _ in own), max(high for _, high in own)) if own else None
