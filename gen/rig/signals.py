"""Inputs over time: ambient temperature, load, supply voltage, airflow."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

#: A constant, or a function of the time in s.
Signal = float | Callable[[float], float]


def value(signal: Signal, time_s: float) -> float:
    """Value of a signal at a time."""
    return signal(time_s) if callable(signal) else signal


def drift(start: float, per_hour: float) -> Signal:
    """Change at a constant rate."""
    return lambda t: start + per_hour * t / 3600.0


def sine(mean: float, amplitude: float, period_s: float = 86_400.0, phase_s: float = 0.0) -> Signal:
    """Swing around a mean, by default once a day."""
    return lambda t: mean + amplitude * math.sin(2.0 * math.pi * (t - phase_s) / period_s)


def steps(first: float, changes: Sequence[tuple[float, float]]) -> Signal:
    """Hold `first`, then from each ``(time_s, value)`` that value; times increasing."""
    ordered = tuple(changes)

    def at(t: float) -> float:
        now = first
        for start, level in ordered:
            if t < start:
                break
            now = level
        return now

    return at


def door(mean: float, drop: float, opened_s: float, closed_s: float, lag_s: float = 120.0) -> Signal:
    """Fall towards ``mean - drop`` while a door is open, and come back when it is closed, with a time constant."""
    fallen = drop * -math.expm1(-(closed_s - opened_s) / lag_s)

    def at(t: float) -> float:
        if t <= opened_s:
            return mean
        if t <= closed_s:
            return mean + drop * math.expm1(-(t - opened_s) / lag_s)
        return mean - fallen * math.exp(-(t - closed_s) / lag_s)

    return at


def total(*signals: Signal) -> Signal:
    """Sum of signals."""
    return lambda t: sum(value(signal, t) for signal in signals)
