"""The library's effects as terms of a network: one module each. Adding one is a module and its place in `LIBRARY`."""

from gen.refinement.network.effects import (
    airflow,
    coupling,
    direction,
    hidden_node,
    load_heating,
    path_change,
    radiation,
    schedule_error,
    sensors,
    standstill_cooling,
    supply_voltage,
    temperature_dependent_loss,
    walls,
)
from gen.refinement.network.effects.base import Motor, NetworkEffect
from gen.refinement.network.effects.hidden_node import HiddenNode
from gen.refinement.network.effects.offered import Offered
from gen.refinement.network.effects.path_change import PathChange
from gen.refinement.network.effects.schedule_error import ScheduleError
from gen.refinement.network.effects.sensors import SensorGain

LIBRARY = (
    load_heating,
    airflow,
    supply_voltage,
    standstill_cooling,
    direction,
    temperature_dependent_loss,
    hidden_node,
    coupling,
    path_change,
    radiation,
    schedule_error,
    sensors,
    walls,
)


def candidates(motor: Motor, data: Offered) -> list[NetworkEffect]:
    """Everything in the library that may act on a motor in these runs."""
    return [effect for module in LIBRARY for effect in module.offered(motor, data)]


__all__ = [
    "LIBRARY",
    "HiddenNode",
    "Motor",
    "NetworkEffect",
    "Offered",
    "PathChange",
    "ScheduleError",
    "SensorGain",
    "candidates",
]
