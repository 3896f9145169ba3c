"""What stands between a node and its reading: offset, gain, lag, drift."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from gen.arrays import FloatArray
from gen.model.network_parts import AMBIENT
from gen.refinement.network.changing.writer import NetworkWriter
from gen.refinement.network.effects.base import Added, Motor, NetworkEffect, Number, Seen
from gen.refinement.network.effects.offered import Offered

SHORTEST_H, LONGEST_H = 0.5, 24.0
"""Time constants of drifts: one that is over within minutes is an offset, one of days goes straight on."""
NO_MORE = "no more than any sensor may be off by"


class SensorEffect(NetworkEffect):
    """One number at one sensor."""

    least = 0.0
    """What is no more than a good sensor may do."""

    def __init__(self, motor: Motor, sensor: int) -> None:
        self.component = motor.names[sensor]
        self._sensor = sensor

    def doubts(self, values: Sequence[float]) -> list[str]:
        """Small errors of sensors beside another effect explain nothing."""
        return [] if abs(values[0]) >= self.least else [NO_MORE]

    def _of(self, values: FloatArray) -> FloatArray:
        return np.asarray(values[:, self._sensor])

    def _times(self, number: float, unit: FloatArray) -> tuple[Added]:
        return (Added(self._sensor, number * unit, (unit,)),)

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:
        """Write nothing: it is a matter of the sensor, not of the motor."""


class SensorOffset(SensorEffect):
    """A constant."""

    name = "sensor_offset"
    numbers = (Number("offset_K", 0.0, 0.0, 3.0, -50.0, 50.0),)
    least = 0.3

    def read(self, seen: Seen, values: FloatArray) -> tuple[Added]:  # noqa: D102
        return self._times(values[0], np.ones_like(seen.hours))

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        entry.sensor(self.component, offset_K=values[0])


class AmbientOffset(NetworkEffect):
    """The ambient's sensor reads a constant too much: so all others read as much too little, of a motor in that room.

    What goes with temperatures rather than with their differences (a law of a path, heat that grows) is as it would be
    in the room that was read: by less than a hundredth of it for a kelvin.
    """

    name = SensorOffset.name
    component = AMBIENT
    numbers = SensorOffset.numbers
    title = "the ambient's sensor reads too much or too little"
    least = 0.5
    note = "a matter of the room's sensor, or of where it hangs: in the file it is an offset of all others"

    def __init__(self, motor: Motor) -> None:
        self._names = motor.names[: motor.sensed]

    def read(self, seen: Seen, values: FloatArray) -> tuple[Added, ...]:  # noqa: D102
        unit = -np.ones_like(seen.hours)
        return tuple(Added(sensor, values[0] * unit, (unit,)) for sensor in range(len(self._names)))

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        return [] if abs(values[0]) >= self.least else [NO_MORE]

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        for name in self._names:
            entry.sensor(name, offset_K=-values[0])


class WarmedThermometer(NetworkEffect):
    """The ambient's sensor shows some of a part's rise, and a constant, too much: it hangs too near to the motor.

    The ambient is then less than it was told by as much, and in balance every part is. What a part lags behind that is
    left out: the rise that is shown moves no faster than the parts.
    """

    name = "sensor_gain"
    component = AMBIENT
    title = "the ambient's sensor is warmed by the motor"
    of_the_motor = False
    numbers = (Number("share_of_the_rise", 0.0, 0.0, 0.1, 0.0, 0.6), Number("offset_K", 0.0, 0.0, 3.0, -50.0, 50.0))
    least = 0.01

    def __init__(self, motor: Motor, sensor: int) -> None:
        self._names, self._sensor = motor.names[: motor.sensed], sensor
        self.acts_by = {"of": motor.names[sensor]}

    def read(self, seen: Seen, values: FloatArray) -> tuple[Added, ...]:  # noqa: D102
        rise, unit = seen.temperature[:, self._sensor] - seen.ambient, np.ones_like(seen.hours)
        shown = values[0] * rise + values[1] * unit
        return tuple(Added(sensor, -shown, (-rise, -unit)) for sensor in range(len(self._names)))

    def by_temperature(self, values: FloatArray) -> tuple[tuple[int, int, float], ...]:  # noqa: D102
        return tuple((sensor, self._sensor, -float(values[0])) for sensor in range(len(self._names)))

    def doubts(self, values: Sequence[float]) -> list[str]:  # noqa: D102
        return [] if values[0] >= self.least else [NO_MORE]

    def change(self, values: Sequence[float]) -> str:  # noqa: D102
        return (
            f"the ambient's sensor shows {values[0]:.1%} of the rise of {self.acts_by['of']}, and {values[1]:+.1f} K, "
            "too much: it hangs too near to the motor, or is warmed by it; hang it elsewhere, and log anew"
        )

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:
        """Write nothing: no file holds an ambient sensor that the motor warms."""


class SensorGain(SensorEffect):
    """A share: of the rise over the ambient, as of a sensor that has come half off; or of degC, as of an amplifier."""

    name = "sensor_gain"
    numbers = (Number("gain_error", 0.0, 0.0, 0.3, -0.6, 1.0),)
    least = 0.01

    def __init__(self, motor: Motor, sensor: int, *, of_rise: bool) -> None:
        super().__init__(motor, sensor)
        self._of_rise = of_rise
        self.acts_by = {"of": "rise" if of_rise else "degC"}

    def read(self, seen: Seen, values: FloatArray) -> tuple[Added]:  # noqa: D102
        return self._times(values[0], self._of(seen.temperature) - (seen.ambient if self._of_rise else 0.0))

    def by_temperature(self, values: FloatArray) -> tuple[tuple[int, int, float], ...]:  # noqa: D102
        return ((self._sensor, self._sensor, float(values[0])),)

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
    """Kelvin an hour since the run began, which levels off: r tau (1 - exp(-t / tau)).

    A file holds tau of up to `LONGEST_H`, which over a run looks like a straight line.
    """

    name = "drift"
    note = (
        "a matter of the sensor: the file takes it off from each start on, as it was in these runs; better mend the "
        "sensor, and take drift_K and drift_h out of the file"
    )
    numbers = (
        Number("drift_K_per_h", 0.0, 0.0, 3.0, -20.0, 20.0),
        # What is more than the longest says nothing else, so no physical limit is there.
        Number("settles_h", 4.0, float(np.log(4.0)), 1.0, SHORTEST_H, 1e3, log=True),
    )
    least = 0.05

    def read(self, seen: Seen, values: FloatArray) -> tuple[Added]:  # noqa: D102
        rate, settles = float(values[0]), self.numbers[1].value(float(values[1]))
        held = min(settles, LONGEST_H)
        left = np.exp(-seen.hours / held)
        unit = held * (1.0 - left)
        by_settles = np.zeros_like(unit) if settles > held else rate * (unit - seen.hours * left)
        return (Added(self._sensor, rate * unit, (unit, by_settles)),)

    def write(self, entry: NetworkWriter, values: Sequence[float]) -> None:  # noqa: D102
        entry.drift(self.component, values[0], min(values[1], LONGEST_H))


def offered(motor: Motor, data: Offered) -> Iterator[NetworkEffect]:
    """Each at each sensor; and that of the ambient, which has its part in all of them."""
    if data.room_measured and motor.sensed > 1:
        yield AmbientOffset(motor)
        for sensor in range(motor.sensed):
            yield WarmedThermometer(motor, sensor)
    for sensor in range(motor.sensed):
        for kind in (SensorOffset, SensorLag, Drift):
            yield kind(motor, sensor)
        for of_rise in (True, False):
            yield SensorGain(motor, sensor, of_rise=of_rise)
