"""Run files of a motor with a planted effect, by a generator that shares no code with the effects in ``gen``.

The baseline's transfer functions are integrated by Runge-Kutta of order 4 at 2 s, with the effect inside the
differential equation; sensors quantise to 0.25 K, are noisy and off by a few tenths. Every run has current,
voltage, fan, ambient, humidity and vibration columns, whether or not the effect knows of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gen.coefficients import load
from gen.runs import Run, write_run

COEFFICIENTS = Path(__file__).parents[2] / "examples" / "my1016" / "coeffs.json"
NAMES = ("brush", "bearing", "magnet", "casing")
STEP = 2.0
EVERY = 3
"""Integration steps for each row of a run file."""
AMBIENT = 30.0
Array = NDArray[Any]


@dataclass
class Baseline:
    """Transfer functions at each PWM: denominators (256, 4) for the brush, rate and gain (256,) for the others."""

    brush: Array
    brush_gain: Array
    rate: dict[str, Array]
    gain: dict[str, Array]

    @classmethod
    def of(cls, path: Path) -> Baseline:
        """Read the coefficient file."""
        model = load(path).model
        x = np.arange(256)
        rate = {n: model.component(n).denominator(x)[:, -1] / model.component(n).denominator(x)[:, -2] for n in NAMES}
        gain = {n: rate[n] * model.component(n).steady_rise(x) for n in NAMES}
        return cls(model.component("brush").denominator(x), model.component("brush").effective_gain(x), rate, gain)


@dataclass
class Plan:
    """What drives R runs: arrays (steps, R)."""

    pwm: Array
    current: Array
    voltage: Array
    fan: Array
    ambient: Array
    humidity: Array
    vibration: Array
    start: Array
    time: Array


def plan(random: np.random.Generator, runs: int, hours: float, ambient_moves: bool) -> Plan:
    """Profiles as people make them: speeds held for a while, stops, reversals, load changes; some warm starts."""
    steps = int(hours * 3600 / STEP) + 1
    shape = (steps, runs)
    levels = np.array([51, 77, 102, 128, 153, 179, 204, 230, 255])
    pwm = np.zeros(shape, dtype=int)
    current, voltage, fan = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    ambient, humidity, vibration = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    t = np.arange(steps) * STEP
    for r in range(runs):
        at = 0
        last = -1
        while at < steps:
            length = int(random.uniform(1200, 3300) / STEP)
            stop = last > 0 and random.random() < 0.35
            level = 0 if stop else int(random.choice(levels))
            pwm[at : at + length, r] = level * (-1 if random.random() < 0.3 else 1)
            last = level
            at += length
        current[:, r] = np.where(pwm[:, r] == 0, 0.0, pieces(random, steps, 900, 0.4, 6.0))
        voltage[:, r] = pieces(random, steps, 2000, 22.0, 26.0)
        fan[:, r] = pieces(random, steps, 1500, 0.0, 1.0) > 0.6
        swing = random.uniform(2.0, 6.0) if ambient_moves else 0.1
        ambient[:, r] = AMBIENT + swing * np.sin(2 * np.pi * (t / random.uniform(5000, 16000) + random.random()))
        humidity[:, r] = 45 + 10 * np.sin(2 * np.pi * (t / random.uniform(4000, 20000) + random.random()))
        vibration[:, r] = np.abs(pwm[:, r]) / 255 + random.normal(0.0, 0.05, steps)
    start = np.where(random.random(runs) < 0.4, random.uniform(8.0, 28.0, runs), 0.0)
    return Plan(pwm, current, voltage, fan, ambient, humidity, vibration, start, t)


def pieces(random: np.random.Generator, steps: int, typical_s: float, low: float, high: float) -> Array:
    """Constant pieces of random length and height."""
    out = np.empty(steps)
    at = 0
    while at < steps:
        length = int(random.uniform(0.5, 1.5) * typical_s / STEP)
        out[at : at + length] = random.uniform(low, high)
        at += length
    return out


@dataclass
class Physics:
    """The planted physics; entries that a planted effect replaces.

    Attributes
    ----------
    heat
        (name, rise (R,), all rises, step index, plan) -> extra heating of the component, K/s.
    inner
        Derivative of hidden states (S, R), same arguments.
    hidden
        Hidden states at the start, (S, R).
    reading
        (name, temperature (rows, R), time (rows,), plan) -> what the sensor would show before noise.
    lag
        Sensor's time constant by component.
    """

    heat: list[Callable[..., Array]] = field(default_factory=list)
    inner: list[Callable[..., Array]] = field(default_factory=list)
    hidden: list[Array] = field(default_factory=list)
    reading: list[Callable[..., Array]] = field(default_factory=list)
    lag: dict[str, float] = field(default_factory=dict)
    ambient_matters: bool = False


def simulate(base: Baseline, plan: Plan, physics: Physics) -> dict[str, Array]:
    """True temperatures of each component, degC, (steps, R), sensors' lag included."""
    steps, runs = plan.pwm.shape
    hidden = len(physics.hidden)
    y = np.zeros((6 + hidden + len(physics.lag), runs))
    room0 = plan.ambient[0] if physics.ambient_matters else AMBIENT
    y[:4] = plan.start
    y[1:4] = plan.start  # bearing, magnet, casing
    y[0], y[4], y[5] = plan.start, 0.0, 0.0  # brush, brush', brush''
    for i, h in enumerate(physics.hidden):
        y[6 + i] = h
    lagged = list(physics.lag)
    for i, name in enumerate(lagged):
        y[6 + hidden + i] = y[NAMES.index(name)]
    out = np.empty((steps, *y.shape))

    def slope(y: Array, k: int) -> Array:
        x = np.abs(plan.pwm[k])
        rises = {"brush": y[0], "bearing": y[1], "magnet": y[2], "casing": y[3]}
        extra = {n: np.zeros(runs) for n in NAMES}
        for part in physics.heat:
            for n in NAMES:
                extra[n] = extra[n] + part(n, rises, k, plan, y[6 : 6 + hidden])
        room = plan.ambient[k] - AMBIENT if physics.ambient_matters else 0.0
        d = np.empty_like(y)
        a = base.brush[x].T
        # heat into the brush goes through its own third-order dynamics
        push = a[3] * (room + extra["brush"] / base.rate["brush"][x])
        d[0], d[4] = y[4], y[5]
        d[5] = base.brush_gain[x] * x + push - a[1] * y[5] - a[2] * y[4] - a[3] * y[0]
        for i, n in enumerate(NAMES[1:], start=1):
            d[i] = base.gain[n][x] + extra[n] - base.rate[n][x] * (y[i] - room)
        for i, part in enumerate(physics.inner):
            d[6 + i] = part(rises, k, plan, y[6 : 6 + hidden])
        for i, n in enumerate(lagged):
            d[6 + hidden + i] = (rises[n] - y[6 + hidden + i]) / physics.lag[n]
        return d

    if physics.ambient_matters:  # a cold motor has the room's temperature
        y[:4] += room0 - AMBIENT
    for k in range(steps):
        out[k] = y
        k1 = slope(y, k)
        k2 = slope(y + 0.5 * STEP * k1, k)
        k3 = slope(y + 0.5 * STEP * k2, k)
        k4 = slope(y + STEP * k3, k)
        y = y + STEP / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)
    made = {}
    for i, n in enumerate(NAMES):
        column = 6 + hidden + lagged.index(n) if n in lagged else i
        made[n] = out[:, column] + AMBIENT
    return made


