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
from decimal import Decimal, localcontext
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gen.model.laws import Law
from gen.model.schedules import EXACT, FloatArray, Schedule

PWM_LEVELS = 256
AMBIENT = "ambient"
"""What a path to the surroundings names in the place of a node."""
PWM = "pwm"
"""The channel that every run has: PWM with its sign, counts. What reads it may depend on the direction of rotation."""


@dataclass(frozen=True)
class PowerLaw(Schedule):
    """``constant + forced * (|PWM| / full_scale) ** exponent``: forced convection grows like this with speed.

    Parameters
    ----------
    constant, forced
        In the curve's own unit.
    exponent
        Above 0.
    full_scale
        The PWM count that is 100 %.
    """

    constant: float
    forced: float
    exponent: float
    full_scale: int

    def __call__(self, pwm: FloatArray) -> FloatArray:  # noqa: D102
        share = np.asarray(pwm, dtype=np.float64) / self.full_scale
        return np.asarray(self.constant + self.forced * share**self.exponent, dtype=np.float64)

    def exact(self, pwm: int) -> Decimal:  # noqa: D102
        with localcontext(EXACT):
            if pwm == 0:
                return Decimal(self.constant)
            share = Decimal(pwm) / Decimal(self.full_scale)
            return Decimal(self.constant) + Decimal(self.forced) * share ** Decimal(self.exponent)


@dataclass(frozen=True)
class Curve:
    """A conductance or a power over |PWM|.

    Parameters
    ----------
    turning
        While the motor turns.
    at_rest
        At |PWM| 0; None where the curve holds there, too.
    """

    turning: Schedule
    at_rest: float | None = None

    def exact(self, pwm: int) -> Decimal:
        """Evaluate at one integer |PWM| with a relative working precision of about 1e-40."""
        return Decimal(self.at_rest) if pwm == 0 and self.at_rest is not None else self.turning.exact(pwm)


@dataclass(frozen=True)
class Channel:
    """A measured column that conductances or powers depend on.

    Parameters
    ----------
    column
        Of the run file.
    low, high
        Ends of the range to which its values are held, in the column's unit.
    neutral
        Its value until it is told.
    """

    column: str
    low: float
    high: float
    neutral: float


@dataclass(frozen=True)
class Factor:
    """What a channel's value multiplies a conductance or a power by.

    Parameters
    ----------
    channel
        The channel's column.
    polynomial
        In the channel's value, highest power first, of degree 3 at most; empty where a table says it.
    at, value
        Points of a table, strictly increasing, linear between them; outside of the table its end values hold.
    """

    channel: str
    polynomial: tuple[float, ...] = ()
    at: tuple[float, ...] = ()
    value: tuple[float, ...] = ()

    def __call__(self, told: ArrayLike) -> FloatArray:
        """Evaluate at the channel's values, any shape."""
        x = np.asarray(told, dtype=np.float64)
        if self.polynomial:
            # What overflows is no factor: the checks find it beyond every limit.
            with np.errstate(over="ignore", invalid="ignore"):
                return np.asarray(np.polyval(np.asarray(self.polynomial), x), dtype=np.float64)
        return np.asarray(np.interp(x, self.at, self.value), dtype=np.float64)

    @property
    def _cubic(self) -> tuple[float, ...]:
        """Coefficients of its third, second and first power."""
        return (0.0, 0.0, 0.0, *self.polynomial)[-4:-1]

    def turning_points(self, low: float, high: float) -> FloatArray:
        """Where in a range of the channel it is least and greatest, among others, shape (k,), increasing.

        Parameters
        ----------
        low, high
            Ends of the range; both are among the points.
        """
        inner = self.at or _roots(*(k * c for k, c in zip((3, 2, 1), self._cubic, strict=True)))
        return np.unique([low, *(point for point in inner if low < point < high), high])


def _roots(a: float, b: float, c: float) -> tuple[float, ...]:
    """Real roots of a x^2 + b x + c, and of a double root what rounding leaves of it; not finite where there is none.

    Neither of the two is a difference of close numbers (Press et al., Numerical Recipes, section 5.6).
    """
    with np.errstate(all="ignore"):
        a, b, c = np.array([a, b, c]) / max(abs(a), abs(b), abs(c))
        q = -0.5 * (b + np.copysign(np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0)), b))
        return float(q / a), float(c / q)


@dataclass(frozen=True)
class Sensor:
    """What stands between a node and its reading.

    Parameters
    ----------
    offset
        Reading less temperature at rest, K.
    lag
        Time constant of first order, s; 0 for none.
    """

    offset: float = 0.0
    lag: float = 0.0


@dataclass(frozen=True)
class Node:
    """A heat capacity.

    Parameters
    ----------
    name
        A C identifier.
    capacity
        J/K.
    sensor
        None for a hidden node.
    start_factor
        Of a hidden node: its rise over the ambient at the start, for each kelvin at which it would rest.
    description
        For people.
    """

    name: str
    capacity: float
    sensor: Sensor | None = None
    description: str = ""
    start_factor: float = 1.0


@dataclass(frozen=True)
class Path:
    """A way for heat between two nodes, or from a node to the ambient.

    Parameters
    ----------
    first, second
        Names of nodes; `second` is None for the ambient.
    curve
        Conductance in W/K.
    factors
        All multiply it.
    law
        What counts in the place of the difference of both temperatures; None for that difference itself.
    """

    first: str
    second: str | None
    curve: Curve
    factors: tuple[Factor, ...] = ()
    law: Law | None = None

    @property
    def label(self) -> str:
        """For messages."""
        kind = "" if self.law is None else f", {type(self.law).__name__.lower()}"
        return f"{self.first} - {self.second or AMBIENT}{kind}"


@dataclass(frozen=True)
class Heat:
    """A source of heat at a node.

    Parameters
    ----------
    node
        Its name.
    curve
        Power in W.
    factors
        All multiply it.
    per_K, reference
        It grows by this share of its value for each kelvin of the node over the reference, degC.
    """

    node: str
    curve: Curve
    factors: tuple[Factor, ...] = ()
    per_K: float = 0.0
    reference: float = 25.0


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
        self, pwm: NDArray[np.int64], told: Mapping[str, ArrayLike] | None = None
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
        self, pwm: NDArray[np.int64], path_factors: Sequence[ArrayLike], heat_factors: Sequence[ArrayLike]
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

    @cached_property
    def hidden_at_start(self) -> FloatArray:
        """Where hidden nodes start: their factor times the rise over the ambient at which they would rest.

        Returns
        -------
        FloatArray
            Weights as :attr:`rest_of_hidden` has them; the ambient's may be negative.
        """
        weights = self.rest_of_hidden.copy()
        weights[:, :-1] *= np.array([node.start_factor for node in self.hidden])[:, None]
        weights[:, -1] = 1.0 - weights[:, :-1].sum(axis=1)
        return weights

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


def _reached(inner: FloatArray, given: FloatArray) -> NDArray[np.bool_]:
    """Which unknown nodes are tied to something given, along conductances above 0."""
    reached = given > 0.0
    while True:
        further = reached | ((inner > 0.0) & reached[None, :]).any(axis=1)
        if np.array_equal(further, reached):
            return np.asarray(reached)
        reached = further
