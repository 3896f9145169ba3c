"""The firmware's judgement without the firmware: model and alarm rules in the reference, many motors at once.

What the references decide is what the board decides, word for word (`gen verify` proves it); the twin does in a minute
for forty runs what the emulated board does in an hour. It takes every sample of the sensors as believed, so that it
serves where no sensor fails.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.emulate.plants.plant import AMBIENT, Plant, Reading
from gen.lowering.alarms import COLD_mK, lower_alarms
from gen.lowering.effects.program import Channel
from gen.lowering.kinds import Arithmetic, ScheduleKind
from gen.lowering.lower import lower
from gen.lowering.program import Program
from gen.lowering.sensors import COUNT_mK, SensorLimits, sensor_limits
from gen.reference.alarms import ReferenceAlarms
from gen.reference.board import reference_of
from gen.reference.chips import decoded
from gen.rig import Profile


def alarm_times(
    coefficients: Coefficients,
    plants: Sequence[Plant],
    pwm: Sequence[int | Profile],
    duration_s: float,
    *,
    arithmetic: Arithmetic = "fixed",
    schedule: ScheduleKind = "table",
    progress: Callable[[float], None] = lambda _: None,
) -> FloatArray:
    """Run a board for each plant, with a PWM or a profile each, from the measured temperatures at the start.

    Parameters
    ----------
    coefficients
        Model and rules.
    plants
        One for each run.
    pwm
        One for each run; acts from the start on.
    duration_s
        Of every run, s.
    arithmetic, schedule
        The board's.
    progress
        Called with the simulated time, s.

    Returns
    -------
    NDArray
        Time of each rule's first alarm, s, NaN where there was none; shape (runs, rules).

    Raises
    ------
    ValueError
        If a component or the ambient has no thermocouple.
    """
    program = lower(coefficients, arithmetic, schedule)
    names = program.model.component_names
    rules = lower_alarms(coefficients)
    step_s = program.model.sample_time
    profiles = [Profile((0.0,), (item,), duration_s) if isinstance(item, int) else item for item in pwm]
    valid = np.full(len(plants), (1 << len(names)) - 1, dtype=np.int64)
    readings = [plant.step(0, step_s) for plant in plants]
    bare = {name for reading in readings for name in (*names, AMBIENT) if name not in reading.words}
    if bare:
        raise ValueError(f"no thermocouple on {', '.join(sorted(bare))}, and the twin takes every sample as believed")
    limits = {item.channel: item for item in sensor_limits(coefficients)}
    measured, ambient = _read(readings, names, limits)
    starts = {name: (measured[i] - ambient).tolist() for i, name in enumerate(names)}
    model = reference_of(program, starts, _told(program, ambient, readings, limits))
    cold = np.all(np.abs(measured - ambient) <= COLD_mK, axis=0)
    alarms = ReferenceAlarms(rules, cold)
    first = np.full((len(plants), len(rules)), np.nan)
    bits = 1 << np.arange(len(rules))
    for sample in range(1, round(duration_s / step_s) + 1):
        command = np.array([profile.at((sample - 1) * step_s) for profile in profiles], dtype=np.int64)
        readings = [plant.step(int(value), step_s) for plant, value in zip(plants, command, strict=True)]
        measured, ambient = _read(readings, names, limits)
        told = _told(program, ambient, readings, limits)
        if told is not None:
            model.set_channels(told)
        model.step(command)
        alarms.step(command, measured, model.rises_mK + ambient, valid)
        fresh = ((alarms.latched[:, None] & bits) != 0) & np.isnan(first)
        first[fresh] = sample * step_s
        progress(sample * step_s)
    return first


def _read(
    readings: Sequence[Reading], names: Sequence[str], limits: Mapping[str, SensorLimits]
) -> tuple[IntArray, IntArray]:
    """Temperatures in thousandths of a degree, shape (components, L), and ambient's, shape (L,)."""
    table = [[_measured(reading, limits[name]) for reading in readings] for name in (*names, AMBIENT)]
    degrees = np.array(table, dtype=np.int64)
    return degrees[:-1], degrees[-1]


def _measured(reading: Reading, limits: SensorLimits) -> int:
    return decoded(limits, reading.words[limits.channel])[1] * COUNT_mK


def _told(
    program: Program, ambient: IntArray, readings: Sequence[Reading], limits: Mapping[str, SensorLimits]
) -> IntArray | None:
    """What the board is told, in thousandths, shape (channels, runs); what the plant lacks stays neutral."""
    if not program.channels:
        return None
    others = [[_value(reading, channel, limits) for reading in readings] for channel in program.channels[1:]]
    return np.array([ambient.tolist(), *others], dtype=np.int64)


def _value(reading: Reading, channel: Channel, limits: Mapping[str, SensorLimits]) -> int:
    if channel.column in limits and channel.column in reading.words:
        return _measured(reading, limits[channel.column])
    return round(reading.channels.get(channel.column, channel.neutral / 1000.0) * 1000.0)
