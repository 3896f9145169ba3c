"""A motor of which something has been changed, as `course` follows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.plants.decoys import RATED_V, Electric
from benchmarks.plants.plant import FollowedRates, Plant
from benchmarks.plants.planted.change import Change, Now, Steps

FloatArray = NDArray[np.float64]


class Altered:
    """A plant with changes, in one run.

    Parameters
    ----------
    plant
        As it was identified.
    planted
        What has been changed since.
    signals
        What varies in this run.
    """

    def __init__(self, plant: Plant, planted: Sequence[Change], signals: Mapping[str, Steps]) -> None:
        for change in planted:
            plant = change.plant(plant)
        self.plant, self.planted, self.signals = plant, tuple(planted), dict(signals)

    @property
    def changes(self) -> tuple[float, ...]:
        """When what varies jumps, s."""
        return tuple(sorted({time for steps in self.signals.values() for time in steps.times}))

    @property
    def longest_s(self) -> float:
        """The longest step of the integration, s."""
        return min([self.plant.longest_s, *(change.longest_s for change in self.planted)])

    def rest(self, ambient: float) -> FloatArray:
        """Temperatures of all nodes, and behind them the changes' own states."""
        own = [value for change in self.planted for value in change.begin(ambient)]
        return np.concatenate([self.plant.rest(ambient), own])

    def now(self, pwm: int, time: float) -> Now:
        """What holds from a time in s on."""
        return Now(pwm, time, {name: steps.at(time) for name, steps in self.signals.items()})

    def under(self, now: Now) -> Plant:
        """The motor as it is now."""
        plant = self.plant
        for change in self.planted:
            plant = change.under(plant, now)
        return plant

    def rates(self, pwm: int, begin: float) -> FollowedRates:
        """How its state changes at a PWM from a time in s to the next jump."""
        now = self.now(pwm, begin)
        plant = self.under(now)
        running, size = plant.at(pwm), plant.size
        acts, first = [], size
        for change in self.planted:
            act = change.act(plant, running, now)
            if act is not None:
                acts.append((act, slice(first, first + change.states)))
            first += change.states

        def rates(state: FloatArray, ambient: float) -> FloatArray:
            temperature = state[:size]
            flows, capacity = running.flows(temperature, ambient), running.capacity.copy()
            made = np.zeros(state.size)
            for act, own in acts:
                acting = act(temperature, state[own], ambient)
                flows, capacity = flows + acting.heat, capacity + acting.capacity
                made[own] = acting.own
            made[:size] = flows / capacity
            return made

        return rates

    def electric(self, time: FloatArray, pwm: NDArray[np.int64]) -> Electric:
        """What meters see of it at some rows."""
        varies = [steps.along(time) for steps in self.signals.values()]
        rows, where = np.unique(np.stack([pwm.astype(np.float64), *varies], axis=1), axis=0, return_inverse=True)
        found = np.empty((rows.shape[0], 3))
        for index, (counts, *values) in enumerate(rows.tolist()):
            now = Now(int(counts), 0.0, dict(zip(self.signals, values, strict=True)))
            losses = self.under(now).losses
            turning = np.sign(counts) * losses.speed(now.duty)
            found[index] = losses.current(now.duty), turning, RATED_V * losses.supply
        return Electric(*found[where.reshape(-1)].T)


def scaled_sources(plant: Plant, factor: float, which: Sequence[int]) -> Plant:
    """The plant with some of its sources, by index, stronger by a factor."""
    sources = tuple(replace(s, share=s.share * factor) if i in which else s for i, s in enumerate(plant.sources))
    return replace(plant, sources=sources)
