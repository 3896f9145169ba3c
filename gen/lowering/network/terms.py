"""A network's differential equations as terms: a rate times the difference of two temperatures, and heats.

Rates are per sample. With the ambient, sensors and heat that grows with temperature in the same form, one loop over
terms is the whole model.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from math import prod
from typing import Literal

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.recursion.dynamics import domain_rows
from gen.model import ThermalModel
from gen.model.laws import Law
from gen.model.network import Network
from gen.model.network_parts import Factor

Source = Literal["state", "ambient", "reference"]
_GRID = 257
"""Values of a channel at which a factor's ends are looked for, beside the points of its table."""


@dataclass(frozen=True, eq=False)
class PathLaw:
    """What stands in the place of a difference on one path.

    Attributes
    ----------
    index, path
        Its position among the laws, and its path's in the file.
    law
        Of which kind.
    first, second
        States at its ends; None for the ambient.
    scale
        What drives, and its slope, count as that much less, and its terms' rates as that much more.
    slopes, steepest
        Ends of its slope by the first end's temperature, and a bound of the slope's own slope in 1/K; less the scale.
    """

    index: int
    path: int
    law: Law
    first: int
    second: int | None
    scale: float = 1.0
    slopes: tuple[float, float] = (0.0, np.inf)
    steepest: float = np.inf

    def driving(self, one: float, other: float) -> float:
        """The difference that counts from one temperature in degC to another, K."""
        return float(self.law.driving(one, other)) / self.scale

    def slope(self, one: float, other: float) -> float:
        """Its derivative by the first one."""
        return float(self.law.slope(one, other)) / self.scale

    def largest(self, one: tuple[float, float], other: tuple[float, float]) -> float:
        """Largest magnitude of what drives between two ranges: it grows with one end and falls with the other, K."""
        return max(self.driving(one[1], other[0]), -self.driving(one[0], other[1]))

    def with_limits(self, scale: float, slopes: tuple[float, float], steepest: float) -> PathLaw:
        """The same with what it can be."""
        return replace(self, scale=scale, slopes=slopes, steepest=steepest)


@dataclass(frozen=True, eq=False)
class Term:
    """``T_target += rate * (source - T_target)`` in first order, or times what a law makes of that difference.

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
    law
        Of its path; None for the difference itself.
    """

    target: int
    source: Source
    other: int
    reference: float
    growing: bool
    rate: FloatArray
    factors: tuple[int, ...]
    label: str
    law: PathLaw | None = None


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
    heat: FloatArray
    factors: tuple[int, ...]
    label: str


@dataclass(frozen=True, eq=False)
class Terms:
    """All of a network.

    Attributes
    ----------
    states
        Names: the nodes, then a reading for each sensor that lags, then how far each has drifted that drifts, in K.
    terms, heats
        In the order of the file.
    factors
        Different ones among all paths and heats.
    spans
        Least and largest value of each factor over its channel's range, shape (factors, 2).
    laws
        Of the paths that have one.
    """

    states: tuple[str, ...]
    terms: tuple[Term, ...]
    heats: tuple[Warmth, ...]
    factors: tuple[Factor, ...]
    spans: FloatArray
    laws: tuple[PathLaw, ...] = ()

    def of(self, target: int) -> tuple[Term, ...]:
        """The terms of one state."""
        return tuple(term for term in self.terms if term.target == target)

    def heats_of(self, target: int) -> tuple[Warmth, ...]:
        """The heats of one state."""
        return tuple(heat for heat in self.heats if heat.target == target)

    def corners(self, target: int, *, laws: bool = False) -> list[dict[int, float]]:
        """Each combination of ends of the factors that one state's row reads.

        A row is affine in each of its factors, so that its extremes over all that channels may say are among these.

        Parameters
        ----------
        target
            A state.
        laws
            Whether the laws' slopes count among them, under :func:`slope_of`.
        """
        own: tuple[Term | Warmth, ...] = (*self.of(target), *self.heats_of(target))
        used = sorted({k for part in own for k in part.factors})
        ends = [self.spans[k] for k in used]
        for law in (term.law for term in self.of(target) if laws and term.law is not None):
            used.append(slope_of(law))
            ends.append(np.array(law.slopes))
        return [dict(zip(used, values, strict=True)) for values in product(*ends)]

    def with_laws(self, laws: tuple[PathLaw, ...]) -> Terms:
        """The same with laws in other scales, which their terms' rates count in."""
        terms = tuple(
            term if term.law is None else replace(term, law=(new := laws[term.law.index]), rate=term.rate * new.scale)
            for term in self.terms
        )
        return replace(self, terms=terms, laws=laws)

    def largest(self, factors: tuple[int, ...]) -> float:
        """Largest value of a product of factors."""
        return prod((float(self.spans[k, 1]) for k in factors), start=1.0)

    @cached_property
    def most(self) -> tuple[FloatArray, ...]:
        """Largest change of each term's target for each kelvin, per sample by row of the domain, shape (rows,) each."""
        slopes = (1.0 if term.law is None else term.law.slopes[1] for term in self.terms)
        return tuple(
            term.rate * (self.largest(term.factors) * slope) for term, slope in zip(self.terms, slopes, strict=True)
        )


def slope_of(law: PathLaw) -> int:
    """Under which number a corner has a law's slope: factors have those from 0 on."""
    return -1 - law.index


_INITIALS = {"": "T", "sensor": "S", "drift": "D"}
"""Of what a state is: a node's temperature, what its sensor shows, how far that has drifted."""


def lagging_reading(node: str) -> str:
    """Name of the state that follows a node as its sensor does; no node can be called so."""
    return f"{node}.sensor"


def drifting_sensor(node: str) -> str:
    """Name of the state that says how far a node's sensor has drifted since the start."""
    return f"{node}.drift"


def identifier(state: str) -> str:
    """A state's name in the C++, behind the model's: like no function or type there, whatever its node is called."""
    node, _, of = state.partition(".")
    return f"{_INITIALS[of]}_{node}"


def scaled(part: Term | Warmth, corner: dict[int, float]) -> FloatArray:
    """A term's rate, or a heat, by row of the domain, with factors as a corner has them."""
    values = part.rate if isinstance(part, Term) else part.heat
    return np.asarray(values * prod((corner[k] for k in part.factors), start=1.0), dtype=np.float64)


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
    laws: list[PathLaw] = []
    for number, path in enumerate(network.paths):
        conductance = network.conductances[rows, number] * step
        law: PathLaw | None = None
        if path.law is not None and conductance.any():
            second = None if path.second is None else network.index(path.second)
            law = PathLaw(len(laws), number, path.law, network.index(path.first), second)
            laws.append(law)
        for here, there in ((path.first, path.second), (path.second, path.first)):
            if here is None or not conductance.any():
                continue
            target = network.index(here)
            source: Source = "ambient" if there is None else "state"
            other = -1 if there is None else network.index(there)
            rate = conductance / network.capacities[target]
            terms.append(Term(target, source, other, 0.0, False, rate, known(path.factors), f"paths[{number}]", law))
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
    for node in network.sensed:
        if node.sensor is not None and node.sensor.drift:
            rate = np.full(len(rows), step / node.sensor.settling)
            label = f"nodes[{network.index(node.name)}].sensor.drift_h"
            terms.append(Term(len(names), "reference", -1, node.sensor.drift, False, rate, (), label))
            names.append(drifting_sensor(node.name))
    return Terms(tuple(names), tuple(terms), tuple(heats), tuple(factors), _spans(network, factors), tuple(laws))


def _spans(network: Network, factors: list[Factor]) -> FloatArray:
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
