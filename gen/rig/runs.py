"""Make run files: the motor driven by a profile, logged through its sensors; the truth is kept apart."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from gen.arrays import FloatArray
from gen.rig.config import MotorConfig
from gen.rig.motor import Motor
from gen.rig.parameters import AMBIENT, MEASURED
from gen.rig.profiles import Profile
from gen.rig.sensors import SensorConfig, Thermocouple, decode
from gen.rig.signals import Signal, value
from gen.runs import Run, write_columns, write_run

#: Extra channels that a run can carry.
CHANNELS = ("current_A", "voltage_V", "speed_rpm")

#: The study's sensors: accurate to 1.1 K.
SENSOR_TOLERANCE_K = 1.1


def sensors(
    seed: int,
    *,
    tolerance_K: float = SENSOR_TOLERANCE_K,
    noise_K: float = 0.1,
    lag_s: float = 2.0,
    names: Iterable[str] = (*MEASURED, AMBIENT),
) -> dict[str, SensorConfig]:
    """Draw a set of sensors, ambient's included, whose offsets are uniform within the tolerance."""
    random = np.random.default_rng(seed)
    return {
        name: SensorConfig(
            offset_K=float(random.uniform(-tolerance_K, tolerance_K)),
            noise_K=noise_K,
            lag_s=0.0 if name == AMBIENT else lag_s,
        )
        for name in names
    }


def zeroed(configs: Mapping[str, SensorConfig], room_degC: float, seed: int) -> dict[str, SensorConfig]:
    """Give the sensors as a board leaves them that has learnt their offsets in a room (`$.wiring.zero`).

    What remains are the noise and the steps of a minute's readings, and what all sensors are off by alike.

    Parameters
    ----------
    configs
        By column.
    room_degC
        What all parts, and the room, are as warm as, degC.
    seed
        Of the minute's noise.
    """
    seeds = np.random.SeedSequence(seed).spawn(len(configs))
    read = {
        name: float(np.mean([decode(sensor.read(room_degC, 0.25 * k)) for k in range(240)]))
        for (name, config), own in zip(configs.items(), seeds, strict=True)
        for sensor in [Thermocouple(config, own)]
    }
    middle = float(np.median([*read.values()]))
    return {
        name: replace(config, offset_K=config.offset_K - round(read[name] - middle, 2))
        for name, config in configs.items()
    }


@dataclass(frozen=True)
class Setup:
    """The motor on its test bench.

    Attributes
    ----------
    motor
        The motor.
    sensors
        By column: a node's name or ``ambient``; what is missing here is missing in the run.
    sample_s
        Interval of the rows, s.
    start_degC
        True temperatures at the start by node; the rest start at ambient.
    ambient, load_Nm, voltage_V, airflow_m_s
        Inputs over time; each is held from row to row.
    channels
        Which of `CHANNELS` to log.
    current_noise_A, voltage_noise_V
        Standard deviation of the meters' noise.
    decoys
        Further columns that have nothing to do with the motor.
    comments
        Comment lines that a log would carry.
    seed
        Of all noise.
    """

    motor: MotorConfig = field(default_factory=MotorConfig)
    sensors: Mapping[str, SensorConfig] = field(default_factory=lambda: sensors(0))
    sample_s: float = 1.0
    start_degC: Mapping[str, float] = field(default_factory=dict)
    ambient: Signal = 30.0
    load_Nm: Signal = 0.0
    voltage_V: Signal | None = None
    airflow_m_s: Signal = 0.0
    channels: tuple[str, ...] = CHANNELS
    current_noise_A: float = 0.02
    voltage_noise_V: float = 0.02
    decoys: Mapping[str, Signal] = field(default_factory=dict)
    comments: Mapping[str, str] = field(default_factory=dict)
    seed: int = 0

    def __post_init__(self) -> None:
        unknown = set(self.channels) - set(CHANNELS)
        if unknown:
            raise ValueError(f"unknown channel {sorted(unknown)[0]!r}; expected some of {CHANNELS}")
        if not self.sample_s > 0.0:
            raise ValueError(f"sample_s is {self.sample_s}; expected more than 0")
        strangers = set(self.sensors) - {*self.motor.nodes, AMBIENT}
        if strangers:
            raise ValueError(f"no node is called {sorted(strangers)[0]!r}; expected some of {self.motor.nodes}")


@dataclass(frozen=True)
class Truth:
    """What no log shows.

    Attributes
    ----------
    time_s
        Shape (N,).
    temperatures
        By node and ``ambient``, degC, shape (N,) each.
    load_Nm, airflow_m_s
        Shape (N,).
    motor
        The motor that ran.
    """

    time_s: FloatArray
    temperatures: dict[str, FloatArray]
    load_Nm: FloatArray
    airflow_m_s: FloatArray
    motor: MotorConfig

    def write(self, path: Path | str) -> None:
        """Write the columns beside the run, for a judge; nothing that identifies or refines a model may read them."""
        columns = {"time_s": self.time_s} | {f"{name}_degC": values for name, values in self.temperatures.items()}
        write_columns(path, columns | {"load_Nm": self.load_Nm, "airflow_m_s": self.airflow_m_s})


