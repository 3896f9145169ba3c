"""What a model must satisfy at every |PWM| of its domain before anything is built from it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.errors import InputError
from gen.model.dynamics import Component, ThermalModel
from gen.model.schedules import Schedule, Table

FASTEST = 0.1
"""Largest |pole| times sample time. Beyond it the sampled step no longer resembles the motor: a thermal
time constant under ten samples is a wrong unit, not physics, and fixed-point forms rely on slow poles."""

HIGHEST = 5000.0
"""Highest steady rise in K: no motor survives a tenth of it, so beyond it a unit is wrong."""

DROPPED = 0.2
"""Warn where real(poly(poles)) drops an imaginary part over this share of a coefficient. The study's brush,
whose pair is fitted separately, reaches 0.065; at 0.2 the roots of A are no longer the poles of the file."""


def check_model(model: ThermalModel) -> tuple[str, ...]:
    """Check stability, speed and gain at every integer |PWM| of the domain.

    Returns
    -------
    tuple of str
        Warnings.

    Raises
    ------
    InputError
        With the JSON path; the message names component and PWM.
    """
    lo, hi = model.domain_pwm
    pwm = np.arange(lo, hi + 1)
    warnings: list[str] = []
    for index, component in enumerate(model.components):
        place = f"$.components[{index}]"
        _check_finite(component, pwm, place)
        _check_poles(component, pwm, model.sample_time, f"{place}.poles")
        warnings += _check_gain(component, pwm, f"{place}.gain")
        _check_rise(component, pwm, f"{place}.gain")
        warnings += _check_dropped(component, pwm, f"{place}.poles")
        warnings += _check_tables(component, model, place)
    return tuple(warnings)


def _check_finite(component: Component, pwm: IntArray, place: str) -> None:
    parts = (("gain", component.raw_gain(pwm)[:, None]), ("poles", component.denominator(pwm)))
    for key, values in parts:
        bad = ~np.isfinite(values).all(axis=1)
        if bad.any():
            raise InputError(
                f'component "{component.name}" overflows a 64-bit float at PWM {pwm[bad][0]}; expected a finite value',
                place=f"{place}.{key}",
            )


def _check_poles(component: Component, pwm: IntArray, sample_time: float, place: str) -> None:
    a = component.denominator(pwm)
    roots = _roots(component, pwm)
    unstable = ~_hurwitz(a)
    if unstable.any():
        at = int(np.argmax(unstable))
        worst = roots[at][np.argmax(roots[at].real)]
        raise InputError(
            f'component "{component.name}" is unstable at PWM {pwm[at]}: pole {_complex(worst)} rad/s; '
            "expected a negative real part everywhere in the domain",
            place=place,
        )
    speed = np.abs(roots).max(axis=1) * sample_time
    if speed.max() > FASTEST:
        at = int(np.argmax(speed))
        worst = roots[at][np.argmax(np.abs(roots[at]))]
        raise InputError(
            f'component "{component.name}" is too fast for the sample time of {sample_time:g} s '
            f"at PWM {pwm[at]}: pole {_complex(worst)} rad/s; "
            f"expected at most {FASTEST / sample_time:g} rad/s in magnitude",
            place=place,
        )


def _hurwitz(a: FloatArray) -> BoolArray:
    """Decide stability by Hurwitz's determinants, which need no iteration; a is monic, of order 1..4."""
    stable = (a > 0.0).all(axis=1)
    order = a.shape[1] - 1
    with np.errstate(over="ignore", invalid="ignore"):  # poles beyond 1e100 1/s are refused for the sample time
        if order == 3:
            stable &= a[:, 1] * a[:, 2] > a[:, 3]
        if order == 4:
            stable &= a[:, 1] * a[:, 2] * a[:, 3] > a[:, 3] ** 2 + a[:, 1] ** 2 * a[:, 4]
    return np.asarray(stable)


