"""Lower a network for one arithmetic, with the proof of its ranges and its error."""

from __future__ import annotations

from math import ceil, log2

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.errors import CheckFailed
from gen.lowering.effects.program import Channel
from gen.lowering.kinds import Arithmetic
from gen.lowering.network import fixed
from gen.lowering.network.choose import Told, fixed_form, float_form
from gen.lowering.network.factors import lower_factor
from gen.lowering.network.gains import GainFormat, lower_gains
from gen.lowering.network.laws import limited, lower_law, widest_word
from gen.lowering.network.program import NetworkProgram, NetworkProof, Reading
from gen.lowering.network.ranges import reachable, speeds, widest_reference, widest_shown, widest_start
from gen.lowering.network.start import start_range_mC
from gen.lowering.network.terms import terms_of
from gen.lowering.recursion.guarantee import rounded_up
from gen.model import ThermalModel

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
    terms = limited(terms, ranges)
    channels = model.network.channels
    factors = tuple(
        lower_factor(factor, channels, float(terms.spans[k, 1]), k) for k, factor in enumerate(terms.factors)
    )
    offsets = [abs(node.sensor.offset) + abs(node.sensor.drift) for node in model.network.sensed if node.sensor]
    widest = max(
        widest_word(terms, ranges),
        widest_start(model.network, ranges),
        widest_shown(model.network, ranges),
        widest_reference(terms, ranges),
    )
    bits = fixed.fraction_bits(ranges, offsets, widest)
    laws = tuple(lower_law(law, ranges, bits) for law in terms.laws)
    first = speeds(terms, ranges)
    limit, _ = coefficients.accuracy.limit(arithmetic)
    found = (fixed_form if arithmetic == "fixed" else float_form)(
        terms, ranges, bits, Told(factors, laws), first, limit
    )
    bound = found.bound * _CLAIMED
    readings, gains = _readings(model, bits)
    weights = model.network.hidden_at_start
    most = max((float(own[:-1].sum()) for own in weights), default=0.0)
    starts = [reading.gain.start_error(gains.back) for reading in readings if reading.gain is not None and gains]
    # A hidden node starts at so many sensed ones' words, each off by a half, and as many of the ambient's taken off.
    words = max(_START_WORDS, most + 2.0, *(max(1.0, most) * own + 1.0 for own in starts), 0.0)
    bound = np.maximum(bound, bound * (words * 2.0**-bits / bound.min()))
    if laws and bound.max() > ranges.margin:
        raise CheckFailed(
            f"$.network: with convection or radiation errors up to {ranges.margin:g} K can be proven, and it would be "
            f"{rounded_up(float(bound.max())):.1e} K: temperatures change too fast for the sample time"
        )
    proof = NetworkProof(ranges.low, ranges.high, bound, found.defect.max(axis=0), ranges.margin)
    made = NetworkProgram(
        arithmetic,
        bits,
        found.products,
        found.series,
        found.states,
        readings,
        gains,
        *_at_start(weights),
        tuple(model.network.index(node.name) for node in model.network.hidden),
        factors,
        laws,
        _channels(model),
        start_range_mC(model),
        proof,
    )
    _check(coefficients, arithmetic, made)
    return made


def _at_start(weights: FloatArray) -> tuple[IntArray, int]:
    """Weights of sensed nodes in hidden ones' starts as 32-bit words, and their bits: no sum of a row overflows."""
    most = float(weights[:, :-1].sum(axis=1).max(initial=0.0))
    bits = 32 - max(0, ceil(log2(max(most, 1.0) * (1.0 - 2.0**-40))))
    return np.minimum(np.rint(weights[:, :-1] * 2.0**bits).astype(np.int64), 2**32 - 1), bits


def _readings(model: ThermalModel, bits: int) -> tuple[tuple[Reading, ...], GainFormat | None]:
    network = model.network
    assert network is not None
    made, lagging = [], len(network.nodes)
    drifting = lagging + sum(node.sensor is not None and node.sensor.lag > 0.0 for node in network.sensed)
    gains, shape = lower_gains([node.sensor for node in network.sensed if node.sensor is not None])
    for node, gain in zip(network.sensed, gains, strict=True):
        assert node.sensor is not None
        state = network.index(node.name)
        if node.sensor.lag > 0.0:
            state, lagging = lagging, lagging + 1
        offset = round(node.sensor.offset * 2.0**bits)
        drift = None
        if node.sensor.drift:
            drift, drifting = drifting, drifting + 1
        made.append(Reading(node.name, network.index(node.name), state, offset, gain, drift))
    return tuple(made), shape


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
