"""The temperatures of a motor that is a coefficient file, interval by interval: exactly where there is a solution.

A network and plain transfer functions are solved exactly for inputs that are held over each interval. Effects beside
transfer functions (:mod:`gen.emulate.plants.effects_course`) are integrated over steps of a second at most.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Protocol

import numpy as np

from gen.emulate.plants.model_faults import ModelFault, faulty, settled_K
from gen.model.dynamics import ThermalModel
from gen.model.exact import ExactSolution
from gen.model.network import Network
from gen.model.network_solution import NetworkSolution, Steps

Active = tuple[ModelFault, ...]

_KEPT = 4096
"""Step matrices to keep: a channel that moves all the time needs new ones at every step."""


class Course(Protocol):
    """A motor's temperatures in time."""

    def step(self, pwm: int, dt_s: float, ambient: float, told: Mapping[str, float], active: Active) -> None:
        """Run for a while with constant inputs.

        Parameters
        ----------
        pwm
            -255..255.
        dt_s
            How long, s.
        ambient
            degC.
        told
            Value of every channel that the file reads, in its column's unit.
        active
            The faults that are there.
        """
        ...

    @property
    def parts(self) -> dict[str, float]:
        """True temperature of every part now, degC."""
        ...

    @property
    def shown(self) -> dict[str, float]:
        """What a sensor shows of it, degC: the file's own sensor, where it describes one."""
        ...


def part_names(model: ThermalModel) -> tuple[str, ...]:
    """Names of all parts: of the components, or of the network's nodes, hidden ones too."""
    if model.network is not None:
        return tuple(node.name for node in model.network.nodes)
    return model.component_names


class NetworkCourse:
    """A network's nodes.

    Parameters
    ----------
    model, network
        The model and its network.
    start_degC, ambient
        True temperatures at the start by part, and the ambient then, degC. Parts that are not named are at the ambient,
        hidden nodes between the others.
    """

    def __init__(self, model: ThermalModel, network: Network, start_degC: Mapping[str, float], ambient: float) -> None:
        self._network = network
        self._solution = cache(lambda active: NetworkSolution(replace(model, network=faulty(network, active))))
        self._steps: dict[tuple[object, ...], Steps] = {}
        healthy = self._solution(())
        first = {
            node.name: float(node.sensor.shown(start_degC[node.name], ambient))
            for node in network.nodes
            if node.sensor is not None and node.name in start_degC
        }
        self._states = healthy.start(first, ambient)
        for node in network.hidden:
            if node.name in start_degC:
                self._states[network.index(node.name)] = start_degC[node.name]
        self._healthy, self._ambient = healthy, ambient

    def step(self, pwm: int, dt_s: float, ambient: float, told: Mapping[str, float], active: Active) -> None:
        """See `Course.step`."""
        self._ambient = ambient
        own = {channel.column: told[channel.column] for channel in self._network.channels}
        solution, counts, step = self._solution(active), np.array([abs(pwm)]), np.array([dt_s])
        if self._network.laws:
            self._states = solution.advance(self._states[None], counts, step, np.array([ambient]), own)[0]
            return
        key = (active, abs(pwm), dt_s, *own.values())
        if key not in self._steps:
            if len(self._steps) >= _KEPT:
                self._steps.clear()
            self._steps[key] = solution.steps(counts, step, own)
        made = self._steps[key]
        change = made.increment[0] @ self._states + made.ambient[0] * ambient + made.heat[0]
        self._states = self._states + change

    @property
    def parts(self) -> dict[str, float]:
        """See `Course.parts`."""
        return {node.name: float(self._states[i]) for i, node in enumerate(self._network.nodes)}

    @property
    def shown(self) -> dict[str, float]:
        """See `Course.shown`; of a hidden node its temperature."""
        readings = self._healthy.shown(self._states, self._ambient)
        return self.parts | {name: float(reading) for name, reading in readings.items()}


class PartsCourse:
    """Transfer functions; a fault is further heat that passes the part's own dynamics.

    Parameters
    ----------
    model
        The model.
    start_degC, ambient
        As :class:`NetworkCourse`; derivatives start at 0.
    """

    def __init__(self, model: ThermalModel, start_degC: Mapping[str, float], ambient: float) -> None:
        self._model = model
        self._solution = ExactSolution(model)
        self._ambient = ambient
        counted_from = self._counted_from
        names = model.component_names
        self._states = self._solution.begin({name: start_degC.get(name, ambient) - counted_from for name in names})
        self._settled = cache(lambda active, pwm: settled_K(model, active, pwm))

    @property
    def _counted_from(self) -> float:
        """What the states are rises over, degC."""
        return self._model.ambient_reference if self._model.ambient_passes else self._ambient

    def step(self, pwm: int, dt_s: float, ambient: float, told: Mapping[str, float], active: Active) -> None:
        """See `Course.step`."""
        del told
        self._ambient = ambient
        away = ambient - self._counted_from
        over = {name: away + more for name, more in self._settled(active, pwm).items()}
        self._states = self._solution.advance(self._states, pwm, dt_s, over)

    @property
    def parts(self) -> dict[str, float]:
        """See `Course.parts`."""
        return {name: float(state[0]) + self._counted_from for name, state in self._states.items()}

    @property
    def shown(self) -> dict[str, float]:
        """See `Course.shown`."""
        return self.parts