def _roots(component: Component, pwm: IntArray) -> NDArray[np.complex128]:
    matrices, _ = component.state_matrices(pwm)
    # Balance first: entries of 1 beside 1e-12 would cost the small roots their digits.
    rate = np.maximum(np.abs(component.denominator(pwm)[:, -1]), 1e-300) ** (1.0 / component.order)
    scale = rate[:, None] ** np.arange(component.order)
    balanced = matrices * (scale[:, None, :] / scale[:, :, None])
    return np.asarray(np.linalg.eigvals(balanced), dtype=np.complex128)


def _check_gain(component: Component, pwm: IntArray, place: str) -> list[str]:
    # At PWM 0 the gain multiplies zero, so its sign there means nothing.
    negative = pwm[(component.raw_gain(pwm) < 0.0) & (pwm > 0)]
    lo, hi = component.validity
    inside = negative[(negative >= lo) & (negative <= hi)]
    if inside.size:
        value = component.raw_gain(inside[:1])[0]
        raise InputError(
            f'component "{component.name}": the gain is {value:.4g} at PWM {inside[0]}, '
            f"inside the validity range {lo}..{hi}; expected a gain that is not negative there",
            place=place,
        )
    if not negative.size:
        return []
    where = (
        f'component "{component.name}": the gain is negative at PWM {spans(negative)}, '
        f"outside the validity range {lo}..{hi}"
    )
    if component.negative_gain is None:
        raise InputError(
            f'{where}; add "negative_gain": "zero" to this component to take it as 0 there, '
            'or choose "hold" outside the validity range',
            place=place,
        )
    return [f"{place}: {where}; it is taken as 0 there, and the firmware flags it"]


def _check_rise(component: Component, pwm: IntArray, place: str) -> None:
    with np.errstate(over="ignore"):
        rise = component.steady_rise(pwm)
    at = int(np.argmax(rise))
    if not rise[at] <= HIGHEST:
        raise InputError(
            f'component "{component.name}" settles {rise[at]:.4g} K over ambient at PWM {pwm[at]}; '
            f"expected at most {HIGHEST:g} K: the units of gain and poles do not fit together",
            place=place,
        )


def _check_dropped(component: Component, pwm: IntArray, place: str) -> list[str]:
    share = np.abs(component.dropped_imaginary(pwm)[:, 1:]) / component.denominator(pwm)[:, 1:]
    worst = share.max(axis=1)
    if worst.max() <= DROPPED:
        return []
    at = int(np.argmax(worst))
    return [
        f'{place}: component "{component.name}": the poles are far from conjugate pairs; '
        f"at PWM {pwm[at]} the dropped imaginary part is {worst[at]:.0%} of the coefficient that is kept"
    ]


def _check_tables(component: Component, model: ThermalModel, place: str) -> list[str]:
    warnings = (table_warning(schedule, model.validity, f"{place}.{key}") for key, schedule in _schedules(component))
    return [warning for warning in warnings if warning is not None]


def table_warning(schedule: Schedule, validity: tuple[int, int], place: str) -> str | None:
    """Say of a table that it does not cover the validity range; None of one that does, and of every other schedule."""
    lo, hi = validity
    if not isinstance(schedule, Table) or (schedule.pwm[0] <= lo and schedule.pwm[-1] >= hi):
        return None
    return (
        f"{place}: the table covers PWM {schedule.pwm[0]}..{schedule.pwm[-1]} only; "
        f"in the rest of the validity range {lo}..{hi} its end values hold"
    )


def _schedules(component: Component) -> list[tuple[str, Schedule]]:
    result = [("gain", component.gain)]
    for i, pole in enumerate(component.poles):
        result.append((f"poles[{i}].real", pole.real))
        if pole.imag is not None:
            result.append((f"poles[{i}].imag", pole.imag))
    return result


def spans(values: IntArray) -> str:
    """Write sorted integers as ``1..2, 7``."""
    runs = np.split(values, np.flatnonzero(np.diff(values) > 1) + 1)
    return ", ".join(f"{run[0]}" if run.size == 1 else f"{run[0]}..{run[-1]}" for run in runs)


def _complex(value: complex) -> str:
    real = value.real + 0.0  # not "-0"
    if value.imag == 0.0:
        return f"{real:.4g}"
    return f"{real:.4g} {'+' if value.imag > 0 else '-'} {abs(value.imag):.4g}j"
