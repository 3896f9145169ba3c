"""What one sample adds to the error of each state, and what all samples together can make of it.

Per state and row of the domain, in kelvins: coefficients that are rounded, states that are read without their lower
word, sums that are rounded, and the terms of the series that are left out. Everything is bounded by magnitudes, with
each factor at its largest.

Where paths have laws, J, the equations' derivative at the sample's beginning, is in the place of M in all terms of the
series but the first: the exponential Rosenbrock-Euler method (Hochbruck and Ostermann, Exponential integrators, Acta
Numerica 19, 2010, section 2.4). Its error over a sample is the integral of exp((1 - s) J) times what heat flows differ
from lines by.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.network.ranges import matrix_row
from gen.lowering.network.terms import Term, Terms

MOST_ORDERS = 5
SHARES = (1.0, 0.3, 0.1, 0.02)
"""Shares of what a sample adds to the error anyway that terms of the series may be left out for: the first with which
the bound is small enough."""
_THIRD_ERROR = 2.0**-15
"""Relative error of a third and a fifth as the board takes them."""


@dataclass(frozen=True, eq=False)
class Roundings:
    """What an arithmetic does to a sum; all by row of the domain, shape (rows,), or numbers.

    Attributes
    ----------
    first
        Error of y1 = h (M T + f) by state, K, shape (rows, n).
    rate
        By order of the series and a term, largest error of its rate, per sample.
    sum
        By order, state and the sum of magnitudes of a series' term, the error of the sum itself.
    kept
        What a y loses at most, and never gains, when it is handed on, K, by order from 1.
    added
        What is lost where the state takes up its changes, K; a number, or shape (rows, n).
    """

    first: FloatArray
    rate: Callable[[int, Term], FloatArray]
    sum: Callable[[int, int, FloatArray], FloatArray]
    kept: tuple[float, ...]
    added: float | FloatArray


def magnitudes(terms: Terms, first: FloatArray, order: int) -> list[FloatArray]:
    """Bounds on y1..y_order, each of shape (rows, n), K, from a bound on y1."""
    found = [first]
    for k in range(2, order + 1):
        found.append(_next(terms, found[-1]) / k)
    return found


def _next(terms: Terms, before: FloatArray) -> FloatArray:
    """Sum over terms of rate (|y_source| + |y_target|)."""
    total = np.zeros_like(before)
    for term, most in zip(terms.terms, terms.most, strict=True):
        source = before[:, term.other] if term.source == "state" else 0.0
        total[:, term.target] += most * (before[:, term.target] + source)
    return total


def bending(terms: Terms, first: FloatArray) -> FloatArray:
    """What laws that are no lines add to the error, K, shape (rows, n), from a bound on y1.

    After a share s of a sample the ends of a path have moved by no more than s times their y1, so that what drives is
    off by half its largest second derivative times (s y)^2; the integral of s^2 is a third.
    """
    total = np.zeros_like(first)
    for term in terms.terms:
        if term.law is not None:
            moved = first[:, term.target] + (first[:, term.other] if term.source == "state" else 0.0)
            total[:, term.target] += term.rate * terms.largest(term.factors) * term.law.steepest * moved**2 / 6.0
    # exp((1 - s) J) hands that on; the integral of s^2 / 2 (1 - s)^k / k! is 1 / (k + 3)!.
    handed = total
    for k in range(1, MOST_ORDERS + 1):
        handed = _next(terms, handed) / (k + 3)
        total = total + handed
    return np.asarray(total + 2.0 * handed.max(initial=0.0), dtype=np.float64)


def choose_orders(terms: Terms, first: FloatArray, floor: FloatArray, share: float) -> tuple[list[int], FloatArray]:
    """How many terms of the series each state takes part in, and what leaving out the rest costs.

    Parameters
    ----------
    terms
        The network.
    first
        Bound on y1, K, shape (rows, n).
    floor
        What a sample adds to the error anyway, K, shape (rows, n).
    share
        Of that, what may be left out.

    Returns
    -------
    orders, left
        By state; and K by row and state.
    """
    size = len(terms.states)
    bounds = magnitudes(terms, first, MOST_ORDERS + 1)
    ratio = float(_next(terms, np.ones_like(first)).max()) / (MOST_ORDERS + 2)
    tail = bounds[MOST_ORDERS] + bounds[MOST_ORDERS].max(axis=1, keepdims=True) * ratio / max(1e-9, 1.0 - ratio)
    orders = [MOST_ORDERS] * size
    left = tail.copy()
    for k in range(MOST_ORDERS, 1, -1):
        for state in range(size):
            more = left[:, state] + bounds[k - 1][:, state]
            if orders[state] == k and np.all(more <= share * floor[:, state]):
                orders[state], left[:, state] = k - 1, more
    return orders, left


def defects(
    terms: Terms, first: FloatArray, orders: Sequence[int], left: FloatArray, rounding: Roundings
) -> tuple[FloatArray, list[FloatArray]]:
    """What one sample adds to the error by row and state, K.

    Parameters
    ----------
    terms, first
        The network, and a bound on y1.
    orders, left
        As :func:`choose_orders` gives them.
    rounding
        Of the arithmetic.

    Returns
    -------
    defect, words
        Both of shape (rows, n); and by order, largest magnitude of y as the board has it, K.
    """
    bounds = magnitudes(terms, first, max(orders))
    reach = _next(terms, np.full_like(first, 0.5))
    for term, most in zip(terms.terms, terms.most, strict=True):
        if term.source != "state":
            reach[:, term.target] += 0.5 * most
    error = rounding.first
    words = [first + error]
    total = rounding.first + left + rounding.added
    if terms.laws:
        total = total + bending(terms, first)
    for k in range(2, max(orders) + 1):
        before = bounds[k - 2]
        if k in (3, 5):
            error = error + _THIRD_ERROR * before
        # Words are cut in one direction: two differ by what one loses.
        cut = rounding.kept[k - 2]
        grown = (_next(terms, error) + cut * reach) / k
        held = before + error + cut
        for term in terms.terms:
            source = held[:, term.other] if term.source == "state" else 0.0
            grown[:, term.target] += rounding.rate(k, term) * (held[:, term.target] + source) / k
        summed = _next(terms, held)
        for state in range(len(terms.states)):
            grown[:, state] += rounding.sum(k, state, summed[:, state]) / k
        partakes = np.array([k <= own for own in orders])
        total = total + np.where(partakes, grown, 0.0)
        # A state that takes no part hands on nothing: what it would have is its error there.
        error = np.where(partakes, grown, bounds[k - 1])
        words.append(bounds[k - 1] + grown)
    return np.asarray(total, dtype=np.float64), words


def error_bound(terms: Terms, defect: FloatArray) -> FloatArray | None:
    """The least u with -h M u exp(-h |M_ii|) >= defect for every row and all that channels may say; K, shape (n,).

    With e' = exp(h M) e + d, |d| <= defect, and |e| <= u: exp(h M) has no negative entry, so |e'| <= exp(h M) u +
    defect. The integral of exp(s M) (-M u) over a sample is u - exp(h M) u, and exp(s M) >= exp(-s |M_ii|) on the
    diagonal where -M u >= 0. So |e'| <= u again, whatever came before. Where laws let M change within the sample, the
    same holds with the largest |M_ii|.
    """
    from scipy.optimize import linprog

    rows, right = [], []
    for target in range(len(terms.states)):
        # What drives a row has no part in the error.
        found = [matrix_row(terms, target, corner, 0.0)[0] for corner in terms.corners(target, laws=True)]
        changing = any(term.law is not None for term in terms.of(target))
        largest = np.abs([left[:, target] for left in found]).max(axis=0)
        for left in found:
            own = np.exp(-(largest if changing else np.abs(left[:, target])))
            rows.append(left * own[:, None])
            right.append(-defect[:, target])
    matrix, limit = np.concatenate(rows), np.concatenate(right)
    # Entries near 1: the programme's tolerances are absolute.
    scale = np.abs(matrix).sum(axis=1)
    unit = float(defect.max(initial=0.0) / scale.max())
    matrix, limit = matrix / scale[:, None], limit / (scale * unit)
    # The tolerance may miss a row that needs little, as a sensor's slow drift does: then all get that much more.
    for more in (0.0, 1e-6):
        solved = linprog(
            np.ones(matrix.shape[1]),
            A_ub=matrix,
            b_ub=limit * (1.0 + 1e-6) - more,
            bounds=[(0.0, None)] * matrix.shape[1],
            method="highs",
        )
        if solved.status != 0:
            return None
        bound = np.asarray(solved.x, dtype=np.float64) * (1.0 + 1e-6)
        if np.all(matrix @ bound <= limit):
            return np.asarray(bound * unit)
    return None
