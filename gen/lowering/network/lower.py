"""Lower a network for one arithmetic, with the proof of its ranges and its error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from math import ceil, floor

import numpy as np
from numpy.typing import NDArray

from gen.coefficients import Coefficients
from gen.errors import CheckFailed
from gen.lowering.effects.program import Channel
from gen.lowering.kinds import Arithmetic
from gen.lowering.network import fixed, float32
from gen.lowering.network.defect import SHARES, choose_orders, defects, error_bound
from gen.lowering.network.factors import FactorProgram, lower_factor
from gen.lowering.network.program import NetworkProgram, NetworkProof, Reading, StateProgram
from gen.lowering.network.ranges import Ranges, reachable, speeds
from gen.lowering.network.series import CHOICES, FIRST, Product
from gen.lowering.network.terms import Terms, terms_of
from gen.lowering.recursion.guarantee import rounded_up
from gen.model import ThermalModel

Array = NDArray[np.float64]
TARGET_K: Mapping[Arithmetic, float] = {"fixed": 9.5e-6, "float": 1e-3}
"""A bound that is good enough: a smaller one costs terms of the series, and longer words."""
_TOLD_TARGET_K = 4e-5
"""The same in fixed point with channels, whose factors are short words."""
_SLACK: Mapping[Arithmetic, float] = {"fixed": 1.1, "float": 1.5}
"""So is one that is no larger than the best by this factor."""
_STATE_CYCLES = 60.0
"""About what a state costs in each term of the series, beside its products."""
_DOUBT, _MOST_TRIED = 2.0, 4
"""By how much an estimate of a bound may exceed what is good enough to be looked at, and how many are."""
_CLAIMED = 1.03
"""The bound is claimed larger by this factor: what proves it anew (``gen check``) rounds in other places."""
_START_WORDS = 4.0
"""A state at its start is at most so many words from what it stands for: a scale of 2^-18, weights of 2^-32."""


def lower_network(coefficients: Coefficients, arithmetic: Arithmetic) -> NetworkProgram:
    """Lower a network.

    Raises
    ------
    CheckFailed
        If no range or no error bound can be proven, or the bound exceeds the file's limit; the message says which.
    """
    model = coefficients.model
    assert model.network is not None
    terms = terms_of(model)
    ranges = reachable(model, terms)
    if ranges is None:
        raise CheckFailed("$.network: no range of temperatures can be proven: heat at its largest runs away")
    channels = model.network.channels
    factors = tuple(
        lower_factor(factor, channels, float(terms.spans[k, 1]), k) for k, factor in enumerate(terms.factors)
    )
    bits = fixed.fraction_bits(ranges, [node.sensor.offset for node in model.network.sensed if node.sensor])
    first = speeds(terms, ranges)
    limit, _ = coefficients.accuracy.limit(arithmetic)
    found = (_fixed if arithmetic == "fixed" else _float)(terms, ranges, bits, factors, first, limit)
    bound = found.bound * _CLAIMED
    bound = np.maximum(bound, bound * (_START_WORDS * 2.0**-bits / bound.min()))
    proof = NetworkProof(ranges.low, ranges.high, bound, found.defect.max(axis=0))
    made = NetworkProgram(
        arithmetic,
        bits,
        found.products,
        found.series,
        found.states,
        _readings(model, bits),
        np.minimum(np.rint(model.network.rest_of_hidden * 2.0**32).astype(np.int64), 2**32 - 1),
        tuple(model.network.index(node.name) for node in model.network.hidden),
        factors,
        _channels(model),
        (ceil(model.domain_temperature[0] * 1000.0), floor(model.domain_temperature[1] * 1000.0)),
        proof,
    )
    _check(coefficients, arithmetic, made)
    return made


@dataclass(frozen=True, eq=False)
class _Form:
    """One way to compute a network, and what it errs by; see :class:`NetworkProgram`."""

    states: tuple[StateProgram, ...]
    products: tuple[Product, ...]
    series: tuple[int, ...]
    defect: Array
    bound: Array


@dataclass(frozen=True, eq=False)
class _Trial:
    """Terms of the series that each state takes part in, products, and the defect that they come to."""

    orders: list[int]
    products: tuple[Product, ...]
    series: tuple[int, ...]
    defect: Array
    cost: float


def _bound(terms: Terms, ranges: Ranges, defect: Array) -> Array:
    found = error_bound(terms, ranges, defect)
    if found is None:
        raise CheckFailed("$.network: no error bound can be proven: nothing holds errors back at some |PWM|")
    return found


def _enough(target: float, least: float, slack: float, limit: float) -> float:
    """Largest bound that is good enough, from the least one that can be had and the file's limit."""
    return max(least, min(max(target, slack * least), 0.95 * limit))


