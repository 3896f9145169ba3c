"""The increment form: how one sample of A(d/dt) T = K |pwm| becomes a few additions and products.

A pole of a motor's part lies at 1 - z = 1e-4, so the textbook difference equation loses its DC gain to rounding.
The form used here keeps *increments* instead.  For a component of order n the board holds x = (x1 .. xn), where x1 is
the temperature rise and x2, x3 .. are its first, second .. increments over one sample, staggered by half a sample
where that saves work:

======  ==========================================================================
order   one sample (q is computed first, from the state at the sample's start)
======  ==========================================================================
1       x1 += q
2       x1 += x2 + q/2;         x2 += q
3       x1 += x2;               x3 += q;   x2 += x3
4       x1 += x2 + x3/2;        x2 += x3;  x4 += q;  x3 += x4
======  ==========================================================================

with q = -(C0 (x1 - S) + C1 x2 + .. ) and S the steady rise at the present PWM.  C0 .. are solved so that the discrete
poles are exactly exp(p Ts) (:func:`feedback`).  They are evaluated nested,

    q = -R[n-1] (xn + R[n-2] (x[n-1] + .. + R[0] (x1 - S)))          R[i] = C[i] / C[i+1],  R[n-1] = C[n-1]

because every R is a rate times Ts (a pole-like number that varies by a factor of a few over the speed range), whereas
the C span many decades and would waste the multiplier's bits.

Because the chain of additions is the same at every PWM, x is a constant linear map M of the true state
z = (T, Ts T', Ts^2 T'', ..), but for one term: adding x[n] to x[n-1] is the trapezoidal rule, whose error over a
sample is -(1/12) of the change of q (Euler-Maclaurin).  While PWM is constant that adds up to a mere offset,
x[n-1] = .. + q/12.  When PWM changes, q jumps although z does not, so the offset must be carried over:

    at a change of PWM:   x[n-1] += (q_new - q_old) / 12       (both from the same x; nothing to do for order 1)

With that, x = M(p) z holds through any sequence of PWM up to terms of third order in p Ts (:func:`state_map`), and
:func:`mismatch` gives what is left so that it can be bounded.
"""

from __future__ import annotations

from decimal import Context, Decimal, localcontext
from fractions import Fraction
from math import factorial

import numpy as np
from scipy.linalg import expm

from gen.arrays import FloatArray

#: Poles are at most 0.1/Ts, so the twentieth term of exp is below 1e-38.
_TAYLOR_TERMS = 20

#: Chain part of one sample for each order: x += CHAIN @ x + INJECT * q (q included where a later row already sees it).
_CHAIN: dict[int, list[list[Fraction]]] = {
    1: [[Fraction(0)]],
    2: [[Fraction(0), Fraction(1)], [Fraction(0), Fraction(0)]],
    3: [[Fraction(v) for v in row] for row in ([0, 1, 0], [0, 0, 1], [0, 0, 0])],
    4: [
        [Fraction(0), Fraction(1), Fraction(1, 2), Fraction(0)],
        [Fraction(0), Fraction(0), Fraction(1), Fraction(0)],
        [Fraction(0), Fraction(0), Fraction(0), Fraction(1)],
        [Fraction(0), Fraction(0), Fraction(0), Fraction(0)],
    ],
}
_INJECT: dict[int, list[Fraction]] = {
    1: [Fraction(1)],
    2: [Fraction(1, 2), Fraction(1)],
    3: [Fraction(0), Fraction(1), Fraction(1)],
    4: [Fraction(0), Fraction(0), Fraction(1), Fraction(1)],
}


def delta_polynomial(denominator: FloatArray, sample_time: float) -> FloatArray:
    """Coefficients b1..bn of prod(delta - (exp(p Ts) - 1)) = delta^n + b1 delta^(n-1) + .. + bn.

    Computed in decimal arithmetic as the characteristic polynomial of exp(M) - I, M the companion matrix scaled by
    Ts, so that the result is the correctly rounded float64 and the same bytes on every machine.

    Parameters
    ----------
    denominator
        Monic A(s), highest power first, shape (m, n + 1), in 1/s^k.
    sample_time
        Ts in s.

    Returns
    -------
    FloatArray
        b1..bn, shape (m, n), dimensionless.
    """
    with localcontext(Context(prec=50)):
        step = Decimal(sample_time)
        return np.array(
            [
                [float(b) for b in _delta([Decimal(a) * step**k for k, a in enumerate(row.tolist())][1:])]
                for row in denominator
            ]
        )


