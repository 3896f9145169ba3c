"""From a component's schedules to its nested rates and steady rise, as a graph.

A(s) = real(poly(poles)) is a product of real polynomials: one of degree 1 for every real pole, one of degree 2 for
every conjugate pair, and one for all other complex poles together.  Each factor is discretised on its own by a few
terms of its power series (:mod:`gen.lowering.recursion.series`), and the factors are multiplied as polynomials in
delta = z - 1.  A product of small factors needs far fewer terms, and keeps more digits, than the series of A itself.

All poles are scaled by the (sub)sample's length, so that every quantity has the unit of its power of 1/sample.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np

from gen.lowering.onboard.graph import Graph
from gen.lowering.onboard.sources import schedule_node
from gen.lowering.recursion.dynamics import domain_rows
from gen.lowering.recursion.increments import FEEDBACK_FROM_DELTA
from gen.lowering.recursion.series import Monomial, delta_series, weight
from gen.model import Component, ThermalModel
from gen.model.dynamics import MAX_PWM
from gen.model.schedules import EXACT

#: Orders of Ts beyond the leading one that the series may use: poles are at most 0.1/Ts.
_EXTRA_WEIGHT = 6


@dataclass(frozen=True)
class Factor:
    """A real factor of A(s) and its image: coefficients below the leading 1, highest power first, as nodes."""

    continuous: tuple[int, ...]
    discrete: tuple[int, ...]


@dataclass(frozen=True)
class Discretised:
    """The graph and the nodes of its results."""

    graph: Graph
    rates: tuple[int, ...]
    steady: int

    def needed(self) -> list[int]:
        """The nodes that the results need, each after what it uses and close to its first use."""
        order: list[int] = []
        seen: set[int] = set()

        def visit(node: int) -> None:
            if node not in seen:
                seen.add(node)
                for arg in self.graph.nodes[node].args:
                    visit(arg)
                order.append(node)

        for result in (*self.rates, self.steady):
            visit(result)
        return order


def discretise(
    model: ThermalModel, component: Component, substeps: int, tolerance: float, *, series: float | None
) -> Discretised:
    """Build the graph of a component.

    Parameters
    ----------
    model, component
        What to build.
    substeps
        Parts of a sample that the recursion runs in.
    tolerance
        Relative size of a term that may be left out.
    series
        Relative error up to which a sum of exponentials becomes a power series, as fixed point has it; None keeps its
        terms.
    """
    graph = Graph(domain_rows(model))
    name = component.name
    held = component.validity if component.outside == "hold" else (0, MAX_PWM)
    x = graph.input(*held)
    raw = graph.input()
    place = f"components[{model.component_names.index(name)}]"
    with localcontext(EXACT):
        step = Decimal(model.sample_time) / substeps
        factors = _factors(graph, component, x, step, place, tolerance, series=series)
        gain = schedule_node(graph, component.gain, x, step**component.order, f"{place}.gain", "gain", tolerance=series)
    if component.negative_gain == "zero":
        gain = graph.positive_outside(gain, raw, *component.validity)
        graph.label(gain, "gain, not negative outside the validity range", "K per count, per sample^n")
    push = graph.label(graph.times(gain, raw), "gain times |PWM|", "K per sample^n")
    last = graph.constant(1)
    for factor in factors:
        last = graph.mul(last, factor.continuous[-1])
    graph.label(last, "A(0)", "1 per sample^n")
    steady = graph.label(graph.div(push, last), "steady rise S", "K")
    return Discretised(graph, _rates(graph, factors, tolerance, apart=series is not None), steady)


def _factors(
    graph: Graph, component: Component, x: int, step: Decimal, place: str, tolerance: float, *, series: float | None
) -> list[Factor]:
    real: list[Factor] = []
    loose: list[tuple[int, int]] = []
    pairs: list[Factor] = []
    zero = graph.constant(0)
    for k, pole in enumerate(component.poles):
        where = f"{place}.poles[{k}]"
        re = schedule_node(graph, pole.real, x, -step, f"{where}.real", f"-pole {k + 1}, real part", tolerance=series)
        im = zero
        if pole.imag is not None:
            text = f"-pole {k + 1}, imaginary part"
            im = schedule_node(graph, pole.imag, x, -step, f"{where}.imag", text, tolerance=series)
        if im == zero:
            real.append(_discrete(graph, (re,), tolerance))
        elif (re, graph.neg(im)) in loose:
            loose.remove((re, graph.neg(im)))
            square = graph.add(graph.mul(re, re), graph.mul(im, im))
            pairs.append(_discrete(graph, (graph.scale(re, 1), square), tolerance))
        else:
            loose.append((re, im))
    if loose:
        pairs.append(_discrete(graph, _real_part(graph, loose), tolerance))
    return pairs + real


def _real_part(graph: Graph, poles: list[tuple[int, int]]) -> tuple[int, ...]:
    """real(prod(s + re + j im)) without its leading 1."""
    poly = [(graph.constant(1), graph.constant(0))]
    zero = (graph.constant(0), graph.constant(0))
    for re, im in poles:
        poly = [
            (
                graph.add(a, graph.sub(graph.mul(c, re), graph.mul(d, im))),
                graph.add(b, graph.add(graph.mul(c, im), graph.mul(d, re))),
            )
            for (a, b), (c, d) in zip([*poly, zero], [zero, *poly], strict=True)
        ]
    return tuple(re for re, _ in poly[1:])


def _discrete(graph: Graph, alpha: tuple[int, ...], tolerance: float) -> Factor:
    order = len(alpha)
    names = "a" if order == 1 else "q"
    for k, node in enumerate(alpha):
        graph.label(node, f"factor of A, coefficient {names}{k + 1}", f"1 per sample^{k + 1}")
    result = []
    for k, series in enumerate(delta_series(order, _EXTRA_WEIGHT if order < 3 else _EXTRA_WEIGHT - 2)):
        terms = {m: v for m, v in series.items() if weight(m) > 0}
        node = _polynomial(graph, _pruned(graph, terms, alpha, tolerance), alpha)
        result.append(graph.label(node, f"its image in delta, coefficient {k + 1}", f"1 per sample^{k + 1}"))
    return Factor(alpha, tuple(result))


def _pruned(
    graph: Graph, terms: dict[Monomial, Fraction], alpha: tuple[int, ...], tolerance: float
) -> dict[Monomial, Fraction]:
    """Without the monomials that matter at no PWM."""
    sizes = {}
    for monomial, factor in terms.items():
        value = np.full(len(graph.rows), float(factor))
        for node, exponent in zip(alpha, monomial, strict=True):
            value = value * graph.values[node] ** exponent
        sizes[monomial] = value
    whole = np.abs(np.sum(list(sizes.values()), axis=0))
    return {m: terms[m] for m, v in sizes.items() if np.any(np.abs(v) > tolerance * whole)}


def _polynomial(graph: Graph, terms: dict[Monomial, Fraction], variables: tuple[int, ...]) -> int:
    """Nested evaluation; the linear terms stay apart from the small rest so that they keep all their digits."""
    parts, rest = [], {}
    for monomial, factor in terms.items():
        size = abs(factor)  # a minus sign moves on towards the result
        graph.label(graph.constant(size), f"{size}, of the series that turns a pole into its image in delta")
        degree = sum(monomial)
        if degree == 0:
            parts.append(graph.constant(factor))
        elif degree == 1:
            parts.append(graph.mul(graph.constant(factor), variables[monomial.index(1)]))
        else:
            rest[monomial] = factor
    while rest:
        counts = [sum(1 for m in rest if m[i]) for i in range(len(variables))]
        best = max(range(len(variables)), key=lambda i: (counts[i], i))
        inner = {tuple(e - (i == best) for i, e in enumerate(m)): v for m, v in rest.items() if m[best]}
        rest = {m: v for m, v in rest.items() if not m[best]}
        parts.append(graph.mul(variables[best], _polynomial(graph, inner, variables)))
    return graph.total(parts, 0.0)


def _rates(graph: Graph, factors: list[Factor], tolerance: float, *, apart: bool) -> tuple[int, ...]:
    """R0..R[n-1]; sums of sums are made of their terms if they are kept ``apart``, the smallest first."""
    images, leading = _product_of_images(graph, factors, tolerance, apart=apart)
    c = _feedback(graph, images, tolerance, apart=apart)
    rates = []
    for i in range(len(c) - 1):
        if i == 0 and len(factors) > 1:
            # C0 spans many decades: divide before its last factor comes in.
            rate = graph.mul(graph.div(leading, c[1]), factors[-1].discrete[-1])
        else:
            rate = graph.div(c[i], c[i + 1])
        rates.append(rate)
    rates.append(c[-1])
    for i, rate in enumerate(rates):
        graph.label(rate, f"rate R{i}", "1 per sample")
    return tuple(rates)


def _product_of_images(
    graph: Graph, factors: list[Factor], tolerance: float, *, apart: bool
) -> tuple[list[list[int]], int]:
    """The factors' product as polynomials in delta: b1..bn by their terms, and b[n] but for the last factor."""
    one = graph.constant(1)
    product = [[one]]
    leading = one
    for factor in factors:
        sums = [graph.total(terms, tolerance) for terms in product]
        leading = sums[-1]
        terms = [[one], *(graph.terms(d, factor.continuous) if apart else [d] for d in factor.discrete)]
        longer: list[list[int]] = [[] for _ in range(len(product) + len(factor.discrete))]
        for i, j in itertools.product(range(len(product)), range(len(terms))):
            if i == 0 or j == 0:
                longer[i + j] += terms[j] if i == 0 else product[i]
            else:
                longer[i + j].append(graph.mul(sums[i], factor.discrete[j - 1]))
        product = longer if apart else [[graph.total(terms, tolerance)] for terms in longer]
    return product[1:], leading


def _feedback(graph: Graph, images: list[list[int]], tolerance: float, *, apart: bool) -> list[int]:
    """C0..C[n-1] of b1..bn by their terms."""
    order = len(images)
    c: list[int] = []
    for i, row in enumerate(FEEDBACK_FROM_DELTA[order]):
        for f in row:
            graph.label(graph.constant(abs(f)), f"{abs(f)}, from the image in delta to the increments' feedback")
        if apart and i > 1 and i == order - 1:
            terms = [*images[0], graph.neg(c[-1])]  # C[n-1] = b1 - C[n-2] of order 3 and 4
        else:
            terms = [graph.mul(graph.constant(f), t) for f, b in zip(row, images, strict=True) for t in b if f]
        c.append(graph.label(graph.total(terms, tolerance), f"feedback C{i}", f"1 per sample^{order - i}"))
    return c
