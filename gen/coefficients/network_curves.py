"""Curves of a network's entry from numbers, and numbers from curves."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients.network import CurveEntry, TableCurve, model_curve
from gen.coefficients.schedule import Points

POINT = 5
"""Distance of a table's points, counts: pchip through them is within 1e-4 of the curve."""


def points_of(full_scale: int) -> IntArray:
    """Give the |PWM| of a table's points, from 0 to full scale."""
    return np.unique([*range(0, full_scale, POINT), full_scale])


def tabulated(pwm: IntArray, value: FloatArray, at_rest: float) -> TableCurve:
    """Give a curve through points, with a value of its own at rest.

    Parameters
    ----------
    pwm, value
        Of the points, shape (k,).
    at_rest
        At |PWM| 0.
    """
    points = Points(
        pwm=tuple(int(x) for x in pwm), value=tuple(six_digits(float(y)) for y in value), interpolation="pchip"
    )
    return TableCurve(table=points, at_rest=six_digits(at_rest))


def values_of(curve: CurveEntry, pwm: IntArray, full_scale: int) -> tuple[FloatArray, float]:
    """Give a curve's values while the motor turns at |PWM|, shape (k,), and its value at rest."""
    known = model_curve(curve, full_scale)
    turning = known.turning(np.asarray(pwm, dtype=np.float64))
    at_rest = known.at_rest if known.at_rest is not None else float(known.turning(np.zeros(1))[0])
    return turning, at_rest


def six_digits(value: float) -> float:
    """Round to the digits that are written."""
    return float(f"{value:.6g}")
