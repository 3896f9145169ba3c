"""Changes that no library of effects has: what names them is wrong, and what explains them learnt something else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from benchmarks.plants.plant import Plant, Running
from benchmarks.plants.planted.altered import scaled_sources
from benchmarks.plants.planted.change import Act, Acting, Change, Now, Steps, jumps
from benchmarks.plants.planted.paths import Airflow
from benchmarks.plants.planted.sensing import SensorChange
from benchmarks.plants.profiles import HOUR

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Melting(Change):
    """Grease or wax at a node melts, and sets again: its latent heat is stored about one temperature.

    Parameters
    ----------
    node
        Where.
    at, width
        About which temperature, degC, and the standard deviation of the range, K.
    latent
        J.
    """

    longest_s: ClassVar[float] = 10.0
    node: int
    at: float
    width: float
    latent: float

    def act(self, plant: Plant, running: Running, now: Now) -> Act | None:  # noqa: D102
        def act(temperature: FloatArray, own: FloatArray, ambient: float) -> Acting:
            capacity = np.zeros(temperature.size)
            away = (temperature[self.node] - self.at) / self.width
            capacity[self.node] = self.latent * np.exp(-0.5 * away**2) / (self.width * np.sqrt(2.0 * np.pi))
            return Acting(capacity=capacity)

        return act


@dataclass(frozen=True)
class Duct(Change):
    """Air that one node has warmed comes to another one through a duct, minutes later.

    Parameters
    ----------
    first, second
        From which node to which.
    delay
        For how long it is on its way, s.
    conductance
        W at the second node for each kelvin of the first one over the room.
    """

    states: ClassVar[int] = 12
    first: int
    second: int
    delay: float
    conductance: float

    def begin(self, ambient: float) -> tuple[float, ...]:  # noqa: D102
        return (0.0,) * self.states

    def act(self, plant: Plant, running: Running, now: Now) -> Act | None:  # noqa: D102
        def act(temperature: FloatArray, own: FloatArray, ambient: float) -> Acting:
            heat = np.zeros(temperature.size)
            heat[self.second] = self.conductance * own[-1]
            enters = np.concatenate([[temperature[self.first] - ambient], own[:-1]])
            return Acting(heat, own=(enters - own) * self.states / self.delay)

        return act


CRITICAL = 2.0 / (3.0 * np.sqrt(3.0))
"""Push at which z - z^3 + push has one rest left instead of two."""
SNAP_S = 5.0


@dataclass(frozen=True)
class Bimetal(Change):
    """A strip snaps to the frame when its node gets hot, and lets go only when it is a good deal cooler again.

    Parameters
    ----------
    node
        Where.
    shuts, opens
        At which of its temperatures, degC.
    conductance
        To the room while shut, W/K.
    """

    states: ClassVar[int] = 1
    node: int
    shuts: float
    opens: float
    conductance: float

    def begin(self, ambient: float) -> tuple[float, ...]:  # noqa: D102
        return (-1.0,)

    def act(self, plant: Plant, running: Running, now: Now) -> Act | None:  # noqa: D102
        middle, half = 0.5 * (self.shuts + self.opens), 0.5 * (self.shuts - self.opens)

        def act(temperature: FloatArray, own: FloatArray, ambient: float) -> Acting:
            heat = np.zeros(temperature.size)
            shut = 0.5 + 0.5 * np.tanh(4.0 * own[0])
            heat[self.node] = -self.conductance * shut * (temperature[self.node] - ambient)
            push = CRITICAL * np.clip((temperature[self.node] - middle) / half, -3.0, 3.0)
            return Acting(heat, own=(own - own**3 + push) / SNAP_S)

        return act


@dataclass(frozen=True)
class LoadCycle(Change):
    """What the motor drives resists by a slow cycle of the plant that it stands in, and no current is logged.

    Parameters
    ----------
    torque
        Most, beside what the motor drives always; relative, as `Losses.load`.
    period
        s.
    """

    lacks: ClassVar[tuple[str, ...]] = ("current_A",)
    torque: float
    period: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        times = np.arange(0.0, duration, 90.0)
        wave = np.sin(2.0 * np.pi * (times / self.period + rng.random()))
        return {"cycle": Steps(0.0, tuple(times.tolist()), tuple((self.torque * np.maximum(wave, 0.0)).tolist()))}

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        return replace(plant, losses=replace(plant.losses, load=plant.losses.load + now.signals["cycle"]))


@dataclass(frozen=True)
class WarmedThermometer(Change):
    """The room's thermometer lies too near to the motor, and is warmed by it.

    Parameters
    ----------
    node
        By which node.
    share
        Of that node's rise.
    lag
        Time constant, s.
    """

    node: int
    share: float
    lag: float

    def room_seen(self, ambient: FloatArray, temperature: FloatArray, time: FloatArray) -> FloatArray:  # noqa: D102
        keep = float(np.exp(-(time[1] - time[0]) / self.lag))
        over = self.share * (temperature[:, self.node] - ambient)
        return np.asarray(ambient + lfilter([1.0 - keep], [1.0, -keep], over, zi=[keep * over[0]])[0])


@dataclass(frozen=True)
class Neighbour(Change):
    """A machine that stands beside warms a node; a timer starts and stops it, and nobody logs it.

    Parameters
    ----------
    node
        Which.
    watts
        While it runs.
    period, on
        Of the timer, s, and the share of it for which the machine runs.
    """

    node: int
    watts: float
    period: float
    on: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        starts = np.arange(-float(rng.random()), duration / self.period) * self.period
        edges = [(float(at), 1.0) for at in starts] + [(float(at) + self.on * self.period, 0.0) for at in starts]
        times, values = zip(*sorted((round(at), value) for at, value in edges if at >= 0.0), strict=True)
        return {"neighbour": Steps(1.0 - values[0], tuple(map(float, times)), values)}

    def act(self, plant: Plant, running: Running, now: Now) -> Act | None:  # noqa: D102
        heat = np.zeros(plant.size)
        if now.time >= 0.0:
            heat[self.node] = self.watts * now.signals["neighbour"]
        return lambda temperature, own, ambient: Acting(heat)


@dataclass(frozen=True)
class UnloggedFan(Airflow):
    """A fan blows at the motor at times, and nobody logs it."""

    needs: ClassVar[tuple[str, ...]] = ()

    def columns(self, rng: np.random.Generator, signals: Mapping[str, FloatArray]) -> dict[str, FloatArray]:  # noqa: D102
        return {}


@dataclass(frozen=True)
class Sun(Change):
    """The sun shines on a surface, once in each run, and clouds pass.

    Parameters
    ----------
    node
        Which.
    watts
        At its highest.
    """

    node: int
    watts: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        times = np.arange(0.0, duration, 120.0)
        lasts = float(rng.uniform(1.0, 2.5)) * HOUR
        rises = float(rng.uniform(-0.3 * lasts, max(duration - 0.7 * lasts, 0.0)))
        high = np.sin(np.pi * np.clip((times - rises) / lasts, 0.0, 1.0))
        clouded = jumps(rng, duration, (4.0, 30.0), lambda: float(rng.choice([1.0, 1.0, 0.25])), 1.0).along(times)
        return {"sun": Steps(0.0, tuple(times.tolist()), tuple((high * clouded).tolist()))}

    def act(self, plant: Plant, running: Running, now: Now) -> Act | None:  # noqa: D102
        heat = np.zeros(plant.size)
        if now.time >= 0.0:
            heat[self.node] = self.watts * now.signals["sun"]
        return lambda temperature, own, ambient: Acting(heat)


@dataclass(frozen=True)
class StickSlip(Change):
    """At low speeds a bearing sticks and slips for some minutes, and then runs smoothly again.

    Parameters
    ----------
    sources
        Which of the plant's sources.
    below
        At which speeds, shares of full PWM.
    factor
        Of their heat while it sticks and slips.
    """

    sources: tuple[int, ...]
    below: float
    factor: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        return {"sticks": jumps(rng, duration, (2.0, 12.0), lambda: float(rng.random() < 0.5), 0.0)}

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        sticks = now.duty < self.below and now.signals["sticks"] > 0.0
        return scaled_sources(plant, self.factor, self.sources) if sticks else plant


@dataclass(frozen=True)
class Ceiling(SensorChange):
    """A sensor's amplifier cannot tell more than so many degC."""

    ceiling: float

    def of_it(self, true: FloatArray, time: FloatArray, ambient: FloatArray) -> FloatArray:  # noqa: D102
        return np.minimum(true, self.ceiling)


@dataclass(frozen=True)
class Fouling(Change):
    """Dust settles, and is blown away between runs: what the surfaces lose falls by another share in each run.

    Parameters
    ----------
    most
        Share that a run's end has lost, at the most.
    """

    most: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        times = np.arange(0.0, duration, 180.0)
        share = self.most * float(rng.uniform(0.2, 1.0)) * (1.0 - np.exp(-times / HOUR))
        return {"dust": Steps(0.0, tuple(times.tolist()), tuple(share.tolist()))}

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        clean = 1.0 - now.signals["dust"]
        surfaces = tuple(
            replace(s, law=replace(s.law, rest=s.law.rest * clean), natural=s.natural * clean) for s in plant.surfaces
        )
        return replace(plant, surfaces=surfaces)
