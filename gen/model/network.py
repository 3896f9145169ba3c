"""A motor as one thermal network: heat capacities, paths between them and to the ambient, heats, sensors.

    C_i dT_i/dt = sum_j G_ij (T_j - T_i) + G_i0 (T_ambient - T_i) + sum P (1 + k (T_i - T_reference))

On a path with a law (:mod:`gen.model.laws`) that of both temperatures stands in the place of their difference.
Temperatures are absolute, in degC. Conductances and powers depend on |PWM| by a curve, and on channels by factors.
The matrix of such a system has no negative entry off its diagonal, whatever the speed and the channels say; what is
proven of it rests on that (:mod:`gen.lowering.network`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.model.laws import Law
from gen.model.network_parts import Channel, Curve, Factor, Heat, Node, Path

PWM_LEVELS = 256
NEAR = 0.5
"""Weight in what a hidden node follows, over the largest, from which a sensed one is near it."""


@dataclass(frozen=True)
class Network:
    """Nodes, what joins them, what heats them, and what is measured beside them.

    Parameters
    ----------
    nodes, paths, heats, channels
        In the order of the file.
    held
        The |PWM| range outside of which curves keep their value at its nearer end; None: they are continued.
    """

    nodes: tuple[Node, ...]
    paths: tuple[Path, ...]
    heats: tuple[Heat, ...]
    channels: tuple[Channel, ...] = ()
    held: tuple[int, int] | None = None

    @property
    def sensed(self) -> tuple[Node, ...]:
        """Nodes with a sensor: the components."""
        return tuple(node for node in self.nodes if node.sensor is not None)

    @property
    def hidden(self) -> tuple[Node, ...]:
        """Nodes without."""
        return tuple(node for node in self.nodes if node.sensor is None)

    @property
    def laws(self) -> tuple[tuple[int, Law], ...]:
        """The paths with a law: their positions, and the law."""
        return tuple((number, path.law) for number, path in enumerate(self.paths) if path.law is not None)

    def index(self, name: str) -> int:
        """Position of a node among the nodes."""
        return self._positions[name]

    @cached_property
    def _positions(self) -> dict[str, int]:
        return {node.name: number for number, node in enumerate(self.nodes)}

    @cached_property
    def capacities(self) -> FloatArray:
        """Of the nodes, J/K, shape (n,)."""
        return np.array([node.capacity for node in self.nodes])

    @cached_property
    def conductances(self) -> FloatArray:
        """Of each path at each |PWM| 0..255, every factor 1, W/K, shape (256, paths)."""
        return self._over_pwm([path.curve for path in self.paths])

    @cached_property
    def powers(self) -> FloatArray:
        """Of each heat at each |PWM| 0..255, every factor 1 and the node at the reference, W, shape (256, heats)."""
        return self._over_pwm([heat.curve for heat in self.heats])

    def _over_pwm(self, curves: list[Curve]) -> FloatArray:
        """Correctly rounded, so that it is the same on every machine."""
        made = np.empty((PWM_LEVELS, len(curves)))
        for x in range(PWM_LEVELS):
            made[x] = [float(curve.exact(self._within(x, curve))) for curve in curves]
        return made

    def _within(self, pwm: int, curve: Curve) -> int:
        if self.held is None or (pwm == 0 and curve.at_rest is not None):
            return pwm
        return min(max(pwm, self.held[0]), self.held[1])

    def factor_values(
        self, factors: tuple[Factor, ...], told: Mapping[str, ArrayLike], shape: tuple[int, ...]
    ) -> FloatArray:
        """Product of factors at told values, each held to its channel's range; 1 without any.

        Parameters
        ----------
        factors
            Of a path or a heat.
        told
            A value for every channel, in its column's unit: a number, or of that shape.
        shape
            Of the result.
        """
        product = np.ones(shape)
        for factor in factors:
            channel = self.channel(factor.channel)
            held = np.clip(np.asarray(told[factor.channel], dtype=np.float64), channel.low, channel.high)
            product = product * factor(held)
        return product

    def channel(self, column: str) -> Channel:
        """The channel that reads a column, which must be there."""
        return next(channel for channel in self.channels if channel.column == column)

    def neutral(self) -> dict[str, float]:
        """Every channel's value until it is told."""
        return {channel.column: channel.neutral for channel in self.channels}

    def matrices(
        self, pwm: IntArray, told: Mapping[str, ArrayLike] | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give dT/dt = M T + a T_ambient + f at some moments, every law being the difference of both temperatures.

        Parameters
        ----------
        pwm
            Integer |PWM|, shape (k,), 0..255.
        told
            Values of the channels, numbers or shape (k,) each; neutral where not given.

        Returns
        -------
        M, a, f
            Shapes (k, n, n) in 1/s, (k, n) in 1/s, (k, n) in K/s.
        """
        values = {**self.neutral(), **(told or {})}
        shape = pwm.shape
        path_factors = [self.factor_values(path.factors, values, shape) for path in self.paths]
        heat_factors = [self.factor_values(heat.factors, values, shape) for heat in self.heats]
        return self.matrices_with(pwm, path_factors, heat_factors)

    def matrices_with(
        self, pwm: IntArray, path_factors: Sequence[ArrayLike], heat_factors: Sequence[ArrayLike]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the same for given factors, whatever the channels.

        Parameters
        ----------
        pwm
            Integer |PWM|, shape (k,), 0..255.
        path_factors, heat_factors
            What multiplies each conductance and each power, a number or shape (k,) each.

        Returns
        -------
        M, a, f
            As :meth:`matrices`.
        """
        shape = pwm.shape
        n = len(self.nodes)
        m, a, f = np.zeros((*shape, n, n)), np.zeros((*shape, n)), np.zeros((*shape, n))
        for number, path in enumerate(self.paths):
            conductance = self.conductances[pwm, number] * path_factors[number]
            i = self.index(path.first)
            m[..., i, i] -= conductance / self.capacities[i]
            if path.second is None:
                a[..., i] += conductance / self.capacities[i]
                continue
            j = self.index(path.second)
            m[..., i, j] += conductance / self.capacities[i]
            m[..., j, j] -= conductance / self.capacities[j]
            m[..., j, i] += conductance / self.capacities[j]
        for number, heat in enumerate(self.heats):
            power = self.powers[pwm, number] * heat_factors[number]
            i = self.index(heat.node)
            m[..., i, i] += power * heat.per_K / self.capacities[i]
            f[..., i] += power * (1.0 - heat.per_K * heat.reference) / self.capacities[i]
        return m, a, f

    def near(self, name: str) -> tuple[str, ...]:
        """Sensed nodes that a hidden one would follow most, the first one most; none for another name."""
        hidden = [node.name for node in self.hidden]
        if name not in hidden:
            return ()
        weights = self.rest_of_hidden[hidden.index(name), :-1]
        order = np.argsort(-weights, kind="stable")
        return tuple(self.sensed[k].name for k in order if weights[k] > max(NEAR * weights.max(), 0.0))

    @cached_property
    def hidden_at_start(self) -> FloatArray:
        """Where hidden nodes start: their factor times the rise over the ambient that the file, or rest, lets expect.

        Returns
        -------
        FloatArray
            Weights as :attr:`rest_of_hidden` has them; the ambient's may be negative.
        """
        rises = self.expected_at_start * np.array([node.start_factor for node in self.hidden])[:, None]
        return np.column_stack([rises, 1.0 - rises.sum(axis=1)])

    @cached_property
    def expected_at_start(self) -> FloatArray:
        """What share of each sensed node's rise hidden nodes have at the start, but for their factor.

        Returns
        -------
        FloatArray
            Shape (hidden, sensed): what the file says, and else that at which they would rest.
        """
        rises = self.rest_of_hidden[:, :-1].copy()
        names = [node.name for node in self.sensed]
        for row, node in zip(rises, self.hidden, strict=True):
            if node.start_from is not None:
                said = dict(node.start_from)
                row[:] = [said.get(name, 0.0) for name in names]
        return rises

    @cached_property
    def rest_of_hidden(self) -> FloatArray:
        """Where hidden nodes rest at PWM 0 between sensed ones and the ambient, no heat acting, laws as in `matrices`.

        Returns
        -------
        FloatArray
            Weights, shape (hidden, sensed + 1), the ambient's last; each row has the sum 1. A node that nothing of
            these reaches rests at the ambient.
        """
        known = [self.index(node.name) for node in self.sensed]
        unknown = [self.index(node.name) for node in self.hidden]
        m, a, _ = self.matrices(np.zeros(1, dtype=np.int64))
        laplacian = m[0] * self.capacities[:, None]
        np.fill_diagonal(laplacian, 0.0)
        to_ambient = a[0] * self.capacities
        weights = np.zeros((len(unknown), len(known) + 1))
        if not unknown:
            return weights
        inner = laplacian[np.ix_(unknown, unknown)]
        right = np.column_stack([laplacian[np.ix_(unknown, known)], to_ambient[unknown]])
        system = np.diag(inner.sum(axis=1) + right.sum(axis=1)) - inner
        reached = _reached(inner, right.sum(axis=1))
        weights[:, -1] = 1.0
        if reached.any():
            weights[reached] = np.linalg.solve(system[np.ix_(reached, reached)], right[reached])
        return np.asarray(weights / weights.sum(axis=1, keepdims=True), dtype=np.float64)


def _reached(inner: FloatArray, given: FloatArray) -> BoolArray:
    """Which unknown nodes are tied to something given, along conductances above 0."""
    reached = given > 0.0
    while True:
        further = reached | ((inner > 0.0) & reached[None, :]).any(axis=1)
        if np.array_equal(further, reached):
            return np.asarray(reached)
        reached = further
