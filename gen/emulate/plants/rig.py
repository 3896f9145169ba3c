"""The simulated motor (`gen.rig`) as the board's plant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import get_args

import numpy as np

from gen.emulate.plants.plant import AMBIENT, STEP_S, Reading
from gen.errors import InputError
from gen.rig import NODES, Encoder, Fault, Motor, MotorConfig, SensorConfig, SensorFault, Thermocouple
from gen.rig.chips import Converter
from gen.rig.config import FaultKind
from gen.rig.signals import Signal, value

_COLUMN = "_degC"
TOLD = ("airflow_m_s", "voltage_V")
"""What surrounds the motor beside ambient and load, by the columns that hold it."""

RATED_Nm = 1.0
"""The MY1016's nameplate, at 13.5 A."""

_FAULTS: tuple[FaultKind, ...] = get_args(FaultKind)


def kind_of(text: str) -> FaultKind:
    """Read a fault of the simulated motor.

    Raises
    ------
    InputError
        When it has no such fault.
    """
    kind = next((known for known in _FAULTS if known == text), None)
    if kind is None:
        raise InputError(
            f'found "{text}", expected {" or ".join(_FAULTS)}, which the simulated motor has; heats and paths are a '
            "coefficient file's (--plant model)",
            place="--fault",
        )
    return kind


def has_parts(channels: Iterable[str]) -> bool:
    """Whether the simulated motor has a part for each of these thermocouples."""
    return {name.removesuffix(_COLUMN) for name in channels} <= {*NODES, AMBIENT}


class RigPlant:
    """A simulated motor, its thermocouples and its encoder, on the board's clock.

    The board's plant runs for one step before the board gets power (see `gen.emulate.board.Board`), so that times given
    here, which are the board's, lie one step later for the motor.

    Parameters
    ----------
    channels
        The thermocouples that are wired: nodes of the motor, ``ambient``, or a node's column (``brush_degC``) that
        the model does not have as a component.
    motor
        The motor; its faults' times are the board's.
    sensors
        By channel; what is missing is the plain sensor.
    sensor_faults
        By channel.
    converters
        By channel; what is missing is a MAX6675.
    start_degC
        True temperatures at the start by node; the rest start at ambient.
    ambient_degC, load_Nm, airflow_m_s, voltage_V
        Over time; without a voltage the supply is the nominal one.
    pulses_per_revolution
        Of the encoder; 0: none.
    seed
        Of the sensors' noise.

    Raises
    ------
    InputError
        When the motor has no such part.
    """

    def __init__(
        self,
        channels: Iterable[str],
        *,
        motor: MotorConfig | None = None,
        sensors: Mapping[str, SensorConfig] | None = None,
        sensor_faults: Mapping[str, tuple[SensorFault, ...]] | None = None,
        converters: Mapping[str, Converter] | None = None,
        start_degC: Mapping[str, float] | None = None,
        ambient_degC: Signal = 30.0,
        load_Nm: Signal = 0.0,
        airflow_m_s: Signal = 0.0,
        voltage_V: Signal | None = None,
        pulses_per_revolution: int = 0,
        seed: int = 0,
    ) -> None:
        config = motor or MotorConfig()
        config = replace(config, faults=tuple(_later(fault) for fault in config.faults))
        self.motor = Motor(config, start_degC=start_degC, ambient_degC=value(ambient_degC, 0.0))
        self._ambient, self._load, self._air = ambient_degC, load_Nm, airflow_m_s
        self._voltage = config.parameters.electrical.nominal_voltage_V if voltage_V is None else voltage_V
        self._encoder = Encoder(pulses_per_revolution) if pulses_per_revolution else None
        self._time = -STEP_S
        named = tuple(channels)
        known = (*self.motor.nodes, AMBIENT)
        for name in named:
            if name.removesuffix(_COLUMN) not in known:
                expected = ", ".join(known)
                raise InputError(
                    f'the simulated motor has no part "{name}"; it is the MY1016 and has {expected}; '
                    "--plant model makes the coefficient file its own plant",
                    place="$.wiring",
                )
        seeds = np.random.SeedSequence(seed).spawn(len(named))
        self._sensors = {
            name: Thermocouple(
                replace(
                    (sensors or {}).get(name.removesuffix(_COLUMN), SensorConfig()),
                    faults=(sensor_faults or {}).get(name, ()),
                    converter=(converters or {}).get(name, Converter()),
                ),
                own,
            )
            for name, own in zip(named, seeds, strict=True)
        }

    @property
    def temperatures(self) -> dict[str, float]:
        """True temperatures now, degC: the motor's nodes and ``ambient``."""
        return self.motor.temperatures | {AMBIENT: self.motor.ambient_degC}

    @property
    def typical_faults(self) -> tuple[str, ...]:
        """See `gen.emulate.plants.plant.Changeable.typical_faults`."""
        return _FAULTS

    @property
    def largest_load_Nm(self) -> float:
        """See `gen.emulate.plants.plant.Changeable.largest_load_Nm`: the nameplate's."""
        return RATED_Nm

    def set_load(self, Nm: float) -> None:
        """See `gen.emulate.plants.plant.Changeable.set_load`."""
        self._load = Nm

    def set_ambient(self, degC: float) -> None:
        """See `gen.emulate.plants.plant.Changeable.set_ambient`."""
        self._ambient = degC

    def set_faults(self, text: str) -> None:
        """See `Changeable.set_faults` of `plant`: ``bearing`` or ``brush``, both with a comma between them."""
        kinds = [kind_of(name.strip()) for name in text.split(",")] if text else []
        faults = tuple(Fault(kind, self.motor.time_s, 1.0) for kind in kinds)
        self.motor.config = replace(self.motor.config, faults=faults)

    def set_sensor_faults(self, channel: str, faults: tuple[SensorFault, ...]) -> None:
        """See `gen.emulate.plants.plant.Changeable.set_sensor_faults`."""
        sensor = self._sensors[channel]
        sensor.config = replace(sensor.config, faults=faults)

    def step(self, pwm: int, dt_s: float) -> Reading:
        """See `gen.emulate.plants.plant.Plant.step`."""
        before = self.motor.revolutions
        start = max(self._time, 0.0)
        air = value(self._air, start)
        drive = self.motor.step(
            pwm,
            dt_s,
            load_Nm=value(self._load, start),
            ambient_degC=value(self._ambient, start),
            voltage_V=value(self._voltage, start),
            airflow_m_s=air,
        )
        self._time += dt_s
        true = self.temperatures
        words = {
            name: sensor.read(true[name.removesuffix(_COLUMN)], self._time) for name, sensor in self._sensors.items()
        }
        pulses = self._encoder.between(before, self.motor.revolutions) if self._encoder is not None else 0
        channels = {"current_A": drive.current_A, "voltage_V": drive.voltage_V, "airflow_m_s": air}
        return Reading(words, pulses, channels)


def _later(fault: Fault) -> Fault:
    return replace(fault, start_s=fault.start_s + STEP_S)
