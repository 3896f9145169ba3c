"""Changes of what arises in a motor: its load, supply, friction, and what its losses do with temperature and speed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.losses import COPPER_REFERENCE
from benchmarks.plants.plant import Plant, Running
from benchmarks.plants.planted.altered import scaled_sources
from benchmarks.plants.planted.change import Act, Acting, Change, Now, Steps, jumps

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class LoadHeating(Change):
    """What the motor drives resists more, for some minutes at a time: the current heats the winding and the brushes.

    Parameters
    ----------
    torque
        Most, beside what the motor drives always; relative, as `Losses.load`.
    """

    needs: ClassVar[tuple[str, ...]] = ("current_A",)
    torque: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        def draw() -> float:
            return 0.0 if rng.random() < 0.3 else float(self.torque * rng.uniform(0.2, 1.0))

        return {"load": jumps(rng, duration, (3.0, 25.0), draw, 0.0)}

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        return replace(plant, losses=replace(plant.losses, load=plant.losses.load + now.signals["load"]))


@dataclass(frozen=True)
class SupplyVoltage(Change):
    """The supply is not regulated any more: it walks slowly about its rated voltage.

    Parameters
    ----------
    swing
        Standard deviation of the walk, as a share of the rated voltage.
    """

    needs: ClassVar[tuple[str, ...]] = ("voltage_V",)
    swing: float

    def signals(self, rng: np.random.Generator, number: int, duration: float) -> dict[str, Steps]:  # noqa: D102
        state = float(rng.normal())

        def draw() -> float:
            nonlocal state
            state = 0.9 * state + float(np.sqrt(1.0 - 0.9**2) * rng.normal())
            return float(np.clip(1.0 + self.swing * state, 0.55, 1.45))

        return {"supply": jumps(rng, duration, (1.5, 6.0), draw, 1.0)}

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        return replace(plant, losses=replace(plant.losses, supply=now.signals["supply"]))


@dataclass(frozen=True)
class TemperatureDependentLoss(Change):
    """A loss that its node's temperature changes: a winding's grows in a straight line, grease thins exponentially.

    Parameters
    ----------
    source
        Which of the plant's sources.
    per_K
        How much that source grows or shrinks, beside what it did before, 1/K.
    thins
        Whether it shrinks.
    """

    source: int
    per_K: float
    thins: bool

    def act(self, plant: Plant, running: Running, now: Now) -> Act | None:  # noqa: D102
        source = plant.sources[self.source]
        watts = source.share * float(getattr(plant.losses, source.kind)(now.duty))

        def act(temperature: FloatArray, own: FloatArray, ambient: float) -> Acting:
            heat = np.zeros(temperature.size)
            grown = self.per_K * (temperature[source.node] - COPPER_REFERENCE)
            heat[source.node] = watts * (float(np.exp(-grown)) - 1.0 if self.thins else grown)
            return Acting(heat)

        return act


@dataclass(frozen=True)
class Direction(Change):
    """Backwards, brushes or bearings rub otherwise.

    Parameters
    ----------
    sources
        Which of the plant's sources.
    factor
        Of their heat while it turns backwards.
    """

    sources: tuple[int, ...]
    factor: float

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        return scaled_sources(plant, self.factor, self.sources) if now.pwm < 0 else plant


@dataclass(frozen=True)
class ScheduleError(Change):
    """At some speeds a loss is otherwise: a resonance about one of them.

    Parameters
    ----------
    sources
        Which of the plant's sources.
    centre, width
        Of the resonance and to where half of it is left, shares of full PWM.
    gain
        What the resonance adds at its centre, as a multiple.
    """

    sources: tuple[int, ...]
    centre: float
    width: float
    gain: float

    def under(self, plant: Plant, now: Now) -> Plant:  # noqa: D102
        away = (now.duty - self.centre) / self.width
        return scaled_sources(plant, 1.0 + self.gain / (1.0 + away**2), self.sources)
