"""Steps of a time: how even they are, and which are plain in minutes or hours, and in seconds are not."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray

_EVEN = 0.8
"""Of the steps, those that are alike in a log whose rows come at one interval."""
_ALIKE = 0.05
"""Of the usual step, by which even ones differ."""
_MOST_DECIMALS = 9
_UNITS = (("min", 60.0, 4.0), ("h", 3600.0, 1.0))
"""Seconds in it, and how many parts of a second a plain step may have."""


def evenness(steps: FloatArray) -> float:
    """Which share of steps is the usual one.

    Parameters
    ----------
    steps
        From row to row, shape (n,).
    """
    usual = float(np.median(steps))
    return float((np.abs(steps - usual) <= _ALIKE * abs(usual)).mean()) if usual > 0 else 0.0


def plainer_unit(values: FloatArray) -> tuple[str, str]:
    """The unit in which even steps are plain, where they are not in seconds; and why. Both empty without one.

    A step of 1/6 is 10 s in minutes, one of 0.00278 is 10 s in hours, and no logger takes either in seconds.

    Parameters
    ----------
    values
        Finite, of a column that rises, shape (n,).
    """
    step, error = _even_step(values)
    if not step or _is_short(step, error):
        return "", ""
    for name, seconds, parts in _UNITS:
        in_seconds, slack = step * seconds, max(error * seconds, 1e-6 * step * seconds)
        whole = round(in_seconds * parts)
        if slack * parts < 0.05 and whole >= 1 and abs(in_seconds * parts - whole) <= slack * parts:
            return name, f"steps of {step:.4g}, which are {whole / parts:g} s in {name}"
    return "", ""


def _even_step(values: FloatArray) -> tuple[float, float]:
    """The interval of rows that come evenly, and how far rounding may have put it off; zeros where they do not."""
    steps = np.diff(values)
    rising = steps[steps > 0]
    if rising.size < 3:
        return 0.0, 0.0
    last_digit = 10.0 ** -_decimals(values)
    usual = float(np.median(rising))
    alike = np.abs(rising - usual) <= 1.01 * last_digit + 1e-9 * usual
    if alike.mean() < _EVEN:
        return 0.0, 0.0
    return float(rising[alike].mean()), last_digit / float(alike.sum())


def _decimals(values: FloatArray) -> int:
    """Digits behind the point that all numbers have at most."""
    return next(
        (d for d in range(_MOST_DECIMALS) if np.allclose(values, np.round(values, d), rtol=1e-12, atol=1e-11)),
        _MOST_DECIMALS,
    )


def _is_short(step: float, error: float) -> bool:
    """Whether three digits say the step, as those that people choose."""
    digits = 10.0 ** (2 - np.floor(np.log10(step)))
    return bool(abs(step * digits - round(step * digits)) <= max(error, 1e-9 * step) * digits)
