"""Lower a network for one arithmetic, with the proof of its ranges and its error."""

from __future__ import annotations

from collections.abc import Mapping
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
from gen.lowering.network.terms import Terms, terms_of
from gen.lowering.recursion.guarantee import rounded_up
from gen.model import ThermalModel

Array = NDArray[np.float64]
TARGET_K: Mapping[Arithmetic, float] = {"fixed": 9.5e-6, "float": 1e-3}
"""A bound that is good enough: a smaller one costs terms of the series."""
_SLACK = 1.5
"""So is one that is no larger than the best by this factor."""
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
    form = _fixed if arithmetic == "fixed" else _float
    tried = [form(terms, ranges, bits, factors, first, share) for share in SHARES]
    least = tried[-1][2][1]
    if least is None:
        raise CheckFailed("$.network: no error bound can be proven: nothing holds errors back at some |PWM|")
    enough = max(TARGET_K[arithmetic], _SLACK * float(least.max()))
    states, series, (defect, bound) = next(
        found for found in tried if found[2][1] is not None and found[2][1].max() <= enough
    )
    assert bound is not None
    bound = np.maximum(bound, bound * (_START_WORDS * 2.0**-bits / bound.min()))
    proof = NetworkProof(ranges.low, ranges.high, bound, defect.max(axis=0))
    made = NetworkProgram(
        arithmetic,
        bits,
        series,
        states,
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


def _fixed(
    terms: Terms, ranges: Ranges, bits: int, factors: tuple[FactorProgram, ...], first: Array, share: float
) -> tuple[tuple[StateProgram, ...], tuple[int, ...], tuple[Array, Array | None]]:
    shape = fixed.choose_format(terms, ranges, bits)
    base = fixed.roundings(terms, ranges, shape, factors, ())
    orders, left = choose_orders(terms, first, base.first, share)
    series = fixed.series_bits(terms, first, shape, max(orders))
    rounding = fixed.roundings(terms, ranges, shape, factors, series)
    defect = defects(terms, first, orders, left, rounding)
    states = tuple(
        StateProgram(
            name,
            tuple(fixed.term_program(term, shape) for term in terms.of(k)),
            tuple(fixed.heat_programs(terms, k, shape, factors)),
            shape.shifts[k],
            orders[k],
        )
        for k, name in enumerate(terms.states)
    )
    return states, series, (defect, error_bound(terms, ranges, defect))


def _float(
    terms: Terms, ranges: Ranges, bits: int, factors: tuple[FactorProgram, ...], first: Array, share: float
) -> tuple[tuple[StateProgram, ...], tuple[int, ...], tuple[Array, Array | None]]:
    base = float32.roundings(terms, ranges, bits, factors, first, 1)
    orders, left = choose_orders(terms, first, base.first, share)
    rounding = float32.roundings(terms, ranges, bits, factors, first, max(orders))
    defect = defects(terms, first, orders, left, rounding)
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
    return states, (), (defect, error_bound(terms, ranges, defect))


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
