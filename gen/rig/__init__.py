"""A simulated brushed DC motor with its sensors and faults: own physics, not the identified model.

`Motor` runs step by step, `Thermocouple` and `Encoder` stand between it and a board, `make_run` makes run files.
Nothing that identifies or refines a model may import this package: data with planted effects reach it as files.
"""

from gen.rig.config import Fault, HiddenPart, MotorConfig
from gen.rig.encoder import Encoder
from gen.rig.motor import Drive, Motor
from gen.rig.parameters import MEASURED, NODES, HeatPath, MotorParameters, my1016
from gen.rig.profiles import Profile
from gen.rig.runs import RigRun, Setup, Truth, make_run, sensors, warm_start, zeroed
from gen.rig.sensors import SENSOR_FAULTS, SensorConfig, SensorFault, Thermocouple, decode

__all__ = [
    "MEASURED",
    "NODES",
    "SENSOR_FAULTS",
    "Drive",
    "Encoder",
    "Fault",
    "HeatPath",
    "HiddenPart",
    "Motor",
    "MotorConfig",
    "MotorParameters",
    "Profile",
    "RigRun",
    "SensorConfig",
    "SensorFault",
    "Setup",
    "Thermocouple",
    "Truth",
    "decode",
    "make_run",
    "my1016",
    "sensors",
    "warm_start",
    "zeroed",
]