def _fixed(
    terms: Terms, ranges: Ranges, bits: int, factors: tuple[FactorProgram, ...], first: Array, limit: float
) -> _Form:
    shape = fixed.choose_format(terms, factors, first, bits)
    base = fixed.roundings(terms, ranges, shape, factors, (FIRST,), ()).first
    trials: list[_Trial] = []
    for share in SHARES:
        orders, left = choose_orders(terms, first, base, share)
        if any(trial.orders == orders for trial in trials):
            continue
        for further in product(*(CHOICES[k] for k in range(2, max(orders) + 1))):
            products = (FIRST, *further)
            series = fixed.series_bits(terms, first, shape, products)
            rounding = fixed.roundings(terms, ranges, shape, factors, products, series)
            defect, words = defects(terms, first, orders, left, rounding)
            if fixed.fit(shape, products, series, first + rounding.first, words):
                trials.append(_Trial(orders, products, series, defect, _cost(terms, orders, products)))
    assert trials, "words are chosen with room to spare"
    best = min(trials, key=lambda trial: float((trial.defect / base).max()))
    least = _bound(terms, ranges, best.defect)
    enough = _enough(_TOLD_TARGET_K if factors else TARGET_K["fixed"], float(least.max()), _SLACK["fixed"], limit)
    chosen, bound = _cheapest(terms, ranges, trials, best, least, enough)
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
    return _Form(states, chosen.products, chosen.series, chosen.defect, bound)


def _cheapest(
    terms: Terms, ranges: Ranges, trials: list[_Trial], best: _Trial, least: Array, enough: float
) -> tuple[_Trial, Array]:
    """The cheapest trial whose bound is good enough, and that bound."""
    tried = 0
    for trial in sorted(trials, key=lambda trial: trial.cost):
        # A defect that is nowhere larger than another one by some factor has a bound that is not, either.
        ratio = float((trial.defect / best.defect).max())
        sure = ratio * float(least.max()) <= enough
        if sure or (ratio * float(least.max()) <= _DOUBT * enough and tried < _MOST_TRIED):
            tried += 1
            bound = _bound(terms, ranges, trial.defect)
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


def _float(
    terms: Terms, ranges: Ranges, bits: int, factors: tuple[FactorProgram, ...], first: Array, limit: float
) -> _Form:
    base = float32.roundings(terms, ranges, bits, factors, first, 1).first
    tried = []
    for share in SHARES:
        orders, left = choose_orders(terms, first, base, share)
        rounding = float32.roundings(terms, ranges, bits, factors, first, max(orders))
        defect, _ = defects(terms, first, orders, left, rounding)
        tried.append((orders, defect, _bound(terms, ranges, defect)))
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
    return _Form(states, (), (), defect, bound)


def _readings(model: ThermalModel, bits: int) -> tuple[Reading, ...]:
    network = model.network
    assert network is not None
    made, lagging = [], len(network.nodes)
    for node in network.sensed:
        assert node.sensor is not None
        state = network.index(node.name)
        if node.sensor.lag > 0.0:
            state, lagging = lagging, lagging + 1
        made.append(Reading(node.name, network.index(node.name), state, round(node.sensor.offset * 2.0**bits)))
    return tuple(made)


def _channels(model: ThermalModel) -> tuple[Channel, ...]:
    """The ambient first; all in thousandths."""
    network = model.network
    assert network is not None
    low, high = (round(end * 1000.0) for end in model.domain_ambient)
    given = model.ambient_fixed if model.ambient_fixed is not None else 25.0
    ambient = Channel(model.ambient_channel or "ambient_degC", low, high, min(max(round(given * 1000.0), low), high))
    others = (
        Channel(c.column, round(c.low * 1000.0), round(c.high * 1000.0), round(c.neutral * 1000.0))
        for c in network.channels
    )
    return (ambient, *others)


def _check(coefficients: Coefficients, arithmetic: Arithmetic, program: NetworkProgram) -> None:
    limit, entry = coefficients.accuracy.limit(arithmetic)
    for component in program.components():
        if component.proof.bound_K > limit:
            raise CheckFailed(
                f"node {component.name}: the guaranteed error bound of {rounded_up(component.proof.bound_K):.1e} K "
                f"exceeds $.accuracy.{entry} = {limit:.1e} K"
            )
