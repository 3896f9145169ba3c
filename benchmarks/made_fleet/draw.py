"""Motors of one series: a random motor, and others that differ from it in every parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.plants.course import Course, course
from benchmarks.plants.draw import random_plant
from benchmarks.plants.laws import Law
from benchmarks.plants.plant import Plant
from benchmarks.plants.profiles import Profile, later
from benchmarks.plants.rooms import Room, RoomKind, random_room
from benchmarks.plants.sensors import Sensor, random_sensor
from gen.runs import Run

ROW_S = 5.0
MOST_SPREAD = 0.10
"""Each parameter's own spread over the fleet, the standard deviation of its logarithm, is drawn up to this."""
LEAST_SPREAD = 0.05
WEAR = (1.3, 1.7)
"""Factor on the heat of a source that has worn."""
SENSOR_K = (1.5, 3.0)
"""What a sensor that has shifted is off by."""
BATCH = "2026-03"
"""Value of the label `batch` of those motors that are of one which differs, where there is one."""


@dataclass(frozen=True, eq=False)
class Motor:
    """One motor of the fleet.

    Attributes
    ----------
    name
        Its ID.
    plant
        As it was made.
    sensors
        One for each sensed node.
    worn, sound
        As it is in its last run, and as it would be then without a fault.
    shifted, usual
        By sensed node, what its sensor is off by in the last run, K, and what it would be then without a fault.
    truth
        What is wrong with it in its last run: `""`, `worn NODE` or `sensor NODE`.
    labels
        Its supplier and its batch.
    """

    name: str
    plant: Plant
    sensors: tuple[Sensor, ...]
    worn: Plant
    sound: Plant
    shifted: tuple[float, ...]
    usual: tuple[float, ...]
    truth: str
    labels: dict[str, str]


@dataclass(frozen=True)
class Made:
    """How the fleet is made.

    Attributes
    ----------
    motors, seed
        How many, and the series.
    faulty
        Share of motors with a fault in their last run.
    effect
        Factor on all heat of the winding that all motors show in their last run; 1 for none.
    batch
        Share of motors that are of one batch; the others are of three.
    batch_sensor_K, batch_heat
        What one sensor of that batch is off by in the last run, K, and a factor on the heat of one source there.
    ageing
        Most that friction has grown by until the last run, as a share; of each motor, healthy or not, some of it.
    """

    motors: int
    seed: int = 3
    faulty: float = 0.1
    effect: float = 1.0
    batch: float = 0.25
    batch_sensor_K: float = 0.0
    batch_heat: float = 1.0
    ageing: float = 0.0


def fleet(made: Made) -> list[Motor]:
    """Draw the motors; the faults go round the kinds."""
    nominal = random_plant(made.seed)
    rng = np.random.default_rng([20281, made.seed])
    spread = _Spread(rng)
    spreads = spread.like(nominal)
    count = round(made.faulty * made.motors)
    faulty = set(rng.permutation(made.motors)[:count].tolist())
    labels, differing = _labels(made), np.random.default_rng([20285, made.seed])
    sensor, source = (int(differing.integers(count)) for count in (len(nominal.sensed), len(nominal.sources)))
    found = []
    for number in range(made.motors):
        own = np.random.default_rng([20282, made.seed, number])
        plant = varied(own, nominal, spreads)
        sensors = tuple(random_sensor(own) for _ in plant.sensed)
        shifted, worn, truth = [0.0] * len(plant.sensed), plant, ""
        kind = number if number in faulty else None
        if kind is not None and own.random() < 0.7:
            place = int(own.integers(len(plant.sources)))
            worn, truth = (
                _worn(plant, [place], float(own.uniform(*WEAR))),
                f"worn {plant.names[plant.sources[place].node]}",
            )
        elif kind is not None:
            place = int(own.integers(len(shifted)))
            shifted[place] = float(own.uniform(*SENSOR_K) * own.choice([-1.0, 1.0]))
            truth = f"sensor {plant.names[plant.sensed[place]]}"
        copper = [i for i, source in enumerate(plant.sources) if source.kind == "copper"]
        worn, sound = (_worn(each, copper, made.effect) for each in (worn, plant))
        friction = [i for i, source_ in enumerate(plant.sources) if source_.kind == "friction"]
        age = 1.0 + made.ageing * float(np.random.default_rng([20287, made.seed, number]).random())
        worn, sound = (_worn(each, friction, age) for each in (worn, sound))
        usual = [0.0] * len(plant.sensed)
        if labels[number]["batch"] == BATCH:
            worn, sound = (_worn(each, [source], made.batch_heat) for each in (worn, sound))
            shifted[sensor] += made.batch_sensor_K
            usual[sensor] += made.batch_sensor_K
        found.append(
            Motor(f"m{number:04d}", plant, sensors, worn, sound, tuple(shifted), tuple(usual), truth, labels[number])
        )
    return found


