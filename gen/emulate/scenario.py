"""Which plant a run has: the simulated MY1016, or a coefficient file, with what its options say of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gen.coefficients import Coefficients, load
from gen.coefficients.wiring import Thermocouple, Wiring
from gen.emulate.options import parse_sensor_faults, parse_signal, parse_start, parse_told
from gen.emulate.plants.plant import Changeable, Ran
from gen.emulate.plants.rig import TOLD, RigPlant, has_parts, kind_of
from gen.errors import InputError
from gen.rig import NODES, Fault, MotorConfig, SensorConfig, sensors, warm_start
from gen.rig import Profile as RigProfile
from gen.rig.chips import Converter, Ntc
from gen.rig.signals import Signal, value

if TYPE_CHECKING:
    from gen.emulate.plants.model_faults import ModelFault
    from gen.emulate.plants.model_plant import ModelPlant

RIG, MODEL = "rig", "model"
ROOMS = (-273.15, 1000.0)
"""Ambients that can be, degC; `--ambient` of the other commands has the same."""


@dataclass(frozen=True)
class Scenario:
    """What the options of `gen emulate` say of motor and sensors, as they stand there.

    Parameters
    ----------
    plant
        ``rig``, ``model``, a coefficient file, or None: the rig where it has all parts that the board measures, else
        the model.
    fault, fault_start, fault_severity
        The fault, when it begins in s, and 0..1.
    sensor_faults, sensor_tolerance
        Faults, and the largest offset in K.
    ambient, load, start
        Temperature, torque, and the state at the start.
    channels
        ``COLUMN=VALUE`` over time.
    seed
        Of the sensors' errors.
    """

    plant: str | None = None
    fault: str | None = None
    fault_start: float = 0.0
    fault_severity: float = 1.0
    sensor_faults: tuple[str, ...] = ()
    sensor_tolerance: float = 1.1
    ambient: str = "30"
    load: str = "0"
    start: str | None = None
    channels: tuple[str, ...] = ()
    seed: int = 0


@dataclass(frozen=True)
class Made:
    """A plant, and what a person should know of it.

    Parameters
    ----------
    plant
        For the board.
    about
        What it is.
    fault
        What is wrong with the motor and since when, as run files have it; ``none``.
    offsets_K
        What each of the board's sensors reads beside what is there, by channel, K.
    """

    plant: Changeable
    about: str
    fault: str
    offsets_K: Mapping[str, float]


def make_plant(scenario: Scenario, coefficients: Coefficients, file: Path) -> Made:
    """Make the plant of a run.

    Parameters
    ----------
    scenario
        The options.
    coefficients, file
        What the board holds, and its file; it has wiring.

    Raises
    ------
    InputError
        With the option that is at fault, or the file and what the plant lacks of it.
    """
    wiring = coefficients.document.wiring
    assert wiring is not None
    wired = [chip.channel for chip in wiring.thermocouples]
    plant = scenario.plant or (RIG if has_parts(wired) else MODEL)
    try:
        if plant == RIG:
            return _rig(scenario, wiring, wired)
        return _model(scenario, wiring, wired, coefficients, coefficients if plant == MODEL else _other(plant))
    except InputError as error:
        about_option = error.place is not None and error.place.startswith("--")
        raise InputError(
            error.message, file=error.file or (None if about_option else str(file)), place=error.place
        ) from error


def _other(plant: str) -> Coefficients:
    if not Path(plant).exists():
        raise InputError(f'found "{plant}", expected rig, model or a coefficient file', place="--plant")
    return load(plant)


def _rig(scenario: Scenario, wiring: Wiring, wired: list[str]) -> Made:
    ambient, told = _surroundings(scenario)
    strangers = set(told) - set(TOLD)
    if strangers:
        raise InputError(
            f'the simulated motor is not told "{min(strangers)}"; expected {" or ".join(TOLD)}', place="--channel"
        )
    fault = None
    if scenario.fault is not None:
        kind = kind_of(scenario.fault)
        fault = Fault(kind, scenario.fault_start, scenario.fault_severity)
    motor = MotorConfig(faults=(fault,) if fault is not None else ())
    start = parse_start(scenario.start, NODES)
    if isinstance(start, Ran):
        start = warm_start(RigProfile((0.0,), (start.pwm,), start.seconds), motor, value(ambient, 0.0))
    drawn = sensors(scenario.seed, tolerance_K=scenario.sensor_tolerance)
    plant = RigPlant(
        wired,
        motor=motor,
        sensors=drawn,
        sensor_faults=parse_sensor_faults(scenario.sensor_faults, wired),
        converters=converters(wiring),
        start_degC=start,
        ambient_degC=ambient,
        load_Nm=parse_signal(scenario.load, "--load", column="load_Nm", straight=False),
        airflow_m_s=told.get("airflow_m_s", 0.0),
        voltage_V=told.get("voltage_V"),
        pulses_per_revolution=_pulses(wiring),
        seed=scenario.seed,
    )
    said = "none" if fault is None else f"{fault.kind} from {fault.start_s:g} s"
    return Made(plant, "rig, the simulated MY1016", said, _offsets(drawn, wired))


def _model(scenario: Scenario, wiring: Wiring, wired: list[str], board: Coefficients, motor: Coefficients) -> Made:
    from gen.emulate.plants.courses import part_names
    from gen.emulate.plants.model_faults import parse_faults
    from gen.emulate.plants.model_plant import ModelPlant, neutral_of

    ambient, told = _surroundings(scenario)
    if scenario.load != "0":
        raise InputError(
            "a coefficient file says nothing of torque; expected what it reads, such as a current, by --channel",
            place="--load",
        )
    faults: tuple[ModelFault, ...] = ()
    if scenario.fault is not None:
        faults = parse_faults(scenario.fault, scenario.fault_start, scenario.fault_severity)
    drawn = sensors(scenario.seed, tolerance_K=scenario.sensor_tolerance, lag_s=0.0, names=wired)
    plant = ModelPlant(
        motor,
        wired,
        faults=faults,
        sensors=drawn,
        sensor_faults=parse_sensor_faults(scenario.sensor_faults, wired),
        converters=converters(wiring),
        start=parse_start(scenario.start, part_names(motor.model)),
        ambient_degC=ambient,
        told=told,
        wired=dict.fromkeys((channel.column for channel in wiring.channels), 0.0) | neutral_of(board),
        pulses_per_revolution=_pulses(wiring),
        seed=scenario.seed,
    )
    said = ", ".join(f"{fault.name} from {fault.start_s:g} s" for fault in faults) or "none"
    return Made(plant, _about(plant, motor), said, _offsets(drawn, wired))


def _offsets(drawn: Mapping[str, SensorConfig], wired: Sequence[str]) -> dict[str, float]:
    return {name: drawn[name].offset_K for name in wired if name in drawn}


def _about(plant: ModelPlant, motor: Coefficients) -> str:
    kind = "network" if motor.model.network is not None else "transfer functions"
    kind += " with effects" if motor.effects else ""
    still = ", ".join(f"{column} = {stays:g}" for column, stays in plant.untold.items())
    return f"model {motor.name}, {kind}" + (f"; nobody tells (--channel): {still}" if still else "")


def _surroundings(scenario: Scenario) -> tuple[Signal, Mapping[str, Signal]]:
    ambient = parse_signal(scenario.ambient, "--ambient", column="ambient_degC", straight=True, within=ROOMS)
    return ambient, parse_told(scenario.channels)


def converters(wiring: Wiring) -> dict[str, Converter]:
    """Give the chip of each channel, as the simulated sensors have it."""
    return {
        chip.channel: Converter(
            chip.chip, *chip.resistor_ohm, three_wires=chip.wires == 3, thermistor=_thermistor(chip)
        )
        for chip in wiring.thermocouples
    }


def _thermistor(chip: Thermocouple) -> Ntc | None:
    if chip.chip != "NTC":
        return None
    own = chip.thermistor
    return Ntc(own.a, own.b, own.c, own.series_ohm, to_supply=own.to_supply)


def _pulses(wiring: Wiring) -> int:
    return wiring.encoder.pulses_per_revolution if wiring.encoder is not None else 0
