"""Where hidden nodes start, in exact ratios."""

from __future__ import annotations

from gen.certificate.exact import Ratio, inverse, ratios
from gen.certificate.network.document import NetworkCertificate


def rest_weights(certificate: NetworkCertificate) -> list[dict[int | None, Ratio]]:
    """Where hidden nodes start: weights of measured nodes and, under None, the ambient.

    That is where they would rest at |PWM| 0 with neutral channels, or what is claimed of them in its place, their rise
    over the ambient times their factor. A node that nothing ties to these starts at the ambient.
    """
    own, hidden = certificate.equations, certificate.hidden
    neutral = [_neutral(certificate, k) for k in range(len(own.factors))]
    ties: dict[int, dict[int | None, Ratio]] = {node: {} for node in hidden}
    for path in own.paths:
        conductance = Ratio(path.at_rest_W_per_K)
        for k in path.factors:
            conductance *= neutral[k]
        first, second = path.between
        for here, there in ((first, second), (second, first)):
            if here is not None and here in ties and conductance:
                ties[here][there] = ties[here].get(there, Ratio(0)) + conductance
    reached = {node for node in hidden if any(there not in ties for there in ties[node])}
    while True:
        further = {node for node in hidden if reached & {there for there in ties[node] if there is not None}} - reached
        if not further:
            break
        reached |= further
    solved = _solved({node: ties[node] for node in hidden if node in reached})
    made = []
    for node in hidden:
        state = certificate.states[node]
        weights = solved.get(node, {})
        if state.start_from is not None:
            weights = {place: Ratio(weight) for place, weight in state.start_from}
        made.append(_warmer(weights, state.start_factor))
    return made


def _warmer(weights: dict[int | None, Ratio], factor: float | None) -> dict[int | None, Ratio]:
    times = Ratio(1 if factor is None else factor)
    made: dict[int | None, Ratio] = {}
    made |= {place: weight * times for place, weight in weights.items() if place is not None}
    made[None] = 1 - sum(made.values(), Ratio(0))
    return made


def _solved(ties: dict[int, dict[int | None, Ratio]]) -> dict[int, dict[int | None, Ratio]]:
    """Weights of what is given in the balance of nodes that are tied to it and to each other."""
    nodes = list(ties)
    if not nodes:
        return {}
    given = list(dict.fromkeys(there for own in ties.values() for there in own if there not in ties))
    system = [[sum(ties[a].values()) if a == b else -ties[a].get(b, Ratio(0)) for b in nodes] for a in nodes]
    back = inverse(ratios(system))
    right = ratios([[ties[node].get(there, Ratio(0)) for there in given] for node in nodes])
    weights = back @ right
    return {node: dict(zip(given, row, strict=True)) for node, row in zip(nodes, weights, strict=True)}


def _neutral(certificate: NetworkCertificate, place: int) -> Ratio:
    """A factor at its channel's neutral value, never below 0."""
    factor = certificate.equations.factors[place]
    x = Ratio(certificate.equations.channels[factor.channel].neutral, 1000)
    if factor.polynomial:
        value = Ratio(0)
        for coefficient in factor.polynomial:
            value = value * x + Ratio(coefficient)
        return max(value, Ratio(0))
    at, values = ([Ratio(one) for one in many] for many in (factor.at, factor.value))
    if x <= at[0]:
        return max(values[0], Ratio(0))
    for (a, y), (b, z) in zip(zip(at, values, strict=True), zip(at[1:], values[1:], strict=True), strict=False):
        if x <= b:
            return max(y + (z - y) * (x - a) / (b - a), Ratio(0))
    return max(values[-1], Ratio(0))
