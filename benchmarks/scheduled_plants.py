"""Random thermal plants with schedules, and runs of them as a sensor sees them; nothing here is used by gen itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.model import Component, ExactSolution, Pole, Table, ThermalModel
from gen.runs import Run

FloatArray = NDArray[np.float64]
SPEEDS = (51, 102, 153, 204, 255)
QUANTUM = 0.25
AMBIENT = 30.0


@dataclass(frozen=True, eq=False)
class Plant:
    """A component with known schedules.

    Attributes
    ----------
    tau
        Time constants by |PWM| 0..255, slowest first, shape (256, order), s.
    steady
        Steady rise by |PWM|, shape (256,), K.
    noise, bias
        Of its sensor: standard deviation and constant error, K.
    """

    tau: FloatArray
    steady: FloatArray
    noise: float
    bias: float

    @property
    def order(self) -> int:
        """Number of poles."""
        return int(self.tau.shape[1])

    def model(self) -> ThermalModel:
        """The plant as a model with every value tabulated."""
        counts = tuple(range(256))
        gain = self.steady / np.maximum(np.arange(256), 1) / np.prod(self.tau, axis=1)
        gain[0] = gain[1]
        poles = tuple(Pole(Table(counts, tuple((-1.0 / t).tolist()), "linear")) for t in self.tau.T)
        component = Component("part", self.order, Table(counts, tuple(gain.tolist()), "linear"), poles, (0, 255))
        return ThermalModel(
            "plant", 1.0, 255, (0, 255), "hold", (0, 255), (-10.0, 50.0), (-10.0, 300.0), AMBIENT, None, (component,)
        )


def random_plant(rng: np.random.Generator) -> Plant:
    """Draw a plant: order 1..3, time constants of minutes to an hour that vary smoothly over speed."""
    x = np.arange(256) / 255.0
    order = int(rng.integers(1, 4))
    slow = np.log(rng.uniform(700.0, 2400.0)) + _curve(rng, x, 0.35)
    taus = [slow]
    for _ in range(order - 1):
        taus.append(taus[-1] - np.log(rng.uniform(4.0, 9.0)) + _curve(rng, x, 0.15))
    top = rng.uniform(25.0, 70.0)
    peak = rng.uniform(0.5, 1.2)
    rise = top * (x / peak) ** rng.uniform(0.5, 1.0) * np.exp(rng.uniform(0.3, 0.8) * (1.0 - (x / peak) ** 2) / 2.0)
    return Plant(np.exp(np.stack(taus, axis=1)), rise, rng.uniform(0.05, 0.3), rng.uniform(-1.1, 1.1))


def _curve(rng: np.random.Generator, x: FloatArray, size: float) -> FloatArray:
    a, b = rng.uniform(-size, size, 2)
    return np.asarray(a * (2.0 * x - 1.0) + b * ((2.0 * x - 1.0) ** 2 - 1.0 / 3.0), dtype=np.float64)


def simulate(plant: Plant, pwm: NDArray[np.int64], sample_s: float = 1.0) -> FloatArray:
    """Give the true temperature at each row, degC."""
    time = np.arange(len(pwm)) * sample_s
    return AMBIENT + ExactSolution(plant.model()).simulate_times(time, pwm)["part"]


def measured(plant: Plant, pwm: NDArray[np.int64], rng: np.random.Generator, sample_s: float = 1.0) -> Run:
    """Give a run as the sensor reports it."""
    true = simulate(plant, pwm, sample_s)
    read = true + plant.bias + rng.normal(0.0, plant.noise, len(true))
    return Run(
        np.arange(len(pwm), dtype=np.float64) * sample_s,
        pwm,
        {"part": np.round(read / QUANTUM) * QUANTUM},
        np.full(len(pwm), AMBIENT),
    )


def step_runs(plant: Plant, rng: np.random.Generator) -> list[Run]:
    """Heat from cold at each of five speeds, then cool down."""
    runs = []
    for pwm in SPEEDS:
        hot, cool = int(rng.uniform(5400, 10800)), int(rng.uniform(1800, 5400))
        runs.append(measured(plant, np.repeat([pwm, 0], [hot, cool]).astype(np.int64), rng))
    return runs


def fresh_profile(rng: np.random.Generator, *, known: bool) -> NDArray[np.int64]:
    """Draw three hours of holds of 2..30 minutes at the identified speeds, or at any, with pauses."""
    parts: list[NDArray[np.int64]] = []
    while sum(map(len, parts)) < 10800:
        level = rng.choice([0, *SPEEDS]) if known else rng.choice([0, int(rng.integers(51, 256))], p=[0.2, 0.8])
        parts.append(np.full(int(rng.uniform(120, 1800)), level, dtype=np.int64))
    return np.concatenate(parts)[:10800]