@dataclass
class Sensors:
    """Noise (K), and offset (K) by component."""

    noise: float
    offset: dict[str, float]


def write(
    folder: Path,
    plan: Plan,
    true: dict[str, Array],
    physics: Physics,
    sensors: Sensors,
    random: np.random.Generator,
    fit: int,
    missing: float = 0.0,
) -> tuple[list[Path], list[Path], float]:
    """Write the run files; `missing` is the share of temperature samples that are not there.

    Returns
    -------
    fit, test, floor
        Paths, and the RMSE of readings about the truth (with the planted sensor effect, without the offsets), K.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rows = np.arange(0, plan.time.size, EVERY)
    paths: list[Path] = []
    squares = []
    shown = {}
    for n in NAMES:
        value = true[n]
        for part in physics.reading:
            value = part(n, value, plan.time, plan)
        shown[n] = value
    for r in range(plan.pwm.shape[1]):
        temps = {}
        for n in NAMES:
            clean = shown[n][rows, r]
            noisy = clean + sensors.offset[n] + random.normal(0.0, sensors.noise, rows.size)
            temps[n] = np.round(noisy / 0.25) * 0.25
            squares.append(np.mean((temps[n] - clean - sensors.offset[n]) ** 2))
            if missing:
                temps[n][random.random(rows.size) < missing] = np.nan
        room = np.round((plan.ambient[rows, r] + random.normal(0.0, 0.1, rows.size)) / 0.25) * 0.25
        run = Run(
            time_s=plan.time[rows],
            pwm=plan.pwm[rows, r],
            temps=temps,
            ambient=room,
            extras={
                "current_A": np.round(plan.current[rows, r] + random.normal(0, 0.03, rows.size), 3),
                "voltage_V": np.round(plan.voltage[rows, r] + random.normal(0, 0.02, rows.size), 3),
                "fan_contact": plan.fan[rows, r].astype(float),
                "humidity_percent": np.round(plan.humidity[rows, r], 1),
                "vibration_g": np.round(plan.vibration[rows, r], 3),
            },
        )
        path = folder / f"{'fit' if r < fit else 'test'}{r}.csv"
        write_run(path, run)
        paths.append(path)
    return paths[:fit], paths[fit:], float(np.sqrt(np.mean(squares)))
