"""The coefficients as the file's text defines them, in decimal arithmetic: a second reading, for the exact solution.

Nothing of `gen` is used here: a schedule that the generator misreads must not be misread again by its judge.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from typing import Any

DIGITS = Context(prec=60)
"""Working precision."""

Entry = Mapping[str, Any]


@dataclass(frozen=True)
class Coefficients:
    """One component at one |PWM|.

    Attributes
    ----------
    denominator
        a1..an of A(s) = s^n + a1 s^(n-1) + .. + an, in 1/s^k.
    steady
        The rise at which it settles, in K.
    """

    denominator: tuple[Decimal, ...]
    steady: Decimal


def domain(document: Entry) -> range:
    """Every |PWM| of the declared domain."""
    low, high = document["domain"]["pwm"]
    return range(low, high + 1)


def coefficients(document: Entry, component: Entry, pwm: int) -> Coefficients:
    """What a coefficient file says of a component at one |PWM|."""
    low, high = document["validity"]["pwm"]
    at = min(max(pwm, low), high) if document["validity"]["outside"] == "hold" else pwm
    with localcontext(DIGITS):
        poly = [(Decimal(1), Decimal(0))]
        for pole in component["poles"]:
            imaginary = value(pole["imag"], at) if pole.get("imag") else Decimal(0)
            poly = _times(poly, value(pole["real"], at), imaginary)
        gain = value(component["gain"], at)
        if component.get("negative_gain") == "zero" and gain < 0 and not low <= pwm <= high:
            gain = Decimal(0)
        denominator = tuple(real for real, _ in poly[1:])
        return Coefficients(denominator, gain * pwm / denominator[-1])


def value(entry: Entry, pwm: int) -> Decimal:
    """A schedule's value at one |PWM|."""
    ((kind, given),) = entry.items()
    with localcontext(DIGITS):
        if kind == "poly":
            total = Decimal(0)
            for number in given:
                total = total * pwm + Decimal(number)
            return total
        if kind in ("exp1", "exp2"):
            pairs = zip(given[::2], given[1::2], strict=True)
            return sum((Decimal(a) * (Decimal(b) * pwm).exp() for a, b in pairs), Decimal(0))
        if kind == "table":
            return _interpolated(given, pwm)
    raise ValueError(f"unknown schedule {kind}")


def _interpolated(table: Entry, pwm: int) -> Decimal:
    """Linear, or the cubic of Fritsch and Butland (1984) as scipy has it; constant outside of the table."""
    x, y = table["pwm"], [Decimal(number) for number in table["value"]]
    if pwm <= x[0] or pwm >= x[-1]:
        return y[0] if pwm <= x[0] else y[-1]
    i = max(j for j in range(len(x) - 1) if x[j] <= pwm)
    width, t = Decimal(x[i + 1] - x[i]), Decimal(pwm - x[i])
    t /= width
    if table.get("interpolation", "pchip") == "linear":
        return y[i] + (y[i + 1] - y[i]) * t
    slopes = _slopes(x, y)
    square, cube = t * t, t * t * t
    return (
        y[i] * (2 * cube - 3 * square + 1)
        + y[i + 1] * (3 * square - 2 * cube)
        + width * (slopes[i] * (cube - 2 * square + t) + slopes[i + 1] * (cube - square))
    )


def _slopes(x: Sequence[int], y: Sequence[Decimal]) -> list[Decimal]:
    h = [Decimal(b - a) for a, b in itertools.pairwise(x)]
    m = [(b - a) / w for (a, b), w in zip(itertools.pairwise(y), h, strict=True)]
    if len(h) == 1:
        return [m[0], m[0]]
    inner = []
    for (before, after), (left, right) in zip(itertools.pairwise(m), itertools.pairwise(h), strict=True):
        if before * after <= 0:
            inner.append(Decimal(0))
        else:
            w1, w2 = 2 * right + left, right + 2 * left
            inner.append((w1 + w2) / (w1 / before + w2 / after))
    return [_end(h[0], h[1], m[0], m[1]), *inner, _end(h[-1], h[-2], m[-1], m[-2])]


def _end(h0: Decimal, h1: Decimal, m0: Decimal, m1: Decimal) -> Decimal:
    """One-sided slope of three points, kept monotone."""
    slope = ((2 * h0 + h1) * m0 - h0 * m1) / (h0 + h1)
    if slope * m0 <= 0:
        return Decimal(0)
    if m0 * m1 <= 0 and abs(slope) > 3 * abs(m0):
        return 3 * m0
    return slope


def _times(poly: list[tuple[Decimal, Decimal]], real: Decimal, imaginary: Decimal) -> list[tuple[Decimal, Decimal]]:
    """A complex polynomial times (s - real - j imaginary)."""
    shifted, padded = [(Decimal(0), Decimal(0)), *poly], [*poly, (Decimal(0), Decimal(0))]
    return [
        (a - (c * real - d * imaginary), b - (c * imaginary + d * real))
        for (a, b), (c, d) in zip(padded, shifted, strict=True)
    ]
