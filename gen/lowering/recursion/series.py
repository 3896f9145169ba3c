"""The delta-domain polynomial as a power series of the continuous one, with exact rational coefficients.

For A(s) = s^n + a1 s^(n-1) + .. + an and alpha_k = a_k Ts^k, the coefficients b1..bn of
prod(delta - (exp(p Ts) - 1)) are power series in alpha1..alphan.  Giving alpha_k the weight k (it is of order Ts^k),
every b_k starts at weight k; terms up to a chosen weight are derived once, in rational arithmetic, from

    exp(M) - I,  M the companion matrix of alpha,   and   char. polynomial by Faddeev-LeVerrier.

The board's own discretisation (``--schedule onboard``) is made of the first few terms.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import cache

Monomial = tuple[int, ...]
Polynomial = dict[Monomial, Fraction]


@cache
def delta_series(order: int, extra_weight: int) -> tuple[Mapping[Monomial, Fraction], ...]:
    """b1..bn as polynomials in alpha1..alphan: {exponents: coefficient}, up to weight k + extra_weight for b_k.

    Parameters
    ----------
    order
        n, 1..4.
    extra_weight
        How many orders of Ts beyond the leading one are kept.
    """
    top = order + extra_weight
    zero: Polynomial = {}
    one: Polynomial = {(0,) * order: Fraction(1)}
    alpha: list[Polynomial] = [{tuple(int(i == k) for i in range(order)): Fraction(-1)} for k in reversed(range(order))]
    # Row i of the companion matrix's powers: s^m modulo A, as coefficients of 1, s, .., s^(n-1).
    power = [one if j == 0 else zero for j in range(order)]
    exponential = [[zero] * order for _ in range(order)]  # row i: s^i (exp(s) - 1) modulo A
    inverse_factorial = Fraction(1)
    remainders = [power]
    for _ in range(top + order):
        carry = power[-1]
        power = [_add(power[j - 1] if j else zero, _multiply(carry, alpha[j], top)) for j in range(order)]
        remainders.append(power)
    for m in range(1, top + 1):
        inverse_factorial /= m
        for i in range(order):
            exponential[i] = [
                _add(e, _scale(r, inverse_factorial))
                for e, r in zip(exponential[i], remainders[min(m + i, len(remainders) - 1)], strict=True)
            ]
    return tuple(
        {k: v for k, v in poly.items() if weight(k) <= number + 1 + extra_weight}
        for number, poly in enumerate(_characteristic(exponential, top))
    )


def _characteristic(matrix: list[list[Polynomial]], top: int) -> list[Polynomial]:
    """Coefficients c1..cn of det(delta I - matrix), by Faddeev-LeVerrier."""
    n = len(matrix)
    zero: Polynomial = {}
    one: Polynomial = {(0,) * n: Fraction(1)}
    auxiliary = [[one if i == j else zero for j in range(n)] for i in range(n)]
    coefficients: list[Polynomial] = []
    for k in range(1, n + 1):
        product = [
            [_sum(_multiply(matrix[i][m], auxiliary[m][j], top) for m in range(n)) for j in range(n)] for i in range(n)
        ]
        coefficient = _scale(_sum(product[i][i] for i in range(n)), Fraction(-1, k))
        coefficients.append(coefficient)
        auxiliary = [
            [_add(product[i][j], coefficient) if i == j else product[i][j] for j in range(n)] for i in range(n)
        ]
    return coefficients


def weight(exponents: Monomial) -> int:
    """The order of Ts of a monomial: alpha_k counts k."""
    return sum((k + 1) * exponent for k, exponent in enumerate(exponents))


def _add(left: Polynomial, right: Polynomial) -> Polynomial:
    total = dict(left)
    for key, value in right.items():
        total[key] = total.get(key, Fraction(0)) + value
        if not total[key]:
            del total[key]
    return total


def _sum(terms: Iterable[Polynomial]) -> Polynomial:
    total: Polynomial = {}
    for term in terms:
        total = _add(total, term)
    return total


def _scale(poly: Polynomial, factor: Fraction) -> Polynomial:
    return {key: value * factor for key, value in poly.items()}


def _multiply(left: Polynomial, right: Polynomial, top: int) -> Polynomial:
    total: Polynomial = {}
    for key, value in left.items():
        own = weight(key)
        for other, factor in right.items():
            if own + weight(other) <= top:
                exponents = tuple(a + b for a, b in zip(key, other, strict=True))
                total[exponents] = total.get(exponents, Fraction(0)) + value * factor
    return {key: value for key, value in total.items() if value}
