"""A coefficient file as the board's plant: the motor is what the file says, with the rig's sensors on it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from gen.coefficients import Coefficients
from gen.emulate.plants.courses import Course, NetworkCourse, PartsCourse, part_names
from gen.emulate.plants.effects_course import EffectsCourse
from gen.emulate.plants.model_faults import ModelFault, check_faults, parse_faults
from gen.emulate.plants.plant import AMBIENT, FULL_PWM, STEP_S, Ran, Reading
from gen.errors import InputError
from gen.model.effects.channel_ranges import channel_ranges
from gen.model.network_parts import PWM
from gen.rig import Encoder, SensorConfig, SensorFault, Thermocouple
from gen.rig.chips import Converter
from gen.rig.signals import Signal, value

_COLUMN = "_degC"
SPEED = "speed_rpm"


class ModelPlant:
    """A motor that is a coefficient file, its thermocouples and its encoder, on the board's clock.

    As the rig it runs for one step before the board gets power. A thermocouple shows what the file's own sensor of that
    part does, lag and offset with it, and adds its own errors. The shaft turns in proportion to PWM, at once.

    Parameters
    ----------
    coefficients
        The motor.
    channels
        The thermocouples that are wired: parts of the file, hidden nodes too, ``ambient``, or a column (``x_degC``)
        that is a part's or is told.
    faults
        Their times are the board's.
    sensors
        By channel; what is missing is a sensor without offset, noise or lag.
    sensor_faults
        By channel.
    converters
        By channel; what is missing is a MAX6675.
    start
        True temperatures at the start by part, degC, or what the motor has run before; what is not named is at ambient,
        a network's hidden nodes between their neighbours.
    ambient_degC
        Over time.
    told
        Channels over time by column, in the column's unit.
    wired
        Columns that the board reads, and their values while nobody tells them; those that this file reads stay at its
        own neutral values.
    pulses_per_revolution
        Of the encoder; 0: none.
    seed
        Of the sensors' noise.

    Raises
    ------
    InputError
        When the file has no such part, or lacks what a fault changes.
    """

    def __init__(
        self,
        coefficients: Coefficients,
        channels: Iterable[str],
        *,
        faults: Sequence[ModelFault] = (),
        sensors: Mapping[str, SensorConfig] | None = None,
        sensor_faults: Mapping[str, tuple[SensorFault, ...]] | None = None,
        converters: Mapping[str, Converter] | None = None,
        start: Mapping[str, float] | Ran | None = None,
        ambient_degC: Signal = 30.0,
        told: Mapping[str, Signal] | None = None,
        wired: Mapping[str, float] | None = None,
        pulses_per_revolution: int = 0,
        seed: int = 0,
    ) -> None:
        self._faults, self._ambient_over_time, self._told = tuple(faults), ambient_degC, dict(told or {})
        self._model = coefficients.model
        entry = coefficients.document.input
        self._rpm_of_full = entry.nominal_speed_rpm * FULL_PWM / entry.full_scale
        self._neutral = {**(wired or {}), **neutral_of(coefficients)}
        self._encoder = Encoder(pulses_per_revolution) if pulses_per_revolution else None
        self._revolutions, self._time = 0.0, -STEP_S
        self._ambient = value(ambient_degC, 0.0)
        named = tuple(channels)
        _check_channels(coefficients, named, self._told)
        known = start if start is not None and not isinstance(start, Ran) else {}
        self._course: Course = course_of(coefficients, self._faults, known, self._ambient)
        if isinstance(start, Ran):
            self._run_before(start)
        seeds = np.random.SeedSequence(seed).spawn(len(named))
        plain = SensorConfig(noise_K=0.0, lag_s=0.0)
        self._sensors = {
            name: Thermocouple(
                replace(
                    (sensors or {}).get(name, plain),
                    faults=(sensor_faults or {}).get(name, ()),
                    converter=(converters or {}).get(name, Converter()),
                ),
                own,
            )
            for name, own in zip(named, seeds, strict=True)
        }

    @property
    def temperatures(self) -> dict[str, float]:
        """True temperatures now, degC: the file's parts and ``ambient``."""
        return self._course.parts | {AMBIENT: self._ambient}

    @property
    def untold(self) -> dict[str, float]:
        """Columns that somebody reads and nobody tells, with the values at which they stay."""
        derived = (*self._told, PWM, SPEED)
        return {column: still for column, still in self._neutral.items() if column not in derived}

    @property
    def typical_faults(self) -> tuple[str, ...]:
        """See `gen.emulate.plants.plant.Changeable`: each heat half as large again, each path half as good."""
        network = self._model.network
        if network is None:
            return tuple(f"heat:{name}=+50%" for name in self._model.component_names)
        heated = dict.fromkeys(heat.node for heat in network.heats)
        paths = dict.fromkeys(f"path:{path.first}-{path.second or AMBIENT}=-50%" for path in network.paths)
        return (*(f"heat:{name}=+50%" for name in heated), *paths)

    @property
    def largest_load_Nm(self) -> float:
        """See `gen.emulate.plants.plant.Changeable.largest_load_Nm`: a coefficient file says nothing of torque."""
        return 0.0

    def set_load(self, Nm: float) -> None:
        """See `gen.emulate.plants.plant.Changeable.set_load`."""
        raise InputError("a coefficient file says nothing of torque; expected the simulated motor (--plant rig)")

    def set_ambient(self, degC: float) -> None:
        """See `gen.emulate.plants.plant.Changeable.set_ambient`."""
        self._ambient_over_time = degC

    def set_faults(self, text: str) -> None:
        """See `gen.emulate.plants.plant.Changeable.set_faults`; a fault with a time of its own waits for it."""
        faults = parse_faults(text, 0.0, 1.0) if text else ()
        check_faults(self._model, faults)
        self._faults = faults

    def set_sensor_faults(self, channel: str, faults: tuple[SensorFault, ...]) -> None:
        """See `gen.emulate.plants.plant.Changeable.set_sensor_faults`."""
        sensor = self._sensors[channel]
        sensor.config = replace(sensor.config, faults=faults)

    def step(self, pwm: int, dt_s: float) -> Reading:
        """See `gen.emulate.plants.plant.Plant.step`."""
        start = max(self._time, 0.0)
        self._ambient = value(self._ambient_over_time, start)
        told = self._channels(pwm, start)
        active = tuple(fault for fault in self._faults if self._time >= fault.start_s)
        self._course.step(pwm, dt_s, self._ambient, told, active)
        self._time += dt_s
        words = {name: sensor.read(self._shown(name, told), self._time) for name, sensor in self._sensors.items()}
        before = self._revolutions
        self._revolutions += abs(self._rpm(pwm)) / 60.0 * dt_s
        pulses = self._encoder.between(before, self._revolutions) if self._encoder is not None else 0
        return Reading(words, pulses, told)

    def _run_before(self, ran: Ran) -> None:
        """Warm the motor up as its scenario begins: faults that are there from the start have been there before."""
        told = self._channels(ran.pwm, 0.0)
        active = tuple(fault for fault in self._faults if fault.start_s <= 0.0)
        self._course.step(ran.pwm, ran.seconds, self._ambient, told, active)

    def _channels(self, pwm: int, time_s: float) -> dict[str, float]:
        """Value of every column that anybody reads."""
        given = {column: value(signal, time_s) for column, signal in self._told.items()}
        return {**self._neutral, PWM: float(pwm), SPEED: self._rpm(pwm), **given}

    def _rpm(self, pwm: int) -> float:
        return pwm / FULL_PWM * self._rpm_of_full

    def _shown(self, channel: str, told: Mapping[str, float]) -> float:
        if channel == AMBIENT:
            return self._ambient
        if channel in self._told:
            return told[channel]
        shown = self._course.shown
        return shown[channel] if channel in shown else shown[channel.removesuffix(_COLUMN)]


