"""Channels that a logger writes beside the temperatures, and that heat nothing by themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.course import Course
from benchmarks.plants.losses import Losses
from benchmarks.plants.plant import FULL_PWM

FloatArray = NDArray[np.float64]
CHANNELS = ("current_A", "voltage_V", "speed_rpm", "humidity_pct", "vibration_mps2")
RATED_V = 24.0


@dataclass(frozen=True, eq=False)
class Electric:
    """What meters see of a motor, at each row.

    Parameters
    ----------
    current, speed
        Relative; speed has the direction's sign.
    voltage
        Of the supply, V.
    """

    current: FloatArray
    speed: FloatArray
    voltage: FloatArray


def electric(losses: Losses, pwm: NDArray[np.int64]) -> Electric:
    """What meters see where the load never changes and the supply is regulated."""
    duty = np.abs(pwm) / FULL_PWM
    levels, where = np.unique(duty, return_inverse=True)
    current = np.array([losses.current(float(d)) for d in levels])[where]
    speed = np.sign(pwm) * np.array([losses.speed(float(d)) for d in levels])[where]
    return Electric(current, speed, np.full(pwm.size, RATED_V * losses.supply))


def decoys(rng: np.random.Generator, seen: Electric, run: Course, which: tuple[str, ...]) -> dict[str, FloatArray]:
    """Channels of a run, by column.

    Current, voltage and speed are metered; humidity walks; the vibration is noise that grows with speed.
    """
    duty = np.abs(run.pwm) / FULL_PWM
    rows = run.time.size
    walk = np.cumsum(rng.normal(0.0, 0.02, rows))
    made = {
        "current_A": 2.0 * seen.current * (1.0 + rng.normal(0.0, 0.02, rows)) + rng.normal(0.0, 0.02, rows),
        "voltage_V": seen.voltage + rng.normal(0.0, 0.05, rows),
        "speed_rpm": 2650.0 * seen.speed + rng.normal(0.0, 8.0, rows) * (duty > 0.0),
        "humidity_pct": np.clip(45.0 + 8.0 * np.sin(run.time / 9000.0 + rng.uniform(0.0, 6.0)) + walk, 5.0, 95.0),
        "vibration_mps2": np.abs(rng.normal(0.3 + 2.0 * duty, 0.2)),
    }
    return {name: made[name] for name in which if name in made}
