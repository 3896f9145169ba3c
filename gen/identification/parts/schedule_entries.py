"""From a general model to the schedules of a coefficient file."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray
from gen.coefficients.document import ComponentEntry, PoleEntry
from gen.coefficients.schedule import Exp1, Points, Poly, ScheduleEntry, Tabulated
from gen.identification.parts.forms import FULL
from gen.identification.parts.joint import Model
from gen.model import Table

SAME = 1e-6
"""A polynomial or exponential stands for a curve when it is this close, relative to the largest value."""
CLOSE = 2e-4
"""A table's interpolation may differ from the curve by this share of it."""


def component_entry(name: str, model: Model, low: int, high: int) -> ComponentEntry:
    """Give one component of the coefficient file.

    Parameters
    ----------
    name
        The component.
    model
        Its general model.
    low, high
        |PWM| range over which the curves are written; the file's own rule goes on outside of it.
    """
    pwm = np.arange(low, high + 1, dtype=np.float64)
    theta, steady = model.evaluate(np.maximum(pwm, 1e-3))
    poles = np.asarray(model.shape.structure.poles(theta), dtype=np.complex128)
    gain = steady / np.maximum(pwm, 1e-3) * np.abs(np.prod(poles, axis=1))
    entries = [_pole(pwm, pole) for pole in poles.T]
    return ComponentEntry(name=name, order=len(entries), gain=schedule_entry(pwm, gain), poles=tuple(entries))


def _pole(pwm: FloatArray, pole: NDArray[np.complex128]) -> PoleEntry:
    real = schedule_entry(pwm, pole.real)
    if np.any(np.abs(pole.imag) > 1e-12):
        return PoleEntry(real=real, imag=schedule_entry(pwm, pole.imag))
    return PoleEntry(real=real)


def schedule_entry(pwm: FloatArray, value: FloatArray) -> ScheduleEntry:
    """Find the simplest schedule for a curve that is given at every |PWM|.

    Parameters
    ----------
    pwm
        Consecutive counts, shape (m,).
    value
        Shape (m,).

    Returns
    -------
    ScheduleEntry
        A polynomial up to degree 3, one exponential, or a table that pchip interpolates.
    """
    scale = float(np.max(np.abs(value))) or 1.0
    if len(pwm) == 1:
        return Poly(poly=(_short(value[0]),))
    for degree in range(4):
        if degree >= len(pwm):
            break
        coefficients = np.polyfit(pwm / FULL, value / scale, degree)
        if np.max(np.abs(np.polyval(coefficients, pwm / FULL) - value / scale)) < SAME:
            powers = FULL ** np.arange(degree, -1, -1)
            return Poly(poly=tuple(_short(c) for c in coefficients * scale / powers))
    if np.all(value * value[0] > 0.0):
        slope, log = np.polyfit(pwm, np.log(np.abs(value)), 1)
        if np.max(np.abs(np.exp(log + slope * pwm) / np.abs(value) - 1.0)) < SAME:
            return Exp1(exp1=(_short(np.copysign(np.exp(log), value[0])), _short(slope)))
    nodes = _nodes(pwm, value, scale)
    return Tabulated(
        table=Points(
            pwm=tuple(int(x) for x in pwm[nodes]),
            value=tuple(_short(v) for v in value[nodes]),
            interpolation="pchip",
        )
    )


def _nodes(pwm: FloatArray, value: FloatArray, scale: float) -> list[int]:
    """Add the worst place to the table until it is close everywhere."""
    nodes = [0, len(pwm) - 1]
    while len(nodes) < len(pwm):
        table = Table(tuple(int(x) for x in pwm[nodes]), tuple(float(v) for v in value[nodes]), "pchip")
        gap = np.abs(table(pwm) - value) / (np.abs(value) + 1e-3 * scale)
        if np.max(gap) < CLOSE:
            break
        nodes = sorted({*nodes, int(np.argmax(gap))})
    return nodes


def _short(value: float) -> float:
    """Ten significant digits: far below any uncertainty, and readable."""
    return float(f"{float(value):.10g}") + 0.0
