"""Channels that a logger writes beside the temperatures, and that heat nothing by themselves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.course import Course
from benchmarks.plants.plant import FULL_PWM, Plant

FloatArray = NDArray[np.float64]
CHANNELS = ("current_A", "voltage_V", "speed_rpm", "humidity_pct", "vibration_mps2")


def decoys(rng: np.random.Generator, plant: Plant, run: Course, which: tuple[str, ...]) -> dict[str, FloatArray]:
    """Channels of a run, by column.

    Current and speed are what the motor's own losses and an unchanging load make them; the supply is regulated and only
    ripples; humidity walks; the vibration is noise that grows with speed.
    """
    duty = np.abs(run.pwm) / FULL_PWM
    levels, where = np.unique(duty, return_inverse=True)
    current = np.array([plant.losses.current(float(d)) for d in levels])[where]
    speed = np.sign(run.pwm) * np.array([plant.losses.speed(float(d)) for d in levels])[where]
    rows = run.time.size
    walk = np.cumsum(rng.normal(0.0, 0.02, rows))
    made = {
        "current_A": 2.0 * current * (1.0 + rng.normal(0.0, 0.02, rows)) + rng.normal(0.0, 0.02, rows),
        "voltage_V": 24.0 + rng.normal(0.0, 0.05, rows),
        "speed_rpm": 2650.0 * speed + rng.normal(0.0, 8.0, rows) * (duty > 0.0),
        "humidity_pct": np.clip(45.0 + 8.0 * np.sin(run.time / 9000.0 + rng.uniform(0.0, 6.0)) + walk, 5.0, 95.0),
        "vibration_mps2": np.abs(rng.normal(0.3 + 2.0 * duty, 0.2)),
    }
    return {name: made[name] for name in which}
