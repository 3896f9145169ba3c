"""Which terms of the series each state takes part in, and how long their words are: the cheapest that is good."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

from gen.arrays import FloatArray
from gen.errors import CheckFailed
from gen.lowering.kinds import Arithmetic
from gen.lowering.network import fixed, float32
from gen.lowering.network.defect import SHARES, choose_orders, defects, error_bound
from gen.lowering.network.factors import FactorProgram
from gen.lowering.network.laws import LawProgram
from gen.lowering.network.program import StateProgram
from gen.lowering.network.ranges import Ranges
from gen.lowering.network.series import CHOICES, FIRST, Product
from gen.lowering.network.terms import Terms

TARGET_K: Mapping[Arithmetic, float] = {"fixed": 9.5e-6, "float": 1e-3}
"""A bound that is good enough: a smaller one costs terms of the series, and longer words."""
_TOLD_TARGET_K = 4e-5
"""The same in fixed point with channels or laws, whose factors and slopes are short words."""
_SLACK: Mapping[Arithmetic, float] = {"fixed": 1.1, "float": 1.5}
"""So is one that is no larger than the best by this factor."""
_STATE_CYCLES = 60.0
"""About what a state costs in each term of the series, beside its products."""
_DOUBT, _MOST_TRIED = 2.0, 4
"""By how much an estimate of a bound may exceed what is good enough to be looked at, and how many are."""


class Told(NamedTuple):
    """Words of what is evaluated at the beginning of a sample."""

    factors: tuple[FactorProgram, ...]
    laws: tuple[LawProgram, ...] = ()


@dataclass(frozen=True, eq=False)
class Form:
    """One way to compute a network, and what it errs by; see :class:`NetworkProgram`."""

    states: tuple[StateProgram, ...]
    products: tuple[Product, ...]
    series: tuple[int, ...]
    defect: FloatArray
    bound: FloatArray


@dataclass(frozen=True, eq=False)
class _Trial:
    """Terms of the series that each state takes part in, products, and the defect that they come to."""

    orders: list[int]
    products: tuple[Product, ...]
    series: tuple[int, ...]
    defect: FloatArray
    cost: float


def _bound(terms: Terms, defect: FloatArray) -> FloatArray:
    found = error_bound(terms, defect)
    if found is None:
        raise CheckFailed("$.network: no error bound can be proven: nothing holds errors back at some |PWM|")
    return found


def _enough(target: float, least: float, slack: float, limit: float) -> float:
    """Largest bound that is good enough, from the least one that can be had and the file's limit."""
    return max(least, min(max(target, slack * least), 0.95 * limit))


def fixed_form(terms: Terms, ranges: Ranges, bits: int, told: Told, first: FloatArray, limit: float) -> Form:
    """Choose a network's form in fixed point.

    Parameters
    ----------
    terms, ranges, bits, told
        The network, what it can reach, and the words of its temperatures, factors and laws.
    first
        Bound on y1, K, shape (rows, n).
    limit
        The file's, K.

    Raises
    ------
    CheckFailed
        If no bound can be proven, or no words hold what changes in a sample.
    """
    factors, laws = told
    shape = fixed.choose_format(terms, factors, first, bits)
    base = fixed.roundings(terms, ranges, shape, factors, (FIRST,), (), laws).first
    trials: list[_Trial] = []
    for share in SHARES:
        orders, left = choose_orders(terms, first, base, share)
        if any(trial.orders == orders for trial in trials):
            continue
        for further in product(*(CHOICES[k] for k in range(2, max(orders) + 1))):
            products = (FIRST, *further)
            series = fixed.series_bits(terms, first, shape, products)
            rounding = fixed.roundings(terms, ranges, shape, factors, products, series, laws)
            defect, words = defects(terms, first, orders, left, rounding)
            if fixed.fit(shape, products, series, first + rounding.first, words):
                trials.append(_Trial(orders, products, series, defect, _cost(terms, orders, products)))
    if not trials:
        raise CheckFailed(
            "$.network: its temperatures change by more in one sample than the words of fixed point hold; expected a "
            "shorter $.sample_time_s, larger capacities, or --arithmetic float"
        )
    best = min(trials, key=lambda trial: float((trial.defect / base).max()))
    least = _bound(terms, best.defect)
    enough = _enough(
        _TOLD_TARGET_K if factors or laws else TARGET_K["fixed"], float(least.max()), _SLACK["fixed"], limit
    )
    chosen, bound = _cheapest(terms, trials, best, least, enough)
    states = tuple(
        StateProgram(
            name,
            tuple(fixed.term_program(term, shape, factors) for term in terms.of(k)),
            tuple(fixed.heat_programs(terms, k, shape, factors)),
            shape.shifts[k],
            chosen.orders[k],
        )
        for k, name in enumerate(terms.states)
    )
    return Form(states, chosen.products, chosen.series, chosen.defect, bound)


def _cheapest(
    terms: Terms, trials: list[_Trial], best: _Trial, least: FloatArray, enough: float
) -> tuple[_Trial, FloatArray]:
    """The cheapest trial whose bound is good enough, and that bound."""
    tried = 0
    for trial in sorted(trials, key=lambda trial: trial.cost):
        # A defect that is nowhere larger than another one by some factor has a bound that is not, either.
        ratio = float((trial.defect / best.defect).max())
        sure = ratio * float(least.max()) <= enough
        if sure or (ratio * float(least.max()) <= _DOUBT * enough and tried < _MOST_TRIED):
            tried += 1
            bound = _bound(terms, trial.defect)
            if bound.max() <= enough:
                return trial, bound
    return best, least


def _cost(terms: Terms, orders: list[int], products: tuple[Product, ...]) -> float:
    """Cycles of all products, and what a state costs in each order that it takes part in."""
    return sum(
        _STATE_CYCLES + 4.0 * made.sum_bytes + made.cost * len(terms.of(state))
        for order, made in enumerate(products, start=1)
        for state, own in enumerate(orders)
        if own >= order
    )


def float_form(terms: Terms, ranges: Ranges, bits: int, told: Told, first: FloatArray, limit: float) -> Form:
    """Choose a network's form in float32.

    Parameters
    ----------
    terms, ranges, bits, told
        The network, what it can reach, and the words of its temperatures, factors and laws.
    first
        Bound on y1, K, shape (rows, n).
    limit
        The file's, K.

    Raises
    ------
    CheckFailed
        If no bound can be proven.
    """
    factors, laws = told
    base = float32.roundings(terms, ranges, bits, factors, first, 1, laws).first
    tried = []
    for share in SHARES:
        orders, left = choose_orders(terms, first, base, share)
        rounding = float32.roundings(terms, ranges, bits, factors, first, max(orders), laws)
        defect, _ = defects(terms, first, orders, left, rounding)
        tried.append((orders, defect, _bound(terms, defect)))
    enough = _enough(TARGET_K["float"], float(tried[-1][2].max()), _SLACK["float"], limit)
    orders, defect, bound = next(found for found in tried if found[2].max() <= enough)
    states = tuple(
        StateProgram(
            name,
            tuple(float32.term_program(term, bits) for term in terms.of(k)),
            tuple(float32.heat_programs(terms, k, bits)),
            0,
            orders[k],
        )
        for k, name in enumerate(terms.states)
    )
    return Form(states, (), (), defect, bound)
