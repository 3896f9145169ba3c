"""The real-valued tables of one component over its domain: what lowering approximates and proofs refer to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, floor

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.lowering.recursion import increments
from gen.lowering.recursion.reach import SwitchedRecursion
from gen.model import Component, ThermalModel

#: How much of the way to the middle of what x1 settles to the centre lies where the ambient moves: a wider drive counts
#: for more than a wider start. Any is right; which gives the smallest bound differs, and they are tried in this order.
TOWARDS_SETTLED = (0.3, 0.1)


class LoweringError(Exception):
    """A component cannot be lowered; the message names it."""


@dataclass(frozen=True, eq=False)
class Dynamics:
    """Real-valued tables of one component over its domain, and the recursion that they drive.

    Attributes
    ----------
    rates, c, steady
        Shapes (rows, n), (rows, n), (rows,): the exact values that the integers approximate.
    form, exact
        One (sub)sample of the increment form and of the differential equation, shape (rows, n, n).
    start
        Lowest and highest rise from which the board may start, in K.
    constant_map
        How the true state becomes the board's where PWM has no part in it, shape (n, n); None for the carried form.
    over
        Lowest and highest ambient over the temperature that rises count from, in K: it is added to the steady rise.
    towards_settled
        One of :data:`TOWARDS_SETTLED`.
    """

    rates: FloatArray
    c: FloatArray
    steady: FloatArray
    form: FloatArray
    exact: FloatArray
    start: tuple[float, float]
    constant_map: FloatArray | None = None
    over: tuple[float, float] = (0.0, 0.0)
    towards_settled: float = TOWARDS_SETTLED[0]

    @property
    def start_range_mK(self) -> tuple[int, int]:
        """The same in thousandths of a kelvin, rounded inwards."""
        return ceil(self.start[0] * 1000.0), floor(self.start[1] * 1000.0)

    @property
    def order(self) -> int:
        """The component's order n."""
        return int(self.rates.shape[1])

    @property
    def recursion(self) -> SwitchedRecursion:
        """What encloses everything that :attr:`exact` can reach.

        Raises
        ------
        NoProofError
            If nothing is found that encloses it.
        """
        return _recursion(self)

    def state_maps(self, carry: float = increments.CARRY) -> FloatArray:
        """The matrices M(p) of :func:`gen.lowering.recursion.increments.state_map`, shape (rows, n, n)."""
        if self.constant_map is None:
            return increments.state_map(self.c, carry)
        return np.tile(self.constant_map, (len(self.c), 1, 1))

    @property
    def centre(self) -> float:
        """Middle of everything that x1 starts from or settles to, in K.

        Where the ambient moves what it settles to comes from both sides, and lies more in the middle.
        """
        settled = float(self.steady.min()) + self.over[0], float(self.steady.max()) + self.over[1]
        middle = (min(self.start[0], settled[0]) + max(self.start[1], settled[1])) / 2.0
        if self.over == (0.0, 0.0):
            return middle
        return middle + self.towards_settled * ((settled[0] + settled[1]) / 2.0 - middle)

    @property
    def away(self) -> FloatArray:
        """How far x1 may settle from the centre at each |PWM|, whatever the ambient, in K, shape (rows,)."""
        found: FloatArray = np.maximum(
            np.abs(self.steady + self.over[0] - self.centre), np.abs(self.steady + self.over[1] - self.centre)
        )
        return found

    @property
    def over_range_mK(self) -> tuple[int, int]:
        """:attr:`over` in thousandths of a kelvin, rounded outwards."""
        return floor(self.over[0] * 1000.0), ceil(self.over[1] * 1000.0)


def domain_rows(model: ThermalModel) -> IntArray:
    """|PWM| of each row of the tables."""
    lo, hi = model.domain_pwm
    return np.arange(lo, hi + 1)


#: For each number of substeps; an order 4 takes 40 MB.
@lru_cache(maxsize=4)
def _recursion(exact: Dynamics) -> SwitchedRecursion:
    return SwitchedRecursion(exact.exact)


@lru_cache(maxsize=16)
def dynamics(
    model: ThermalModel, component: Component, substeps: int, towards_settled: float = TOWARDS_SETTLED[0]
) -> Dynamics:
    """Tabulate a component's exact coefficients for a sample cut into ``substeps``.

    Raises
    ------
    LoweringError
        If a nested rate is not positive (poles too fast or oscillating too strongly for the sample time).
    """
    rows = domain_rows(model)
    denominator = component.denominator(rows)
    step = model.sample_time / substeps
    c = increments.feedback(increments.delta_polynomial(denominator, step))
    rates = increments.rates(c)
    if not np.all(rates > 0.0) or not np.all(rates < 1.0):
        row = int(np.argmax(np.any((rates <= 0.0) | (rates >= 1.0), axis=1)))
        raise LoweringError(
            f"component {component.name}: at PWM {rows[row]} the poles are too fast for a sample time of "
            f"{model.sample_time} s"
        )
    return Dynamics(
        rates=rates,
        c=c,
        steady=component.steady_rise(rows),
        form=increments.transition(c),
        exact=increments.exact_transition(denominator, step),
        start=_starts(model),
        over=model.ambient_over,
        towards_settled=towards_settled,
    )


def _starts(model: ThermalModel) -> tuple[float, float]:
    """Lowest and highest rise to start from, in K: over the ambient, or over the reference where the ambient moves."""
    low, high = model.domain_temperature
    if not model.ambient_passes:
        return low - model.domain_ambient[1], high - model.domain_ambient[0]
    coldest, warmest = model.ambient_told
    return min(low, coldest) - model.ambient_reference, max(high, warmest) - model.ambient_reference