def _delta(alpha: list[Decimal]) -> list[Decimal]:
    """b1..bn from alpha_k = a_k Ts^k: Taylor series of exp, then Faddeev-LeVerrier."""
    n = len(alpha)
    power = [Decimal(int(j == 0)) for j in range(n)]  # s^m modulo A in the basis 1, s, .., s^(n-1)
    remainders = [power]
    for _ in range(_TAYLOR_TERMS + n):
        carry = power[-1]
        power = [(power[j - 1] if j else Decimal(0)) - carry * alpha[n - 1 - j] for j in range(n)]
        remainders.append(power)
    growth = [[Decimal(0)] * n for _ in range(n)]
    factorial = Decimal(1)
    for m in range(1, _TAYLOR_TERMS + 1):
        factorial /= m
        for i in range(n):
            growth[i] = [g + r * factorial for g, r in zip(growth[i], remainders[m + i], strict=True)]
    coefficients: list[Decimal] = []
    auxiliary = [[Decimal(int(i == j)) for j in range(n)] for i in range(n)]
    for k in range(1, n + 1):
        product = [
            [sum((growth[i][m] * auxiliary[m][j] for m in range(n)), Decimal(0)) for j in range(n)] for i in range(n)
        ]
        coefficients.append(-sum((product[i][i] for i in range(n)), Decimal(0)) / k)
        auxiliary = [[product[i][j] + (coefficients[-1] if i == j else 0) for j in range(n)] for i in range(n)]
    return coefficients


def feedback(b: FloatArray) -> FloatArray:
    """C0..C[n-1] of the increment form whose characteristic polynomial in delta is given by ``b``.

    Parameters
    ----------
    b
        b1..bn, shape (m, n), from :func:`delta_polynomial`.

    Returns
    -------
    FloatArray
        C0..C[n-1], shape (m, n).  Derived by eliminating x2..xn from the table in the module's docstring.
    """
    columns = []
    for row in FEEDBACK_FROM_DELTA[b.shape[1]]:
        column = np.zeros(b.shape[0])
        for factor, values in zip(row, b.T, strict=True):  # a plain loop: no library may reorder the sum
            column = column + float(factor) * values
        columns.append(column)
    return np.stack(columns, axis=1)


#: C = M b for each order (rows C0.., columns b1..bn).
FEEDBACK_FROM_DELTA: dict[int, list[list[Fraction]]] = {
    1: [[Fraction(1)]],
    2: [[Fraction(0), Fraction(1)], [Fraction(1), Fraction(-1, 2)]],
    3: [[Fraction(v) for v in row] for row in ([0, 0, 1], [0, 1, -1], [1, -1, 1])],
    4: [
        [Fraction(0), Fraction(0), Fraction(0), Fraction(1)],
        [Fraction(0), Fraction(0), Fraction(1), Fraction(-3, 2)],
        [Fraction(0), Fraction(1), Fraction(-1), Fraction(1)],
        [Fraction(1), Fraction(-1), Fraction(1), Fraction(-1)],
    ],
}


def rates(c: FloatArray) -> FloatArray:
    """Nested rates R0..R[n-1] from C0..C[n-1], shape (m, n); all positive for slow stable poles."""
    nested = np.array(c, dtype=np.float64)
    nested[:, :-1] = c[:, :-1] / c[:, 1:]
    return nested


def from_rates(nested: FloatArray) -> FloatArray:
    """C0..C[n-1] from the nested rates, shape (m, n): the inverse of :func:`rates`."""
    return np.asarray(np.cumprod(nested[:, ::-1], axis=1)[:, ::-1].copy(), dtype=np.float64)


