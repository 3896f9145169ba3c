"""What stands between a node and its reading: offset, gain, lag, drift."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.identification.network.fitting.bins import FloatArray
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import Motor, NetworkEffect, Number, Seen
from gen.refinement.network.effects.offered import Offered


class SensorEffect(NetworkEffect):
    """One number at one sensor."""

    least = 0.0
    """What is no more than a good sensor may do."""

    def __init__(self, motor: Motor, sensor: int) -> None:
        self.component = motor.names[sensor]
        self._sensor = sensor

    def doubts(self, values: Sequence[float]) -> list[str]:
        """Small errors of sensors beside another effect explain nothing."""
        return [] if abs(values[0]) >= self.least else ["no more than any sensor may be off by"]

    def _of(self, values: FloatArray) -> FloatArray:
        return np.asarray(values[:, self._sensor])

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:
        """Write nothing: it is a matter of the sensor, not of the motor."""


class SensorOffset(SensorEffect):
    """A constant."""

    name = "sensor_offset"
    numbers = (Number("offset_K", 0.0, 0.0, 3.0, -50.0, 50.0),)
    least = 0.3

    def read(self, seen: Seen) -> tuple[int, FloatArray]:  # noqa: D102
        return self._sensor, np.ones_like(seen.hours)

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        entry.sensor(self.component, offset_K=values[0])


class SensorGain(SensorEffect):
    """A share: of the rise over the ambient, as of a sensor that has come half off; or of degC, as of an amplifier."""

    name = "sensor_gain"
    numbers = (Number("gain_error", 0.0, 0.0, 0.3, -0.6, 1.0),)
    least = 0.01

    def __init__(self, motor: Motor, sensor: int, *, of_rise: bool) -> None:
        super().__init__(motor, sensor)
        self._of_rise = of_rise
        self.acts_by = {"of": "rise" if of_rise else "degC"}

    def read(self, seen: Seen) -> tuple[int, FloatArray]:  # noqa: D102
        return self._sensor, self._of(seen.temperature) - (seen.ambient if self._of_rise else 0.0)

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        entry.wrong_gain(self.component, values[0], "ambient" if self._of_rise else "zero_degC")


class SensorLag(SensorEffect):
    """A time constant with which readings follow (`gen.refinement.network.changing.lagged`)."""

    name = "sensor_lag"
    numbers = (Number("lag_s", 0.0, 0.0, 600.0, 0.0, 3600.0),)
    least = 30.0  # a bead in a drop of paste follows within seconds, a taped one within half a minute

    def __init__(self, motor: Motor, sensor: int) -> None:
        super().__init__(motor, sensor)
        self.lagging = sensor

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        entry.sensor(self.component, lag_s=max(values[0], 0.0))


class Drift(SensorEffect):
    """Kelvin an hour since the run began."""

    name = "drift"
    numbers = (Number("drift_K_per_h", 0.0, 0.0, 3.0, -50.0, 50.0),)
    held_by_the_file = False
    least = 0.05

    def read(self, seen: Seen) -> tuple[int, FloatArray]:  # noqa: D102
        return self._sensor, seen.hours


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Each at each sensor."""
    for sensor in range(motor.sensed):
        for kind in (SensorOffset, SensorLag, Drift):
            yield kind(motor, sensor)
        for of_rise in (True, False):
            yield SensorGain(motor, sensor, of_rise=of_rise)
