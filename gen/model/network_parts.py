"""What a network is made of: nodes and their sensors, paths, heats, channels, and curves and factors of these."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np
from numpy.typing import ArrayLike

from gen.arrays import FloatArray
from gen.model.laws import Law
from gen.model.schedules import EXACT, Schedule

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
    """What stands between a node and its reading: the lag, then the gain's error, then the offset and the drift.

    Parameters
    ----------
    offset
        Added at last, K.
    lag
        Time constant of first order, s; 0 for none.
    gain_error
        Above -1: what is shown over the base is 1 + gain_error times what there is.
    about_ambient
        Whether that base is the ambient (a sensor that has come half off shows too little of the rise); else it is
        0 degC (an amplifier's gain).
    drift, settling
        How far the reading has moved in the end since the start, K, and with which time constant of first order, s: an
        amplifier that warms with its electronics. 0 and 0 for none.
    """

    offset: float = 0.0
    lag: float = 0.0
    gain_error: float = 0.0
    about_ambient: bool = True
    drift: float = 0.0
    settling: float = 0.0

    def base(self, ambient: ArrayLike) -> FloatArray:
        """Where the gain's error shows nothing, degC, of the ambient's shape."""
        room = np.asarray(ambient, dtype=np.float64)
        return room if self.about_ambient else np.zeros_like(room)

    def shown(self, temperature: ArrayLike, ambient: ArrayLike) -> FloatArray:
        """Give the reading of a temperature behind the lag at the start, all in degC, of shapes that fit together."""
        at = np.asarray(temperature, dtype=np.float64)
        return np.asarray(at + self.gain_error * (at - self.base(ambient)) + self.offset, dtype=np.float64)

    def temperature(self, reading: ArrayLike, ambient: ArrayLike) -> FloatArray:
        """Give the temperature at which a sensor in balance shows a reading at the start, all in degC."""
        seen = np.asarray(reading, dtype=np.float64) - self.offset
        base = self.base(ambient)
        return seen if self.gain_error == 0.0 else np.asarray(base + (seen - base) / (1.0 + self.gain_error))

    def drifted(self, elapsed_s: ArrayLike) -> FloatArray:
        """Give how far the reading has moved so long after the start, K, of any shape."""
        since = np.asarray(elapsed_s, dtype=np.float64)
        return np.zeros_like(since) if self.drift == 0.0 else -self.drift * np.expm1(-since / self.settling)


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
    start_from
        Of a hidden node: its rise over the ambient at the start, for each kelvin of each sensed node's, instead of that
        at which it would rest.
    """

    name: str
    capacity: float
    sensor: Sensor | None = None
    description: str = ""
    start_factor: float = 1.0
    start_from: tuple[tuple[str, float], ...] | None = None


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
        by = "".join(f", by {factor.channel}" for factor in self.factors)
        return f"{self.first} - {self.second or AMBIENT}{kind}{by}"


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
