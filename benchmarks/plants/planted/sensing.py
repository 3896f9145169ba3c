"""Changes of the sensors: mounted anew, with another amplifier, or ageing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.plants.planted.change import Change

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class SensorChange(Change):
    """Something of one sensor.

    Parameters
    ----------
    node
        Whose.
    """

    node: int

    def seen(self, node: int, true: FloatArray, time: FloatArray, ambient: FloatArray) -> FloatArray:  # noqa: D102
        return self.of_it(true, time, ambient) if node == self.node else true

    def of_it(self, true: FloatArray, time: FloatArray, ambient: FloatArray) -> FloatArray:
        """What this sensor is at."""
        return true


@dataclass(frozen=True)
class SensorOffset(SensorChange):
    """It reads so much too high, K."""

    offset: float

    def of_it(self, true: FloatArray, time: FloatArray, ambient: FloatArray) -> FloatArray:  # noqa: D102
        return np.asarray(true + self.offset)


@dataclass(frozen=True)
class SensorGain(SensorChange):
    """Its amplifier has another gain, or it sits with one side in the air.

    Parameters
    ----------
    gain
        By which it reads too high, as a share.
    of_rise
        Of the part's rise over the room (a bad contact), else of degrees Celsius (an amplifier).
    """

    gain: float
    of_rise: bool

    def of_it(self, true: FloatArray, time: FloatArray, ambient: FloatArray) -> FloatArray:  # noqa: D102
        return np.asarray(true + self.gain * (true - (ambient if self.of_rise else 0.0)))


@dataclass(frozen=True)
class SensorLag(SensorChange):
    """It sits on a pad that warms late.

    Parameters
    ----------
    lag
        Time constant, s.
    """

    lag: float

    def of_it(self, true: FloatArray, time: FloatArray, ambient: FloatArray) -> FloatArray:  # noqa: D102
        keep = float(np.exp(-(time[1] - time[0]) / self.lag))
        behind: FloatArray = lfilter([1.0 - keep], [1.0, -keep], true, zi=[keep * true[0]])[0]
        return behind


@dataclass(frozen=True)
class Drift(SensorChange):
    """Its amplifier warms: it is off by more and more while a run lasts.

    Parameters
    ----------
    rate
        At the start, K/h.
    settles
        Time constant with which it ends, h; none where it goes on.
    """

    rate: float
    settles: float | None

    def of_it(self, true: FloatArray, time: FloatArray, ambient: FloatArray) -> FloatArray:  # noqa: D102
        hours = time / 3600.0
        if self.settles is not None:
            hours = self.settles * (1.0 - np.exp(-hours / self.settles))
        return np.asarray(true + self.rate * hours)
