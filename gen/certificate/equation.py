"""The exact solution over one sample, enclosed: z -> E (z - s) + s with E = exp(A Ts), s = (S, 0, ..).

z = (T, Ts T', Ts^2 T'', ..). Everything is a ratio of whole numbers but the exponentials: those of the schedules come
from the decimal library, which rounds them correctly, and that of the matrix is a Taylor sum with its remainder.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from math import ceil, factorial

import numpy as np

from gen.certificate.document import Equation, Schedule
from gen.certificate.exact import BITS, Integers, Ratio, Ratios, rounded
from gen.certificate.refuted import Refuted

#: Digits of the schedules' exponentials.
_DIGITS = 80
#: Relative error of a e^(b |PWM|): its argument and its result are rounded to 80 digits, and |argument| < 10^4.
_EXPONENTIAL = Ratio(1, 10**70)
_TERMS = 80


@dataclass(frozen=True)
class Enclosure:
    """What is known of one component at every |PWM| of the domain (P of them).

    Attributes
    ----------
    transition
        E in units of 2^-BITS, shape (P, n, n), every entry off by no more than ``radius`` units.
    steady, steady_radius
        S in K, shape (P,), and what it is off by.
    """

    transition: Integers
    radius: int
    steady: Ratios
    steady_radius: Ratio


def enclose(equation: Equation, domain: tuple[int, int], step: Ratio) -> Enclosure:
    """Enclose the exact solution over a step in s.

    Raises
    ------
    Refuted
        If the equation cannot be enclosed (A(0) may vanish, a schedule or a pole is too large).
    """
    rows = range(domain[0], domain[1] + 1)
    n = len(equation.poles)
    matrix = np.zeros((len(rows), n, n), dtype=object)
    steady = np.zeros(len(rows), dtype=object)
    off, steady_off = Ratio(0), Ratio(0)
    for row, pwm in enumerate(rows):
        coefficients, wrong = _denominator(equation, pwm)
        gain, gain_wrong = _gain(equation, pwm)
        smallest = abs(coefficients[n]) - wrong[n]
        if smallest <= 0:
            raise Refuted(f"A(0) may vanish at |PWM| {pwm}")
        steady[row] = gain * pwm / coefficients[n]
        steady_off = max(steady_off, (gain_wrong * pwm + abs(steady[row]) * wrong[n]) / smallest)
        for i in range(n - 1):
            matrix[row, i, i + 1] = 1 << BITS
        for k in range(1, n + 1):
            matrix[row, n - 1, n - k] = rounded(-coefficients[k] * step**k)
            off = max(off, wrong[k] * step**k + Ratio(1, 1 << BITS))
    transition, radius = _exponential(matrix, off)
    return Enclosure(transition, radius, steady, steady_off)


def _exponential(matrix: Integers, off: Ratio) -> tuple[Integers, int]:
    """exp of matrices in units of 2^-BITS whose entries are off by no more than ``off``, and its error in units."""
    n = matrix.shape[1]
    norm = Ratio(n * int(np.abs(matrix).max()), 1 << BITS)  # not below the norms of rows and of columns
    if norm > _TERMS // 2:
        raise Refuted("the poles are too fast for the sample time")
    total = matrix + (np.eye(n, dtype=object) * (1 << BITS))[None]
    term, term_error, error = matrix, Ratio(0), Ratio(0)
    for k in range(2, _TERMS + 1):
        term = (np.matmul(term, matrix) >> BITS) // k
        term_error = term_error * norm / k + 2  # both divisions round down by less than a unit
        error += term_error
        total = total + term
    # The first term left out, and the others are at most half of the one before.
    rest = 2 * norm ** (_TERMS + 1) / factorial(_TERMS + 1)
    # |exp(M + D) - exp(M)| <= |D| exp(|M| + |D|)
    given = n * off * Ratio(3) ** ceil(norm + n * off)
    return total, ceil(error + (rest + given) * (1 << BITS))


def _denominator(equation: Equation, pwm: int) -> tuple[list[Ratio], list[Ratio]]:
    """A's coefficients, highest power first, and what each may be off by."""
    held = min(max(pwm, equation.held[0]), equation.held[1])
    poly = [(Ratio(1), Ratio(0))]
    inner, outer = [Ratio(1)], [Ratio(1)]
    for pole in equation.poles:
        real, real_wrong = _value(pole.real, held)
        imag, imag_wrong = _value(pole.imag, held) if pole.imag is not None else (Ratio(0), Ratio(0))
        zero = (Ratio(0), Ratio(0))
        poly = [
            (a - (c * real - d * imag), b - (c * imag + d * real))
            for (a, b), (c, d) in zip([*poly, zero], [zero, *poly], strict=True)
        ]
        # The coefficients of the product of (s + |p|) are not below those of the product of (s - p).
        size = abs(real) + abs(imag)
        inner = _times(inner, size)
        outer = _times(outer, size + real_wrong + imag_wrong)
    return [real for real, _ in poly], [high - low for high, low in zip(outer, inner, strict=True)]


def _times(poly: list[Ratio], root: Ratio) -> list[Ratio]:
    return [a + root * b for a, b in zip([*poly, Ratio(0)], [Ratio(0), *poly], strict=True)]


def _gain(equation: Equation, pwm: int) -> tuple[Ratio, Ratio]:
    gain, wrong = _value(equation.gain, min(max(pwm, equation.held[0]), equation.held[1]))
    low, high = equation.no_gain_outside
    if not low <= pwm <= high:
        if abs(gain) < wrong:  # of either sign, or 0
            return Ratio(0), 2 * wrong
        return max(gain, Ratio(0)), wrong
    return gain, wrong


def _value(schedule: Schedule, pwm: int) -> tuple[Ratio, Ratio]:
    """A schedule's value, and what it may be off by."""
    total, wrong = Ratio(0), Ratio(0)
    with localcontext(Context(prec=_DIGITS)):
        for factor, rate in schedule.exponentials:
            if abs(rate * pwm) >= 10**4:
                raise Refuted("an exponential schedule is too steep")
            exponent = Decimal(int((rate * pwm).numerator)) / Decimal(int((rate * pwm).denominator))
            term = factor * Ratio(exponent.exp())
            total += term
            wrong += abs(term) * _EXPONENTIAL
    if schedule.pieces:
        held = next(((start, c) for start, end, c in schedule.pieces if start <= pwm <= end), None)
        if held is None:
            raise Refuted(f"a schedule says nothing of |PWM| {pwm}")
        value = Ratio(0)
        for coefficient in held[1]:
            value = value * (pwm - held[0]) + coefficient
        total += value
    # A short ratio for what follows.
    return Ratio(rounded(total), 1 << BITS), wrong + Ratio(1, 1 << BITS)
