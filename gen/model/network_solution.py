"""The exact solution of a network's differential equations in float64: by matrix exponential, or, where a path has a
law of its own, integrated with control of the error (:mod:`gen.model.law_solution`).

It judges what the board computes and so shares no code with the lowering or the reference simulators. A step adds
``(exp(M h) - 1) (T + a form of the inputs)`` instead of multiplying by the exponential: increments keep their own
relative precision (see :mod:`gen.model.exact`).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gen.arrays import FloatArray, IntArray
from gen.model.dynamics import ThermalModel
from gen.model.exact import magnitude
from gen.model.law_solution import LawFlow, LawPaths, advanced, advanced_alone
from gen.model.network import Network

_CHUNK = 1 << 21
"""Entries of the matrices exponentiated at once, to bound the memory of long irregular runs: 16 MB an array."""
_SMALL = 2.0**-6
"""Norm below which the series of phi is summed."""
_TERMS = 9
"""Terms of it: the first one left out is below (2**-6)**9 / 10! < 2e-23 of the first."""


class Steps(NamedTuple):
    """x += increment[k] x + ambient[k] T_ambient + heat[k]: shapes (k, n, n), (k, n), (k, n).

    The states x are the nodes' temperatures, those that sensors with a lag show, degC, and how far sensors drifted, K.
    """

    increment: FloatArray
    ambient: FloatArray
    heat: FloatArray


class NetworkSolution:
    """Exact readings of a network for inputs that are held over each interval.

    Parameters
    ----------
    model
        A model that holds a network.
    """

    def __init__(self, model: ThermalModel) -> None:
        if model.network is None:
            raise ValueError(f"{model.name} is no network")
        self.model = model
        self.network: Network = model.network
        sensed = [(node.name, node.sensor) for node in self.network.nodes if node.sensor is not None]
        lagging = [name for name, sensor in sensed if sensor.lag > 0.0]
        #: Of each sensor with a lag: its node's position, and its time constant in s.
        self._lags = [(self.network.index(name), sensor.lag) for name, sensor in sensed if name in lagging]
        self._sensors = dict(sensed)
        drifting = [name for name, sensor in sensed if sensor.drift]
        #: Of each sensor that drifts: how far in the end, K, and its time constant in s.
        self._drifts = [(sensor.drift, sensor.settling) for _, sensor in sensed if sensor.drift]
        first = len(self.network.nodes)
        self._places = {
            name: first + lagging.index(name) if name in lagging else self.network.index(name) for name, _ in sensed
        }
        self._drift_places = {name: first + len(lagging) + k for k, name in enumerate(drifting)}
        self.size = first + len(lagging) + len(drifting)

    def simulate_times(
        self,
        time_s: ArrayLike,
        pwm: ArrayLike,
        ambient: ArrayLike,
        channels: Mapping[str, ArrayLike] | None = None,
        start: Mapping[str, float] | None = None,
    ) -> dict[str, FloatArray]:
        """Solve at the irregular times of a run, its inputs held until the next row.

        Parameters
        ----------
        time_s
            Strictly increasing times in s, shape (N,).
        pwm
            Integer PWM, -255..255, shape (N,); the last one has no effect.
        ambient
            degC, a number or shape (N,).
        channels
            Columns in their own units, a number or shape (N,) each; neutral where not given. Others are let pass.
        start
            First readings by sensed node, degC; nodes at the ambient where not given. Hidden nodes rest between them.

        Returns
        -------
        dict
            Reading in degC by sensed node, shape (N,).

        Raises
        ------
        ValueError
            If shapes differ, the time does not increase, or the PWM is none.
        """
        return self.shown(self.states_along(time_s, pwm, ambient, channels, start), ambient)

    def states_along(
        self,
        time_s: ArrayLike,
        pwm: ArrayLike,
        ambient: ArrayLike,
        channels: Mapping[str, ArrayLike] | None = None,
        start: Mapping[str, float] | None = None,
    ) -> FloatArray:
        """Solve the same for all nodes, the sensors that lag, degC, and those that drift, K, shape (N, states)."""
        time = np.asarray(time_s, dtype=np.float64)
        counts = magnitude(pwm)
        if time.shape != counts.shape or time.ndim != 1 or not time.size:
            raise ValueError(f"time {time.shape} and pwm {counts.shape} must be vectors of one length, with a row")
        step = np.diff(time)
        if np.any(step <= 0.0):
            raise ValueError("time must increase strictly")
        room = np.broadcast_to(np.asarray(ambient, dtype=np.float64), time.shape)
        known = {channel.column for channel in self.network.channels}
        told = {
            name: np.broadcast_to(np.asarray(values, dtype=np.float64), time.shape)[:-1]
            for name, values in (channels or {}).items()
            if name in known
        }
        inputs = np.column_stack([counts[:-1].astype(np.float64), step, *told.values()])
        out = np.empty((time.size, self.size))
        out[0] = self.start(start or {}, float(room[0]))
        if self.network.laws:
            self._integrate(inputs, tuple(told), room, out)
            return out
        distinct, index = np.unique(inputs, axis=0, return_inverse=True)
        index = index.ravel()
        most = max(1, _CHUNK // out.shape[1] ** 2)
        if distinct.shape[0] <= most:
            self._march(self._steps(distinct, tuple(told)), index, room, out)
        else:
            # Nearly every row differs: step matrices are made where they are needed, and dropped.
            for first in range(0, index.size, most):
                part = slice(first, min(first + most, index.size))
                own = np.arange(part.stop - part.start)
                steps = self._steps(inputs[part], tuple(told))
                self._march(steps, own, room[part], out[part.start : part.stop + 1])
        return out

    def shown(self, states: FloatArray, ambient: ArrayLike) -> dict[str, FloatArray]:
        """Readings by sensed node, degC.

        Parameters
        ----------
        states
            As :meth:`start` and :meth:`advance` give them, degC, shape (..., states).
        ambient
            At the time of the reading, degC, a number or shape (...).
        """
        shown = {name: self._sensors[name].shown(states[..., place], ambient) for name, place in self._places.items()}
        return shown | {name: shown[name] + states[..., place] for name, place in self._drift_places.items()}

    def _integrate(self, inputs: FloatArray, names: tuple[str, ...], room: FloatArray, out: FloatArray) -> None:
        """Row by row, the inputs of equal rows looked up once."""
        from gen.model.exponential_step import RowSteps  # compiled: slow to import, and of no use without a law

        distinct, index = np.unique(inputs[:, [0, *range(2, inputs.shape[1])]], axis=0, return_inverse=True)
        told = {name: distinct[:, 1 + k] for k, name in enumerate(names)}
        flow = self.flow(distinct[:, 0].astype(np.int64), told)
        steps, counts, lengths = RowSteps(), inputs[:, 0].tolist(), inputs[:, 1].tolist()
        for k, i in enumerate(index.ravel().tolist()):
            states, rate = np.append(out[k], room[k]), flow.lane(i)
            made = steps(rate, counts[k], states, lengths[k])
            if made is None:
                made = advanced_alone(rate, states, lengths[k])
            out[k + 1] = made[:-1]

    def advance(
        self,
        states: FloatArray,
        pwm: IntArray,
        step: FloatArray,
        ambient: FloatArray,
        told: Mapping[str, ArrayLike] | None = None,
    ) -> FloatArray:
        """States after one interval of constant inputs, of many lanes.

        Parameters
        ----------
        states
            degC, as :meth:`start` gives them, shape (L, states).
        pwm, step, ambient
            Integer |PWM|, length in s, and degC, shape (L,) each.
        told
            Values of the channels, numbers or shape (L,) each.
        """
        if self.network.laws:
            return advanced(self.flow(pwm, told), np.concatenate([states, ambient[:, None]], axis=1), step)[:, :-1]
        made = self.steps(pwm, step, told)
        change = np.einsum("lij,lj->li", made.increment, states) + made.heat
        return np.asarray(states + change + made.ambient * ambient[:, None], dtype=np.float64)

    def flow(self, pwm: IntArray, told: Mapping[str, ArrayLike] | None = None) -> LawFlow:
        """dT/dt of states as :meth:`start` gives them and then the ambient, which stays; arguments as of `advance`."""
        network = self.network
        values = {**network.neutral(), **(told or {})}
        paths = [network.factor_values(path.factors, values, pwm.shape) for path in network.paths]
        heats = [network.factor_values(heat.factors, values, pwm.shape) for heat in network.heats]
        size = self.size
        rates = np.zeros((*pwm.shape, size + 1, len(network.laws)))
        for k, (number, _) in enumerate(network.laws):
            path = network.paths[number]
            for sign, name in ((-1.0, path.first), (1.0, path.second)):
                if name is not None:
                    conductance = network.conductances[pwm, number] * paths[number]
                    rates[:, network.index(name), k] = sign * conductance / network.capacities[network.index(name)]
            paths[number] = np.zeros(pwm.shape)
        m, a, f = self.with_sensors(*network.matrices_with(pwm, paths, heats))
        matrix, constant = np.zeros((*pwm.shape, size + 1, size + 1)), np.zeros((*pwm.shape, size + 1))
        matrix[:, :size, :size], matrix[:, :size, size], constant[:, :size] = m, a, f
        return LawFlow(matrix, constant, self._law_paths, rates)

    @cached_property
    def _law_paths(self) -> LawPaths:
        network = self.network
        ambient = self.size
        paths = [network.paths[number] for number, _ in network.laws]
        first = [network.index(path.first) for path in paths]
        second = [ambient if path.second is None else network.index(path.second) for path in paths]
        return LawPaths(first, second, [law for _, law in network.laws])

    def _steps(self, inputs: FloatArray, names: tuple[str, ...]) -> Steps:
        """For rows of |PWM|, length in s, and channels."""
        told = {name: inputs[:, 2 + k] for k, name in enumerate(names)}
        return self.steps(inputs[:, 0].astype(np.int64), inputs[:, 1], told)

    @staticmethod
    def _march(steps: Steps, index: IntArray, room: FloatArray, out: FloatArray) -> None:
        state = out[0]
        for k, i in enumerate(index.tolist()):
            state = state + (steps.increment[i] @ state + steps.ambient[i] * room[k] + steps.heat[i])
            out[k + 1] = state

    def start(self, readings: Mapping[str, ArrayLike], ambient: ArrayLike) -> FloatArray:
        """States at the start.

        Parameters
        ----------
        readings
            First readings by sensed node, degC, of any one shape; a node without one starts at the ambient.
        ambient
            degC, of that shape.

        Returns
        -------
        FloatArray
            Nodes, then sensors that lag, in balance with their nodes, degC, then what others drifted, none yet, K,
            shape (..., states).

        Raises
        ------
        KeyError
            If a reading is of no sensed node.
        """
        network = self.network
        unknown = set(readings) - set(self._places)
        if unknown:
            raise KeyError(f"no sensed node {', '.join(sorted(unknown))}")
        room = np.asarray(ambient, dtype=np.float64)
        sensed = [
            sensor.temperature(readings[name], room) if name in readings else room
            for name, sensor in self._sensors.items()
        ]
        given = np.stack(np.broadcast_arrays(*sensed, room), axis=-1)
        nodes = np.empty((*given.shape[:-1], len(network.nodes)))
        nodes[..., [network.index(node.name) for node in network.sensed]] = given[..., :-1]
        nodes[..., [network.index(node.name) for node in network.hidden]] = given @ network.hidden_at_start.T
        drifted = np.zeros((*nodes.shape[:-1], len(self._drifts)))
        return np.concatenate([nodes, nodes[..., [node for node, _ in self._lags]], drifted], axis=-1)

    def steps(self, pwm: IntArray, step: FloatArray, told: Mapping[str, ArrayLike] | None = None) -> Steps:
        """Step matrices of intervals, every law being the difference of both temperatures.

        Parameters
        ----------
        pwm
            Integer |PWM|, shape (k,).
        step
            Lengths, s, shape (k,).
        told
            Values of the channels, numbers or shape (k,) each.
        """
        m, a, f = self.with_sensors(*self.network.matrices(pwm, told))
        grown, phi = _exponential(m * step[:, None, None])
        return Steps(
            grown,
            np.einsum("kij,kj->ki", phi, a * step[:, None]),
            np.einsum("kij,kj->ki", phi, f * step[:, None]),
        )

    def with_sensors(self, m: FloatArray, a: FloatArray, f: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Append a state for each sensor that lags, which takes nothing from its node, and for each that drifts."""
        n, size = len(self.network.nodes), self.size
        grown = np.zeros((m.shape[0], size, size))
        grown[:, :n, :n] = m
        for k, (node, lag) in enumerate(self._lags, start=n):
            grown[:, k, node], grown[:, k, k] = 1.0 / lag, -1.0 / lag
        pad = np.zeros((m.shape[0], size - n))
        heat = np.concatenate([f, pad], axis=1)
        for k, (drift, settling) in enumerate(self._drifts, start=n + len(self._lags)):
            grown[:, k, k], heat[:, k] = -1.0 / settling, drift / settling
        return grown, np.concatenate([a, pad], axis=1), heat


def _exponential(m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """exp(m) - 1 and phi = (exp(m) - 1) / m for each matrix, shape (k, n, n).

    By the series at x = m / 2**s, and then s times phi(2x) = phi(x) (1 + E(x) / 2), E(2x) = E(x) (2 + E(x)). Only E and
    phi are multiplied, which stay bounded where all decays: with x phi in the place of E, what rounding left in phi
    would grow by the ratio of the fastest rate to the slowest.
    """
    norm = float(np.abs(m).sum(axis=-1).max(initial=0.0))
    doublings = max(0, int(np.ceil(np.log2(norm / _SMALL)))) if norm > _SMALL else 0
    x = m * 2.0**-doublings
    identity = np.eye(m.shape[-1])
    phi = np.broadcast_to(identity, m.shape).copy()
    for k in range(_TERMS, 1, -1):
        phi = identity + x @ phi / k
    grown = x @ phi
    for _ in range(doublings):
        phi = phi + 0.5 * (phi @ grown)
        grown = 2.0 * grown + grown @ grown
    return grown, phi
