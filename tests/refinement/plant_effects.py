"""The planted effects: sixteen that the library knows by name, and eight that it does not."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.refinement import plant_wide
from tests.refinement.plant import (
    AMBIENT,
    COEFFICIENTS,
    NAMES,
    Array,
    Baseline,
    Physics,
    Sensors,
    plan,
    simulate,
    write,
)

Part = Callable[..., Array]


def _sign(random: np.random.Generator) -> float:
    return float(random.choice([-1.0, 1.0]))


def _one(random: np.random.Generator) -> str:
    return str(random.choice(NAMES))


def add(name: str, physics: Physics, random: np.random.Generator, base: Baseline, runs: int, start: Array) -> str:
    """Plant one effect of random size; give the component ("all" for several)."""
    at = _one(random)
    mean = {n: float(np.median(base.rate[n][51:])) for n in NAMES}
    size = random.uniform(4.0, 12.0)  # K in the steady state, about

    def heats(function: Part) -> None:
        physics.heat.append(lambda n, rises, k, plan, h: function(n, rises, k, plan, h) if n == at else 0.0 * rises[n])

    if name == "ambient":
        physics.ambient_matters = True
        return "all"
    if name == "hidden_node":
        tau = random.uniform(900.0, 4000.0)
        number = len(physics.hidden)
        physics.hidden.append(np.zeros(runs))
        physics.inner.append(lambda rises, k, plan, h: (np.abs(plan.pwm[k]) / 255.0 - h[number]) / tau)
        heats(lambda n, rises, k, plan, h: 1.5 * size * mean[at] * h[number])
    elif name == "standstill_cooling":
        f = float(random.choice([random.uniform(0.2, 0.5), random.uniform(2.0, 4.0)]))
        heats(lambda n, rises, k, plan, h: np.where(plan.pwm[k] == 0, (1 - f) * base.rate[n][0] * rises[n], 0.0))
    elif name == "load_heating":
        heats(lambda n, rises, k, plan, h: size / 14.0 * mean[at] * plan.current[k] ** 2)
    elif name == "coupling":
        other = str(random.choice([n for n in NAMES if n != at]))
        k_ = random.uniform(0.3, 1.0) * mean[at] * (2.0 if at == "brush" or other == "brush" else 6.0)
        heats(lambda n, rises, k, plan, h: k_ * (rises[other] - rises[n]))
    elif name == "radiation":
        full = (AMBIENT + 40 + 273.15) ** 4 - (AMBIENT + 273.15) ** 4
        heats(
            lambda n, rises, k, plan, h: (
                -2.0 * size * mean[at] / full * ((AMBIENT + rises[n] + 273.15) ** 4 - (AMBIENT + 273.15) ** 4)
            )
        )
    elif name == "temperature_dependent_loss":
        alpha = random.uniform(0.0025, 0.006) * _sign(random)
        heats(lambda n, rises, k, plan, h: base.gain[n][np.abs(plan.pwm[k])] * alpha * rises[n])
    elif name == "airflow":
        k_ = random.uniform(0.25, 0.8) * mean[at]
        heats(lambda n, rises, k, plan, h: -k_ * plan.fan[k] * rises[n])
    elif name == "sensor_offset":
        off = _sign(random) * random.uniform(2.0, 6.0)
        physics.reading.append(lambda n, value, time, plan: value + off if n == at else value)
    elif name == "sensor_gain":
        g = _sign(random) * random.uniform(0.06, 0.2)
        physics.reading.append(lambda n, value, time, plan: AMBIENT + (1 + g) * (value - AMBIENT) if n == at else value)
    elif name == "sensor_lag":
        physics.lag[at] = random.uniform(150.0, 600.0)
    elif name == "schedule_error":
        centre, width, g = random.uniform(70, 240), random.uniform(20, 45), _sign(random) * random.uniform(0.12, 0.35)
        heats(
            lambda n, rises, k, plan, h: (
                g * np.exp(-(((np.abs(plan.pwm[k]) - centre) / width) ** 2)) * base.gain[n][np.abs(plan.pwm[k])]
            )
        )
    elif name == "drift":
        d = _sign(random) * random.uniform(1.5, 4.0)
        physics.reading.append(lambda n, value, time, plan: value + d * time[:, None] / 3600.0 if n == at else value)
    elif name == "direction":
        d = _sign(random) * random.uniform(0.15, 0.4)
        heats(lambda n, rises, k, plan, h: np.where(plan.pwm[k] < 0, d, 0.0) * base.gain[n][np.abs(plan.pwm[k])])
    elif name == "supply_voltage":
        v0 = random.uniform(23.0, 25.0)
        heats(lambda n, rises, k, plan, h: ((plan.voltage[k] / v0) ** 2 - 1.0) * base.gain[n][np.abs(plan.pwm[k])])
    elif name == "initial_state":
        tau, g = random.uniform(300.0, 1500.0), random.uniform(0.3, 0.8)
        number = len(physics.hidden)
        physics.hidden.append(start.copy())
        physics.inner.append(lambda rises, k, plan, h: -h[number] / tau)
        heats(lambda n, rises, k, plan, h: g / tau * h[number])
    else:
        raise KeyError(name)
    return at


def outside(name: str, physics: Physics, random: np.random.Generator, base: Baseline, runs: int) -> str:
    """Plant an effect that the library does not have."""
    at = _one(random)
    mean = float(np.median(base.rate[at][51:]))
    size = random.uniform(4.0, 10.0)

    def heats(function: Part) -> None:
        physics.heat.append(lambda n, rises, k, plan, h: function(rises, k, plan, h) if n == at else 0.0 * rises[n])

    def shows(function: Part) -> None:
        physics.reading.append(lambda n, value, time, plan: function(value, time, plan) if n == at else value)

    if name == "sine":  # something periodic in the building
        period, phase = random.uniform(2500, 6000), random.uniform(0, 6, runs)
        heats(lambda rises, k, plan, h: size * mean * np.sin(2 * np.pi * plan.time[k] / period + phase))
    elif name == "bursts":  # heat at random times
        times = random.uniform(0, 7000, (3, runs))
        heats(lambda rises, k, plan, h: 3 * size * mean * np.any(np.abs(plan.time[k] - times) < 300, axis=0))
    elif name == "per_run":  # the sensor sits otherwise in every run
        shift = random.normal(0.0, 0.12, runs)
        shows(lambda value, time, plan: AMBIENT + (1 + shift) * (value - AMBIENT))
    elif name == "thermostat":  # switches heat on above, off below a temperature
        number = len(physics.hidden)
        physics.hidden.append(np.zeros(runs))
        physics.inner.append(
            lambda rises, k, plan, h: np.where(
                rises[at] > 28, (1 - h[number]) / 20, np.where(rises[at] < 20, -h[number] / 20, 0)
            )
        )
        heats(lambda rises, k, plan, h: -2 * size * mean * h[number])
    elif name == "humidity":  # cooling by a channel that no effect takes for cooling
        heats(lambda rises, k, plan, h: 0.08 * size * mean * (plan.humidity[k] - 45))
    elif name == "switching":  # heat with every change of speed
        number = len(physics.hidden)
        physics.hidden.append(np.zeros(runs))
        physics.inner.append(
            lambda rises, k, plan, h: (
                (np.abs(plan.pwm[k] - plan.pwm[max(k - 60, 0)]) > 20).astype(float) / 60 - h[number] / 1500
            )
        )
        heats(lambda rises, k, plan, h: 2 * size * mean * h[number])
    elif name == "saturating":  # the reading cannot pass a ceiling
        shows(lambda value, time, plan: np.minimum(value, AMBIENT + random.uniform(18, 22)))
    elif name == "memory":  # heating depends on the hours run above half speed
        number = len(physics.hidden)
        physics.hidden.append(np.zeros(runs))
        physics.inner.append(lambda rises, k, plan, h: (np.abs(plan.pwm[k]) > 128) / 3600.0)
        heats(lambda rises, k, plan, h: size * mean * h[number] ** 2)
    else:
        raise KeyError(name)
    return at


LIBRARY = (
    "ambient",
    "hidden_node",
    "standstill_cooling",
    "load_heating",
    "coupling",
    "radiation",
    "temperature_dependent_loss",
    "airflow",
    "sensor_offset",
    "sensor_gain",
    "sensor_lag",
    "schedule_error",
    "drift",
    "direction",
    "supply_voltage",
    "initial_state",
)
OUTSIDE = ("sine", "bursts", "per_run", "thermostat", "humidity", "switching", "saturating", "memory")


RUNS, FIT, HOURS = 8, 6, 2.5


def make(
    folder: Path, kinds: tuple[str, ...], seed: int, *, wide: bool = False
) -> tuple[list[Path], list[Path], float]:
    """Write the run files of one trial; give fit, test and the noise floor in K, offsets of the sensors counted.

    `wide` plants forms that the library does not have, by ``plant_wide``.
    """
    random = np.random.default_rng([seed, *(zlib.crc32(kind.encode()) for kind in kinds), *([1] if wide else [])])
    base = Baseline.of(COEFFICIENTS)
    profile = (plant_wide.profiles if wide else plan)(random, RUNS, HOURS, "ambient" in kinds)
    if "initial_state" in kinds:
        profile.start = random.uniform(8.0, 28.0, RUNS) * (random.random(RUNS) < 0.7)
    physics = Physics()
    for kind in kinds:
        if kind in OUTSIDE:
            outside(kind, physics, random, base, RUNS)
        else:
            (plant_wide.add if wide else add)(kind, physics, random, base, RUNS, profile.start)
    true = simulate(base, profile, physics)
    sensors = Sensors(float(random.uniform(0.1, 0.3)), {name: float(random.normal(0.0, 0.3)) for name in NAMES})
    fit, test, floor = write(folder, profile, true, physics, sensors, random, FIT, missing=0.05 if wide else 0.0)
    return fit, test, float(np.hypot(floor, np.sqrt(np.mean([o**2 for o in sensors.offset.values()]))))
