"""The corrected form of order 3: nothing happens at a change of PWM, so a change costs no more than new coefficients.

Adding x3 to x2 is the trapezoidal rule, whose error over a sample is -1/12 of the change of q within it
(:mod:`gen.lowering.recursion.increments`).  The carried form lets that error add up to an offset q/12 of x2 and moves
the offset when PWM changes, which takes q before and after.  Here every sample takes its own error away at once:

    x1 += x2;   x3 += q;   x2 += x3 + d          d = -(change of q)/12 = R2/12 (q + R1 (x3 + R0 x2))

Then x is a constant linear map of the true state whatever PWM does.  d is a hundred thousandth of x3, so that one per
cent of it is all that has to be known: the board takes the rates' uppermost bytes,

    d = E2 (q + E1 (x3 + E0 x2))      E2 = F/2^20, F = 344 byte(R2) >> 8;  E1 = byte(R1)/2^18;  E0 = byte(R0) cut short.

The feedback C is solved for these, so the discrete poles are exactly e^(p Ts) all the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.lowering.fixed.formats import Format, corrected_gain
from gen.lowering.recursion import increments
from gen.lowering.recursion.dynamics import Dynamics

#: The only order that has this form.
ORDER = 3
#: Rounds of tabulation: the feedback depends on the rates' uppermost bytes and these, hardly ever, on the feedback.
_ROUNDS = 4


@dataclass(frozen=True)
class Correction:
    """What d is made of at each PWM: d = on_x2 x2 + on_x3 x3 + on_q q, each of shape (rows,)."""

    on_x2: FloatArray
    on_x3: FloatArray
    on_q: FloatArray

    @classmethod
    def of(cls, layout: Format, rates: IntArray) -> Correction:
        """The board's factors for its integer rates, shape (rows, 3)."""
        last = corrected_gain(rates[:, 2]) / 2.0**20
        middle = last * (rates[:, 1] >> 24) / 2.0**18
        cut = layout.first_rate_cut
        first = (rates[:, 0] >> 24 + cut) * 2.0 ** (24 + cut - layout.rate_fraction_bits[0])
        return cls(middle * first, middle, last + middle)  # x3 is taken after q was added to it


def corrected(exact: Dynamics, correction: Correction) -> Dynamics:
    """The tables of the same differential equation for the corrected form.

    With D the difference over a sample, D x1 = x2, D x3 = q and D x2 = x3 + q + d: eliminating x2 and x3 gives the
    characteristic polynomial, from which C follows one by one.
    """
    e1, e2, eq = correction.on_x2, correction.on_x3, correction.on_q
    b3 = exact.c[:, 0]
    b2 = exact.c[:, 1] + b3
    b1 = exact.c[:, 2] + exact.c[:, 1]
    c0 = b3 / (1.0 + e2)
    c1 = (b2 - c0 * (1.0 + eq) + e1 * (b1 + e1)) / (1.0 + e2 + e1 * (1.0 + eq))
    c = np.stack([c0, c1, b1 + e1 - c1 * (1.0 + eq)], axis=1)
    form = increments.transition(c)
    form[:, 1, 1] += e1
    form[:, 1, 2] += e2
    form[:, 1, :] -= eq[:, None] * c
    constant = increments.state_map(np.zeros((1, ORDER)), 0.0)[0]
    constant[0] -= constant[2] / 12.0  # x1 without its share of q/12, which x3 adds up to as well
    return replace(exact, rates=increments.rates(c), c=c, form=form, constant_map=constant)


def tabulate(exact: Dynamics, layout: Format) -> tuple[Dynamics, IntArray]:
    """The tables and integer rates that belong together, shape (rows, 3).

    Rates are rounded from the last one on, each making up for those before it.
    """
    form, rates = exact, _rounded(exact.c, layout)
    for _ in range(_ROUNDS):
        form = corrected(exact, Correction.of(layout, rates))
        before, rates = rates, _rounded(form.c, layout)
        if np.array_equal(before >> 24, rates >> 24):
            break
    return corrected(exact, Correction.of(layout, rates)), rates


def _rounded(c: FloatArray, layout: Format) -> IntArray:
    rates = np.zeros(c.shape, dtype=np.int64)
    rest = np.ones(len(c))
    for i in reversed(range(ORDER)):
        unit = 2.0 ** layout.rate_fraction_bits[i]
        rates[:, i] = np.rint(c[:, i] / rest * unit)
        rest = rest * rates[:, i] / unit
    return rates
