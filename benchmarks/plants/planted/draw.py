"""Drawing changes at random: where, of what kind, and how strong."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.plants.cases import Bench
from benchmarks.plants.planted import losses, paths, sensing, surroundings
from benchmarks.plants.planted.change import Change
from benchmarks.plants.planted.visible import TARGETS_K, Sight, sight, sized


@dataclass(frozen=True)
class Draft:
    """A change whose strength is open.

    Parameters
    ----------
    build
        The change of some strength.
    span
        The weakest and the strongest that there can be.
    attempts
        How often it is worth drawing anew where it cannot be seen.
    """

    build: Callable[[float], Change]
    span: tuple[float, float]
    attempts: int = 12


Drafting = Callable[[np.random.Generator, Bench], Draft]


class NotVisible(Exception):
    """On this bench no change of the kind was found that its sensors see, or it has nowhere to be."""


@dataclass(frozen=True)
class Planted:
    """A change, and how far it moves what the sensors are at."""

    name: str
    change: Change
    sight: Sight


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number between two, even in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def anywhere(rng: np.random.Generator, stand: Bench) -> int:
    """A node, sensed or not."""
    return int(rng.integers(stand.plant.size))


def sensed(rng: np.random.Generator, stand: Bench) -> int:
    """A node with a sensor."""
    return int(rng.choice(stand.plant.sensed))


def sign(rng: np.random.Generator) -> float:
    """Up or down."""
    return float(rng.choice([-1.0, 1.0]))


def sources(stand: Bench, *kinds: str) -> list[int]:
    """Which of the plant's sources are of some kinds, by index."""
    return [index for index, source in enumerate(stand.plant.sources) if source.kind in kinds]


def _hidden_node(rng: np.random.Generator, stand: Bench) -> Draft:
    node = anywhere(rng, stand)
    capacity = stand.plant.capacity[node] * between(rng, 0.3, 3.0)
    conductance = between(rng, 0.1, 2.0)
    outlet = float(rng.choice([0.0, conductance * rng.uniform(0.1, 0.5)]))
    if rng.random() < 0.3:  # it only takes up heat, and may give some of it to the room
        gives = float(rng.choice([0.0, 0.5]))
        return Draft(
            lambda strength: paths.HiddenNode(node, capacity, strength, gives * strength, "friction", 0.0), (0.02, 5.0)
        )
    kind = str(rng.choice(["friction", "iron", "copper", "brush"]))
    return Draft(lambda strength: paths.HiddenNode(node, capacity, conductance, outlet, kind, strength), (0.05, 500.0))


def _coupling(rng: np.random.Generator, stand: Bench) -> Draft:
    first, second = (int(node) for node in rng.choice(stand.plant.size, 2, replace=False))
    return Draft(lambda strength: paths.Coupling(first, second, strength), (0.01, 10.0))


def _standstill_cooling(rng: np.random.Generator, stand: Bench) -> Draft:
    every = tuple(surface.node for surface in stand.plant.surfaces)
    nodes = every if rng.random() < 0.5 else (int(rng.choice(every)),)
    if rng.random() < 0.5:
        return Draft(lambda strength: paths.StandstillCooling(nodes, 1.0 + strength), (0.2, 6.0))
    return Draft(lambda strength: paths.StandstillCooling(nodes, 1.0 - strength), (0.2, 0.95))


def _airflow(rng: np.random.Generator, stand: Bench) -> Draft:
    every = [surface.node for surface in stand.plant.surfaces]
    nodes = tuple(every) if rng.random() < 0.5 else (int(rng.choice(every)),)
    diameter = float(rng.uniform(0.03, 0.09))
    return Draft(lambda strength: paths.Airflow(nodes, strength, diameter), (0.0003, 0.1))


def _load_heating(rng: np.random.Generator, stand: Bench) -> Draft:
    return Draft(losses.LoadHeating, (0.05, 3.0))


def _supply_voltage(rng: np.random.Generator, stand: Bench) -> Draft:
    return Draft(losses.SupplyVoltage, (0.02, 0.25))


def _temperature_dependent_loss(rng: np.random.Generator, stand: Bench) -> Draft:
    if rng.random() < 0.5:
        (winding,) = sources(stand, "copper")
        # Copper's 0.4 %/K, and as much again where magnets weaken at the same torque.
        return Draft(lambda strength: losses.TemperatureDependentLoss(winding, strength, thins=False), (0.002, 0.01))
    bearing = int(rng.choice(sources(stand, "friction")))
    return Draft(lambda strength: losses.TemperatureDependentLoss(bearing, strength, thins=True), (0.004, 0.08))