def transition(c: FloatArray) -> FloatArray:
    """The matrix F of one sample, x - s -> F (x - s) with s = (S, 0, ..), shape (m, n, n)."""
    n = c.shape[1]
    chain = np.array(_CHAIN[n], dtype=np.float64)
    inject = np.array(_INJECT[n], dtype=np.float64)
    matrix: FloatArray = np.eye(n) + chain - inject[None, :, None] * c[:, None, :]
    return matrix


def injection(order: int) -> FloatArray:
    """How an error in q enters the state in one sample, shape (n,)."""
    return np.array(_INJECT[order], dtype=np.float64)


#: Share of q that x[n-1] carries (second Bernoulli number over 2!, the trapezoidal rule's error).
CARRY = 1.0 / 12.0


def state_map(c: FloatArray, carry: float = CARRY) -> FloatArray:
    """The matrices M(p) with x - s = M(p) (z - s), z = (T, Ts T', Ts^2 T'', ..), shape (m, n, n).

    The constant part follows from both chains being controllable with the same characteristic polynomial
    (delta^n): one similarity maps the sampled chain of integrators onto the form's (ratio of their controllability
    matrices).  It may be multiplied by any polynomial of the companion matrix; I + N^2/12 puts all that depends on
    the PWM into one row, as q/12.

    Parameters
    ----------
    c
        C0..C[n-1], shape (m, n).
    carry
        Share of q that x[n-1] carries: :data:`CARRY`, or the board's rounded one.
    """
    m, n = c.shape
    constant = constant_map(n)
    carrying: FloatArray = np.tile(np.eye(n), (m, 1, 1))
    if n > 1:  # x[n-1] = constant part + q/12 with q = -C (x - s): solved for x
        carrying[:, n - 2, :] += c * carry
    return np.asarray(np.linalg.solve(carrying, np.tile(constant, (m, 1, 1))), dtype=np.float64)


def constant_map(order: int) -> FloatArray:
    """What of :func:`state_map` does not depend on the PWM, shape (n, n)."""
    n = order
    exact_chain = [[Fraction(1, factorial(j - i)) if j >= i else Fraction(0) for j in range(n)] for i in range(n)]
    exact_inject = [Fraction(1, factorial(n - i)) for i in range(n)]
    form_chain = [[_CHAIN[n][i][j] + (1 if i == j else 0) for j in range(n)] for i in range(n)]
    left = np.array(_controllability(form_chain, _INJECT[n]), dtype=np.float64)
    right = np.array(_controllability(exact_chain, exact_inject), dtype=np.float64)
    chains = np.round(np.linalg.solve(right.T, left.T).T * 720.0) / 720.0  # rationals with small denominators
    nilpotent = np.diag(np.ones(n - 1), 1)
    constant: FloatArray = chains @ (np.eye(n) + nilpotent @ nilpotent / 12.0)
    return constant


def exact_transition(denominator: FloatArray, sample_time: float) -> FloatArray:
    """exp(A Ts) in the coordinates (T, Ts T', Ts^2 T'', ..), shape (m, n, n)."""
    m, n = denominator.shape[0], denominator.shape[1] - 1
    companion = np.zeros((m, n, n))
    for i in range(n - 1):
        companion[:, i, i + 1] = 1.0
    scale = sample_time ** np.arange(n, 0, -1)
    companion[:, n - 1, :] = -denominator[:, :0:-1] * scale
    result: FloatArray = expm(companion)
    return result


def mismatch(form: FloatArray, exact: FloatArray, state_maps: FloatArray) -> FloatArray:
    """F M - M exp(A Ts): what one sample of the form does differently at constant PWM, shape (m, n, n)."""
    difference: FloatArray = form @ state_maps - state_maps @ exact
    return difference


def _controllability(chain: list[list[Fraction]], inject: list[Fraction]) -> list[list[Fraction]]:
    n = len(inject)
    column = list(inject)
    columns = []
    for _ in range(n):
        columns.append(column)
        column = [sum((chain[i][j] * column[j] for j in range(n)), Fraction(0)) for i in range(n)]
    return [[columns[j][i] for j in range(n)] for i in range(n)]
