"""A network's differential equations as terms: a rate times the difference of two temperatures, and heats.

Rates are per sample. With the ambient, sensors and heat that grows with temperature in the same form, one loop over
terms is the whole model.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gen.lowering.recursion.dynamics import domain_rows
from gen.model import ThermalModel
from gen.model.network import Factor, Network

Array = NDArray[np.float64]
Source = Literal["state", "ambient", "reference"]
_GRID = 257
"""Values of a channel at which a factor's ends are looked for, beside the points of its table."""


@dataclass(frozen=True, eq=False)
class Term:
    """``T_target += rate * (source - T_target)`` in first order.

    Attributes
    ----------
    target
        A state.
    source
        Of what kind: another state, the ambient, or a fixed temperature.
    other
        The state, where it is one.
    reference
        The fixed temperature, degC, where it is one.
    growing
        Whether the difference counts the other way round: heat that grows with temperature.
    rate
        Per sample by row of the domain, every factor 1, shape (rows,), >= 0.
    factors
        Indices into :attr:`Terms.factors`, all multiply the rate.
    label
        Where it comes from, for people.
    """

    target: int
    source: Source
    other: int
    reference: float
    growing: bool
    rate: Array
    factors: tuple[int, ...]
    label: str


@dataclass(frozen=True, eq=False)
class Warmth:
    """Heat that does not depend on temperatures: ``T_target += heat``.

    Attributes
    ----------
    target
        A state.
    heat
        K per sample by row of the domain, every factor 1, shape (rows,), >= 0.
    factors
        As for :class:`Term`.
    label
        Where it comes from, for people.
    """

    target: int
    heat: Array
    factors: tuple[int, ...]
    label: str


@dataclass(frozen=True, eq=False)
class Terms:
    """All of a network.

    Attributes
    ----------
    states
        Names: the nodes, then a reading for each sensor that lags.
    terms, heats
        In the order of the file.
    factors
        Different ones among all paths and heats.
    spans
        Least and largest value of each factor over its channel's range, shape (factors, 2).
    """

    states: tuple[str, ...]
    terms: tuple[Term, ...]
    heats: tuple[Warmth, ...]
    factors: tuple[Factor, ...]
    spans: Array

    def of(self, target: int) -> tuple[Term, ...]:
        """The terms of one state."""
        return tuple(term for term in self.terms if term.target == target)

    def heats_of(self, target: int) -> tuple[Warmth, ...]:
        """The heats of one state."""
        return tuple(heat for heat in self.heats if heat.target == target)

    def corners(self, target: int) -> list[dict[int, float]]:
        """Each combination of ends of the factors that one state's row reads.

        A row is affine in each of its factors, so that its extremes over all that channels may say are among these.
        """
        own: tuple[Term | Warmth, ...] = (*self.of(target), *self.heats_of(target))
        used = sorted({k for part in own for k in part.factors})
        return [dict(zip(used, ends, strict=True)) for ends in product(*(self.spans[k] for k in used))]

    def largest(self, factors: tuple[int, ...]) -> float:
        """Largest value of a product of factors."""
        return float(np.prod([self.spans[k, 1] for k in factors]))


def lagging_reading(node: str) -> str:
    """Name of the state that follows a node as its sensor does; no node can be called so."""
    return f"{node}.sensor"


def identifier(state: str) -> str:
    """A state's name in the C++, behind the model's: like no function or type there, whatever its node is called."""
    node, _, sensor = state.partition(".")
    return f"{'S' if sensor else 'T'}_{node}"


def scaled(part: Term | Warmth, corner: dict[int, float]) -> Array:
    """A term's rate, or a heat, by row of the domain, with factors as a corner has them."""
    values = part.rate if isinstance(part, Term) else part.heat
    return np.asarray(values * float(np.prod([corner[k] for k in part.factors])), dtype=np.float64)


def terms_of(model: ThermalModel) -> Terms:
    """Write a network as terms over its domain.

    Parameters
    ----------
    model
        A model that holds a network.
    """
    network = model.network
    assert network is not None
    rows, step = domain_rows(model), model.sample_time
    factors: list[Factor] = []

    def known(own: tuple[Factor, ...]) -> tuple[int, ...]:
        factors.extend(factor for factor in own if factor not in factors)
        return tuple(factors.index(factor) for factor in own)

    terms: list[Term] = []
    for number, path in enumerate(network.paths):
        conductance = network.conductances[rows, number] * step
        for here, there in ((path.first, path.second), (path.second, path.first)):
            if here is None or not conductance.any():
                continue
            target = network.index(here)
            source: Source = "ambient" if there is None else "state"
            other = -1 if there is None else network.index(there)
            rate = conductance / network.capacities[target]
            terms.append(Term(target, source, other, 0.0, False, rate, known(path.factors), f"paths[{number}]"))
    heats: list[Warmth] = []
    for number, heat in enumerate(network.heats):
        target = network.index(heat.node)
        warmth = network.powers[rows, number] * step / network.capacities[target]
        own, label = known(heat.factors), f"heats[{number}]"
        if warmth.any():
            heats.append(Warmth(target, warmth, own, label))
        if heat.per_K and warmth.any():
            rate = warmth * abs(heat.per_K)
            terms.append(Term(target, "reference", -1, heat.reference, heat.per_K > 0.0, rate, own, f"{label}.per_K"))
    names = [node.name for node in network.nodes]
    for node in network.sensed:
        if node.sensor is not None and node.sensor.lag > 0.0:
            rate = np.full(len(rows), step / node.sensor.lag)
            label = f"nodes[{network.index(node.name)}].sensor"
            terms.append(Term(len(names), "state", network.index(node.name), 0.0, False, rate, (), label))
            names.append(lagging_reading(node.name))
    return Terms(tuple(names), tuple(terms), tuple(heats), tuple(factors), _spans(network, factors))


def _spans(network: Network, factors: list[Factor]) -> Array:
    spans = np.ones((len(factors), 2))
    for k, factor in enumerate(factors):
        channel = network.channel(factor.channel)
        inner = [value for value in factor.at if channel.low < value < channel.high]
        if factor.polynomial:
            slope = np.polyder(np.asarray(factor.polynomial))
            turns = np.roots(slope) if slope.size > 1 else np.zeros(0)
            inner += [float(t.real) for t in turns if abs(t.imag) < 1e-9 and channel.low < t.real < channel.high]
        points = np.array([channel.low, *inner, channel.high, *np.linspace(channel.low, channel.high, _GRID)])
        values = np.maximum(factor(points), 0.0)
        spans[k] = values.min(), values.max()
    return spans