@dataclass(frozen=True)
class RigRun:
    """A run as logged, and the truth behind it."""

    run: Run
    truth: Truth

    def write(self, path: Path | str) -> None:
        """Write the run file, without the truth."""
        write_run(path, self.run)


def make_run(profile: Profile, setup: Setup | None = None) -> RigRun:
    """Drive the motor through a profile.

    Rows come every `Setup.sample_s` from 0 to the profile's end. As the run file's format wants it, a row's
    temperatures are those before its PWM has acted, and PWM is held to the next row. Speed and current are the drive's
    in the interval that ends with the row.

    Parameters
    ----------
    profile
        The commanded PWM.
    setup
        Motor, sensors and surroundings; None: the calibrated motor with the study's sensors.
    """
    setup = setup or Setup()
    rows = math.floor(profile.duration_s / setup.sample_s + 1e-9) + 1
    time_s = np.arange(rows, dtype=np.float64) * setup.sample_s
    nominal = setup.motor.parameters.electrical.nominal_voltage_V
    ambient, load, airflow, voltage = (
        np.array([value(signal, t) for t in time_s])
        for signal in (
            setup.ambient,
            setup.load_Nm,
            setup.airflow_m_s,
            nominal if setup.voltage_V is None else setup.voltage_V,
        )
    )
    pwm = np.array([profile.at(t) for t in time_s], dtype=np.int64)
    motor = Motor(setup.motor, start_degC=setup.start_degC, ambient_degC=float(ambient[0]))
    states = np.empty((rows, len(motor.nodes)))
    speed, current = np.zeros(rows), np.zeros(rows)
    for k in range(rows):
        states[k] = motor.state
        if k + 1 < rows:
            drive = motor.step(
                int(pwm[k]),
                setup.sample_s,
                load_Nm=float(load[k]),
                ambient_degC=float(ambient[k]),
                voltage_V=float(voltage[k]),
                airflow_m_s=float(airflow[k]),
            )
            speed[k + 1], current[k + 1] = drive.speed_rpm, drive.current_A
    true = {name: states[:, column] for column, name in enumerate(motor.nodes)} | {AMBIENT: ambient}
    measured = _measure(setup, time_s, true)
    return RigRun(
        Run(
            time_s=time_s,
            pwm=pwm,
            temps={name: values for name, values in measured.items() if name != AMBIENT},
            ambient=measured.get(AMBIENT),
            extras=_extras(setup, time_s, current, voltage, speed),
            comments=dict(setup.comments),
        ),
        Truth(time_s, true, load, airflow, setup.motor),
    )


def warm_start(profile: Profile, motor: MotorConfig | None = None, ambient_degC: float = 30.0) -> dict[str, float]:
    """Run a cold motor through a profile and return its temperatures then, for `Setup.start_degC`."""
    warm = Motor(motor, ambient_degC=ambient_degC)
    ends = (*profile.starts_s[1:], profile.duration_s)
    for pwm, start, end in zip(profile.levels, profile.starts_s, ends, strict=True):
        warm.step(pwm, end - start)
    return warm.temperatures


def _measure(setup: Setup, time_s: FloatArray, true: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Read every sensor at every row."""
    seeds = np.random.SeedSequence(setup.seed).spawn(len(setup.sensors) + 1)[1:]
    measured = {}
    for seed, (name, config) in zip(seeds, setup.sensors.items(), strict=True):
        sensor = Thermocouple(config, seed)
        pairs = zip(true[name].tolist(), time_s.tolist(), strict=True)
        measured[name] = np.array([decode(sensor.read(value_degC, t)) for value_degC, t in pairs])
    return measured


def _extras(
    setup: Setup, time_s: FloatArray, current: FloatArray, voltage: FloatArray, speed: FloatArray
) -> dict[str, FloatArray]:
    random = np.random.default_rng(np.random.SeedSequence(setup.seed).spawn(1)[0])
    logged = {
        "current_A": np.round(current + random.normal(0.0, setup.current_noise_A, len(time_s)), 3),
        "voltage_V": np.round(voltage + random.normal(0.0, setup.voltage_noise_V, len(time_s)), 3),
        # The board counts pulses for 250 ms: 500 a turn, so that one pulse is 0.48 rpm.
        "speed_rpm": np.round(speed / 0.48) * 0.48,
    }
    extras = {name: logged[name] for name in setup.channels}
    return extras | {name: np.array([value(decoy, t) for t in time_s.tolist()]) for name, decoy in setup.decoys.items()}
