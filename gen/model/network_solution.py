"""The exact solution of a network's differential equations by matrix exponential, in float64.

It judges what the board computes and so shares no code with the lowering or the reference simulators. A step adds
``(exp(M h) - 1) (T + a form of the inputs)`` instead of multiplying by the exponential: increments keep their own
relative precision (see :mod:`gen.model.exact`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gen.model.dynamics import ThermalModel
from gen.model.network import Network
from gen.model.schedules import FloatArray

_CHUNK = 1 << 14
"""Matrices exponentiated at once, to bound the memory of long irregular runs."""
_SMALL = 2.0**-6
"""Norm below which the series of phi is summed."""
_TERMS = 9
"""Terms of it: the first one left out is below 2**-6**9 / 10! < 2e-23 of the first."""


class Steps(NamedTuple):
    """T += increment[k] T + ambient[k] T_ambient + heat[k]: shapes (k, n, n), (k, n), (k, n)."""

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
        assert model.network is not None
        self.model = model
        self.network: Network = model.network

    def simulate_times(
        self,
        time_s: ArrayLike,
        pwm: ArrayLike,
        ambient: ArrayLike,
        channels: Mapping[str, FloatArray] | None = None,
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
            degC, shape (N,).
        channels
            Columns in their own units, shape (N,) each; neutral where not given.
        start
            First readings by sensed node, degC; the ambient where not given. Hidden nodes rest between them.

        Returns
        -------
        dict
            Reading in degC by sensed node, shape (N,).
        """
        time = np.asarray(time_s, dtype=np.float64)
        step = np.diff(time)
        if np.any(step <= 0.0):
            raise ValueError("time must increase strictly")
        room = np.broadcast_to(np.asarray(ambient, dtype=np.float64), time.shape)
        told = {name: np.asarray(values)[:-1] for name, values in (channels or {}).items() if self._reads(name)}
        states = self.start(start or {}, float(room[0]))[None]
        out = np.empty((time.size, states.shape[1]))
        out[0] = states[0]
        names = tuple(told)
        inputs = np.column_stack([np.abs(np.asarray(pwm))[:-1].astype(np.float64), step, *(told[n] for n in names)])
        distinct, index = np.unique(inputs, axis=0, return_inverse=True)
        index = index.ravel()
        if distinct.shape[0] <= _CHUNK:
            self._march(self._steps(distinct, names), index, room, out)
        else:
            for first in range(0, index.size, _CHUNK):
                part = slice(first, min(first + _CHUNK, index.size))
                own = np.arange(part.stop - part.start)
                self._march(self._steps(inputs[part], names), own, room[part], out[part.start : part.stop + 1])
        readings = zip(self.network.sensed, self.readings, strict=True)
        return {node.name: out[:, k] + offset for node, (k, offset) in readings}

    def _reads(self, column: str) -> bool:
        return any(channel.column == column for channel in self.network.channels)

    def _steps(self, distinct: FloatArray, names: tuple[str, ...]) -> Steps:
        told = {name: distinct[:, 2 + k] for k, name in enumerate(names)}
        return self.steps(distinct[:, 0].astype(np.int64), distinct[:, 1], told)

    @staticmethod
    def _march(steps: Steps, index: NDArray[np.int64], room: FloatArray, out: FloatArray) -> None:
        state = out[0]
        for k, i in enumerate(index.tolist()):
            state = state + (steps.increment[i] @ state + steps.ambient[i] * room[k] + steps.heat[i])
            out[k + 1] = state

    @property
    def readings(self) -> list[tuple[int, float]]:
        """Of each sensed node: the position of its reading among the states, and what is added, K."""
        lagging = len(self.network.nodes)
        places = []
        for node in self.network.sensed:
            assert node.sensor is not None
            if node.sensor.lag > 0.0:
                places.append((lagging, node.sensor.offset))
                lagging += 1
            else:
                places.append((self.network.index(node.name), node.sensor.offset))
        return places

    def start(self, readings: Mapping[str, ArrayLike], ambient: ArrayLike) -> FloatArray:
        """States, shape (..., n + lagging sensors), degC, for first readings by sensed node and an ambient, degC."""
        network = self.network
        room = np.asarray(ambient, dtype=np.float64)
        shown = {node.name: np.asarray(readings.get(node.name, room), dtype=np.float64) for node in network.sensed}
        sensed = [
            shown[node.name] - (node.sensor.offset if node.sensor and node.name in readings else 0.0)
            for node in network.sensed
        ]
        given = np.stack(np.broadcast_arrays(*sensed, room), axis=-1)
        hidden = given @ network.rest_of_hidden.T
        states = np.empty((*given.shape[:-1], len(network.nodes)))
        states[..., [network.index(node.name) for node in network.sensed]] = given[..., :-1]
        states[..., [network.index(node.name) for node in network.hidden]] = hidden
        lagging = [k for k, node in enumerate(network.sensed) if node.sensor and node.sensor.lag > 0.0]
        return np.concatenate([states, given[..., lagging]], axis=-1)

    def steps(self, pwm: NDArray[np.int64], step: FloatArray, told: Mapping[str, ArrayLike] | None = None) -> Steps:
        """Step matrices of intervals.

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
        phi = _phi(m * step[:, None, None])
        return Steps(
            m * step[:, None, None] @ phi,
            np.einsum("kij,kj->ki", phi, a * step[:, None]),
            np.einsum("kij,kj->ki", phi, f * step[:, None]),
        )

    def with_sensors(self, m: FloatArray, a: FloatArray, f: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Append a state for each sensor that lags, which follows its node and takes nothing from it."""
        network = self.network
        lags = [(network.index(s.name), s.sensor.lag) for s in network.sensed if s.sensor and s.sensor.lag > 0.0]
        n, size = len(network.nodes), len(network.nodes) + len(lags)
        grown = np.zeros((m.shape[0], size, size))
        grown[:, :n, :n] = m
        for k, (node, lag) in enumerate(lags, start=n):
            grown[:, k, node], grown[:, k, k] = 1.0 / lag, -1.0 / lag
        pad = np.zeros((m.shape[0], len(lags)))
        return grown, np.concatenate([a, pad], axis=1), np.concatenate([f, pad], axis=1)


def _phi(m: FloatArray) -> FloatArray:
    """(exp(m) - 1) / m for each matrix, by its series at m / 2**s and phi(2x) = phi(x) (2 + x phi(x)) / 2."""
    norm = float(np.abs(m).sum(axis=-1).max(initial=0.0))
    doublings = max(0, int(np.ceil(np.log2(norm / _SMALL)))) if norm > _SMALL else 0
    x = m * 2.0**-doublings
    identity = np.eye(m.shape[-1])
    phi = np.broadcast_to(identity, m.shape).copy()
    for k in range(_TERMS, 1, -1):
        phi = identity + x @ phi / k
    for _ in range(doublings):
        phi = phi + 0.5 * (x @ phi) @ phi
        x = 2.0 * x
    return phi