def course_of(
    coefficients: Coefficients, faults: Sequence[ModelFault], start_degC: Mapping[str, float], ambient: float
) -> Course:
    """Make the course of a file.

    Parameters
    ----------
    coefficients
        The motor.
    faults
        All that can become active.
    start_degC
        True temperatures at the start by part. Others are at the ambient, a network's hidden nodes between the others.
    ambient
        At the start, degC.

    Raises
    ------
    InputError
        If the file lacks what a fault changes.
    """
    check_faults(coefficients.model, faults)
    if coefficients.model.network is not None:
        return NetworkCourse(coefficients.model, coefficients.model.network, start_degC, ambient)
    if coefficients.effects:
        return EffectsCourse(coefficients, start_degC, ambient)
    return PartsCourse(coefficients.model, start_degC, ambient)


def neutral_of(coefficients: Coefficients) -> dict[str, float]:
    """Each column that a file reads, and its value until it is told."""
    model = coefficients.model
    if model.network is not None:
        return model.network.neutral()
    return {found.column: found.neutral for found in channel_ranges(model, coefficients.effects, {})[1:]}


def _check_channels(coefficients: Coefficients, channels: Sequence[str], told: Mapping[str, Signal]) -> None:
    parts = part_names(coefficients.model)
    for name in channels:
        if name not in (AMBIENT, *told) and not {name, name.removesuffix(_COLUMN)} & {*parts}:
            raise InputError(
                f'the plant, {coefficients.name}, has no part "{name.removesuffix(_COLUMN)}"; it has '
                f"{', '.join(parts)}; its temperature can be told: --channel {name}=DEGC",
                place="$.wiring",
            )
