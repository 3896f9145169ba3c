"""What a cheap logger makes of temperatures: lag, bias, noise, steps of a quarter of a kelvin, gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

FloatArray = NDArray[np.float64]
QUANTUM_K = 0.25


@dataclass(frozen=True)
class Sensor:
    """A thermocouple with its amplifier.

    Parameters
    ----------
    noise, bias
        Standard deviation and constant error, K.
    lag
        Time constant, s.
    gaps
        Expected number of gaps in an hour.
    """

    noise: float
    bias: float
    lag: float
    gaps: float

    def read(self, rng: np.random.Generator, true: FloatArray, row_s: float) -> FloatArray:
        """Readings of a temperature in degC at rows `row_s` apart; NaN in a gap. The first is always there."""
        seen = true
        if self.lag > 0.0:
            keep = float(np.exp(-row_s / self.lag))
            seen = lfilter([1.0 - keep], [1.0, -keep], true, zi=[keep * true[0]])[0]
        read = np.round((seen + self.bias + rng.normal(0.0, self.noise, true.size)) / QUANTUM_K) * QUANTUM_K
        for _ in range(rng.poisson(self.gaps * true.size * row_s / 3600.0)):
            first = int(rng.integers(1, true.size))
            read[first : first + int(rng.uniform(10.0, 600.0) / row_s)] = np.nan
        return np.asarray(read, dtype=np.float64)


def random_sensor(rng: np.random.Generator) -> Sensor:
    """Draw a sensor."""
    return Sensor(
        noise=float(rng.uniform(0.05, 0.35)),
        bias=float(rng.uniform(-0.3, 0.3)),
        lag=float(rng.choice([0.0, rng.uniform(0.0, 15.0)])),
        gaps=float(rng.choice([0.0, 0.3])),
    )