def _radiation(rng: np.random.Generator, stand: Bench) -> Draft:
    node = anywhere(rng, stand)
    return Draft(lambda strength: paths.Radiation(node, strength), (0.001, 0.2))


def _direction(rng: np.random.Generator, stand: Bench) -> Draft:
    which = tuple(sources(stand, str(rng.choice(["friction", "brush"]))))
    if rng.random() < 0.6:
        return Draft(lambda strength: losses.Direction(which, 1.0 + strength), (0.1, 3.0))
    return Draft(lambda strength: losses.Direction(which, 1.0 - strength), (0.1, 0.9))


def _schedule_error(rng: np.random.Generator, stand: Bench) -> Draft:
    every = range(len(stand.plant.sources))
    which = tuple(every) if rng.random() < 0.3 else (int(rng.choice(every)),)
    centre, width = float(rng.uniform(0.3, 0.95)), float(rng.uniform(0.06, 0.15))
    if rng.random() < 0.6:
        return Draft(lambda strength: losses.ScheduleError(which, centre, width, strength), (0.1, 4.0))
    return Draft(lambda strength: losses.ScheduleError(which, centre, width, -strength), (0.1, 0.9))


def _sensor_offset(rng: np.random.Generator, stand: Bench) -> Draft:
    node, side = sensed(rng, stand), sign(rng)
    return Draft(lambda strength: sensing.SensorOffset(node, side * strength), (1.5, 8.0))


def _sensor_gain(rng: np.random.Generator, stand: Bench) -> Draft:
    node, of_rise = sensed(rng, stand), bool(rng.random() < 0.6)
    side = -1.0 if of_rise and rng.random() < 0.7 else sign(rng)
    return Draft(lambda strength: sensing.SensorGain(node, side * strength, of_rise), (0.03, 0.35))


def _sensor_lag(rng: np.random.Generator, stand: Bench) -> Draft:
    node = sensed(rng, stand)
    return Draft(lambda strength: sensing.SensorLag(node, strength), (60.0, 1500.0))


def _drift(rng: np.random.Generator, stand: Bench) -> Draft:
    node, side = sensed(rng, stand), sign(rng)
    settles = float(rng.uniform(1.0, 5.0)) if rng.random() < 0.5 else None
    return Draft(lambda strength: sensing.Drift(node, side * strength, settles), (0.3, 8.0))


def _initial_state(rng: np.random.Generator, stand: Bench) -> Draft:
    return Draft(surroundings.InitialState, (60.0, 7200.0), attempts=1)  # nothing but its strength is drawn


def _ambient(rng: np.random.Generator, stand: Bench) -> Draft:
    walls = float(rng.uniform(0.4, 1.0)) if rng.random() < 0.25 else 0.0
    lag = between(rng, 1.0, 4.0) * 3600.0
    return Draft(lambda strength: surroundings.Ambient(strength, walls, lag), (1.0, 14.0))


LIBRARY: Mapping[str, Drafting] = {
    "hidden_node": _hidden_node,
    "coupling": _coupling,
    "standstill_cooling": _standstill_cooling,
    "airflow": _airflow,
    "load_heating": _load_heating,
    "supply_voltage": _supply_voltage,
    "temperature_dependent_loss": _temperature_dependent_loss,
    "radiation": _radiation,
    "direction": _direction,
    "schedule_error": _schedule_error,
    "sensor_offset": _sensor_offset,
    "sensor_gain": _sensor_gain,
    "sensor_lag": _sensor_lag,
    "drift": _drift,
    "initial_state": _initial_state,
    "ambient": _ambient,
}


def planted(stand: Bench, name: str, drafting: Drafting) -> Planted:
    """Draw a change that the bench's sensors see.

    Raises
    ------
    NotVisible
        If none was found.
    """
    rng = stand.chance("planted", name)
    draft = drafting(rng, stand)
    for _ in range(draft.attempts):
        target = between(rng, *TARGETS_K)
        change = sized(stand, draft.build, draft.span, target)
        try:
            found = sight(stand, change)
        except (RuntimeError, FloatingPointError):  # it runs away
            pass
        else:
            if found.fair:
                return Planted(name, change, found)
        draft = drafting(rng, stand)
    raise NotVisible(f"{name}: nothing that the sensors of bench {stand.seed} see")