def _labels(made: Made) -> list[dict[str, str]]:
    """Draw batches and suppliers, independent of each other and of faults."""
    rng = np.random.default_rng([20284, made.seed])
    of_batch = set(rng.permutation(made.motors)[: round(made.batch * made.motors)].tolist())
    return [
        {
            "batch": BATCH if number in of_batch else str(rng.choice(["2025-11", "2025-12", "2026-01"])),
            "supplier": str(rng.choice(["A", "B", "C"], p=[0.5, 0.3, 0.2])),
        }
        for number in range(made.motors)
    ]


def _worn(plant: Plant, which: Sequence[int], factor: float) -> Plant:
    sources = tuple(replace(s, share=s.share * factor) if i in which else s for i, s in enumerate(plant.sources))
    return replace(plant, sources=sources)


@dataclass(frozen=True, eq=False)
class Spreads:
    """Standard deviations of the logarithms over the fleet: capacities, links, surfaces, sources."""

    capacity: tuple[float, ...]
    links: tuple[float, ...]
    surfaces: tuple[float, ...]
    sources: tuple[float, ...]


class _Spread:
    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def of(self, count: int) -> tuple[float, ...]:
        return tuple(self._rng.uniform(LEAST_SPREAD, MOST_SPREAD, count).tolist())

    def like(self, plant: Plant) -> Spreads:
        return Spreads(
            self.of(plant.size), self.of(len(plant.links)), self.of(len(plant.surfaces)), self.of(len(plant.sources))
        )


def varied(rng: np.random.Generator, plant: Plant, spreads: Spreads) -> Plant:
    """Draw a motor of the series."""

    def factor(spread: float) -> float:
        return float(np.exp(rng.normal(0.0, spread)))

    def law(old: Law, by: float) -> Law:
        return replace(old, rest=old.rest * by)

    surfaces = []
    for old, spread in zip(plant.surfaces, spreads.surfaces, strict=True):
        by = factor(spread)
        surfaces.append(replace(old, law=law(old.law, by), natural=old.natural * by, radiating=old.radiating * by))
    return replace(
        plant,
        capacity=tuple(c * factor(s) for c, s in zip(plant.capacity, spreads.capacity, strict=True)),
        links=tuple(replace(o, law=law(o.law, factor(s))) for o, s in zip(plant.links, spreads.links, strict=True)),
        surfaces=tuple(surfaces),
        sources=tuple(
            replace(o, share=o.share * factor(s)) for o, s in zip(plant.sources, spreads.sources, strict=True)
        ),
    )


@dataclass(frozen=True, eq=False)
class Ran:
    """A run, and what truly happened."""

    run: Run
    course: Course


def ran(motor: Motor, number: int, *, last: bool) -> Ran:
    """Run a motor for 4 h in a room that moves and is measured.

    Parameters
    ----------
    motor
        Which.
    number
        Of the run: its profile and its room are this motor's own.
    last
        Whether as it is in its last run: worn, a sensor shifted.
    """
    rng = np.random.default_rng([20283, int(motor.name[1:]), number])
    profile: Profile = later(lambda _: rng, [f"run{number}"])[0]
    room: Room = random_room(rng, RoomKind.MOVING, 23.0, profile.duration, 10800.0)
    done = course(motor.worn if last else motor.plant, profile, room, ROW_S)
    temps = {}
    for sensor, node, shift in zip(motor.sensors, motor.plant.sensed, motor.shifted, strict=True):
        read = sensor.read(rng, done.temperature[:, node], ROW_S)
        temps[motor.plant.names[node]] = read + shift if last else read
    thermometer = random_sensor(rng)
    return Ran(Run(done.time, done.pwm, temps, thermometer.read(rng, done.ambient, ROW_S)), done)
