"""Schedules: a coefficient as a function of the speed command |PWM|.

Every schedule can be evaluated in two ways. Calling it gives float64 arrays, quickly. Its method ``exact``
gives a `decimal.Decimal` for one integer PWM; the tables on the board are made from it, and so are
the same bytes on every machine (numpy's exponential differs in the last bit between processors).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from functools import cached_property
from typing import Literal

import numpy as np

from gen.arrays import FloatArray

Interpolation = Literal["pchip", "linear"]

EXACT = Context(prec=40, traps=[])
"""Working precision of the exact path, more than twice a float64's; an overflow gives infinity, as there."""


class Schedule(ABC):
    """A function of |PWM| in counts."""

    @abstractmethod
    def __call__(self, pwm: FloatArray) -> FloatArray:
        """Evaluate at |PWM| values.

        Parameters
        ----------
        pwm
            |PWM| in counts, any shape.

        Returns
        -------
        FloatArray
            The coefficient at these values, same shape, in the schedule's own unit.
        """

    @abstractmethod
    def exact(self, pwm: int) -> Decimal:
        """Evaluate at one integer |PWM| with a relative working precision of about 1e-40."""


@dataclass(frozen=True)
class Polynomial(Schedule):
    """A polynomial in |PWM|.

    Parameters
    ----------
    coefficients
        Highest power first.
    """

    coefficients: tuple[float, ...]

    def __call__(self, pwm: FloatArray) -> FloatArray:  # noqa: D102
        x = np.asarray(pwm, dtype=np.float64)
        return np.asarray(np.polyval(np.asarray(self.coefficients, dtype=np.float64), x), dtype=np.float64)

    def exact(self, pwm: int) -> Decimal:  # noqa: D102
        with localcontext(EXACT):
            return _horner(self.coefficients, Decimal(pwm))


@dataclass(frozen=True)
class ExponentialSum(Schedule):
    """A sum of exponentials, ``sum(a * exp(b * |PWM|))``.

    Parameters
    ----------
    terms
        Pairs (a, b); b in 1/count.
    """

    terms: tuple[tuple[float, float], ...]

    def __call__(self, pwm: FloatArray) -> FloatArray:  # noqa: D102
        x = np.asarray(pwm, dtype=np.float64)
        total = np.zeros_like(x)
        for a, b in self.terms:
            total = total + a * np.exp(b * x)
        return total

    def exact(self, pwm: int) -> Decimal:  # noqa: D102
        with localcontext(EXACT):
            return sum((Decimal(a) * (Decimal(b) * pwm).exp() for a, b in self.terms), Decimal(0))


@dataclass(frozen=True)
class Segment:
    """One interval of a table.

    Parameters
    ----------
    start, end
        The interval in PWM counts.
    coefficients
        Polynomial in ``|PWM| - start``, highest power first: 4 numbers for "pchip", 2 for "linear".
    """

    start: int
    end: int
    coefficients: tuple[float, ...]


@dataclass(frozen=True)
class Table(Schedule):
    """Values at given PWM, interpolated between them; outside the table the end value holds.

    Parameters
    ----------
    pwm
        Strictly increasing PWM counts, at least two.
    value
        As many values.
    interpolation
        "pchip" (monotone cubic, as scipy's PchipInterpolator) or "linear".
    """

    pwm: tuple[int, ...]
    value: tuple[float, ...]
    interpolation: Interpolation

    def __call__(self, pwm: FloatArray) -> FloatArray:  # noqa: D102
        x = np.clip(np.asarray(pwm, dtype=np.float64), self.pwm[0], self.pwm[-1])
        starts = np.asarray(self.pwm, dtype=np.float64)
        index = np.clip(np.searchsorted(starts, x, side="right") - 1, 0, len(self.pwm) - 2)
        # A knot gives its own value exactly, also the last one, where a segment's end would carry rounding.
        local = x - starts[index]
        rows = np.asarray([segment.coefficients for segment in self._segments], dtype=np.float64)[index]
        result = np.zeros_like(x)
        for power in range(rows.shape[-1]):
            result = result * local + rows[..., power]
        return np.asarray(np.where(x == starts[-1], self.value[-1], result), dtype=np.float64)

    def exact(self, pwm: int) -> Decimal:  # noqa: D102
        if pwm >= self.pwm[-1]:
            return Decimal(self.value[-1])
        x = max(pwm, self.pwm[0])
        segment = next(s for s in reversed(self._segments) if s.start <= x)
        with localcontext(EXACT):
            return _horner(segment.coefficients, Decimal(x - segment.start))

    def segments(self) -> tuple[Segment, ...]:
        """Give the polynomial of each interval, in the order of the table.

        Returns
        -------
        tuple of Segment
            One fewer than the table has points.
        """
        return self._segments

    @cached_property
    def _segments(self) -> tuple[Segment, ...]:
        x = np.asarray(self.pwm, dtype=np.float64)
        y = np.asarray(self.value, dtype=np.float64)
        if self.interpolation == "pchip":
            from scipy.interpolate import PchipInterpolator  # slow to import, and most files need none

            # Its harmonic mean of slopes overflows, harmlessly, where a slope is next to zero.
            with np.errstate(over="ignore"):
                columns = np.asarray(PchipInterpolator(x, y).c, dtype=np.float64)
        else:
            with np.errstate(over="ignore"):
                columns = np.stack([np.diff(y) / np.diff(x), y[:-1]])
        return tuple(
            Segment(self.pwm[i], self.pwm[i + 1], tuple(float(c) for c in columns[:, i]))
            for i in range(len(self.pwm) - 1)
        )


def _horner(coefficients: Sequence[float], x: Decimal) -> Decimal:
    result = Decimal(0)
    for coefficient in coefficients:
        result = result * x + Decimal(coefficient)
    return result
