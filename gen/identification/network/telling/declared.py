"""What the coefficient file declares the model to be off by: what was left out tells, and what the runs do not."""

from __future__ import annotations

import math

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients.network_curves import six_digits
from gen.coefficients.provenance import ErrorBand
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.identify import NetworkFound
from gen.identification.network.telling.forecast import Band, bands, widened
from gen.identification.network.telling.foresight import Foresight, foresight
from gen.identification.network.telling.uncertainty import Spread

TWICE = 2.0
"""Standard deviations by which a declared error is widened."""
ANOTHER_RUN_K, ANOTHER_RUN = 0.2, 0.01
"""By which the same motor differs from one run to the next, in another room, from another start, on another day:
standard deviation in K, and as a share of what a part moves by. What is left out of several runs holds it already."""


def error_bands(result: NetworkFound, spread: Spread, turning: tuple[int, int]) -> list[ErrorBand]:
    """Give the declared errors, by part and range of |PWM|.

    Parameters
    ----------
    result, spread
        What was identified, and how sure it is.
    turning
        Lowest and highest |PWM| at which it turned.
    """
    full_scale = result.data.full_scale
    ahead = foresight(result.found, spread, turning, full_scale)
    own = widened(
        bands(result.inputs, result.judged, full_scale), result.found.problem.inputs, result.residual, full_scale
    )
    another = TWICE * _another_run_K(result.inputs)
    made = []
    for s, name in enumerate(result.data.names):
        for band in own:
            if math.isfinite(band.low[s]):
                made.append(_error_band(name, s, band, ahead, float(another[s])))
        if not any(band.pwm == (0, 0) and math.isfinite(band.low[s]) for band in own):
            unknown = TWICE * float(ahead.within(0, 0)[s])
            made.append(
                ErrorBand(
                    component=name,
                    pwm=(0, 0),
                    model_minus_measured_K=(six_digits(-unknown), six_digits(unknown)),
                    note="no run rests: what is not known of the cooling at rest",
                )
            )
    return made


def _another_run_K(inputs: Inputs) -> FloatArray:
    """What stretches of one run say nothing of, standard deviation by part, shape (S,), K; 0 where there are more."""
    if len(inputs.runs) > 1:
        return np.zeros(inputs.covered.shape[1])
    read = np.where(inputs.covered > 0.0, inputs.target, np.nan)
    moved = np.nanmax(read, axis=0) - np.nanmin(read, axis=0)
    return np.asarray(np.hypot(ANOTHER_RUN_K, ANOTHER_RUN * moved))


def _error_band(name: str, s: int, band: Band, ahead: Foresight, another_K: float) -> ErrorBand:
    unknown = TWICE * float(ahead.within(*band.pwm)[s]) + another_K
    low, high = min(float(band.low[s]), 0.0), max(float(band.high[s]), 0.0)
    beside = f", {another_K:.2f} K of it for another run than the one that there is" if another_K else ""
    return ErrorBand(
        component=name,
        pwm=band.pwm,
        model_minus_measured_K=(six_digits(low - unknown), six_digits(high + unknown)),
        note=f"on data left out and in its own runs: {band.low[s]:+.2f}..{band.high[s]:+.2f} K in means over a 60th of "
        f"a run, {band.rms[s]:.2f} K rms on the former; widened by {unknown:.2f} K for what the runs do not determine "
        f"on other profiles{beside}",
    )
