"""The schedule of one component as a graph of real-valued operations over |PWM|.

Equal operations share one node, operations on constants are done here, and a minus sign moves towards the result
so that poles which differ in sign only are the same node.  Every node knows its values over the whole domain: it is
small enough (at most 256 inputs) to decide everything else by looking at all of it.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.lowering.onboard.interpolate import PowerSeries
from gen.model.dynamics import MAX_PWM
from gen.model.schedules import EXACT

#: Nodes whose value is a whole number 0..255 in a byte of its own: |PWM| held to a range, the place in a table.
INTEGERS = frozenset({"input", "segment", "local"})


@dataclass(frozen=True)
class Node:
    """One operation.

    Attributes
    ----------
    op
        ``input`` (lo, hi), ``segment`` and ``local`` (knots) give whole numbers; ``constant`` (value),
        ``exponential`` (a, b), ``power_series`` (:class:`PowerSeries`), ``row`` (values), ``times`` (by a whole
        number), ``add``, ``sub``, ``mul``, ``div``, ``neg``, ``scale`` (k: times 2^k), ``positive_outside`` (lo, hi:
        max(v, 0) where the input is outside).
    args
        Nodes that it uses.
    data
        Its parameters.
    """

    op: str
    args: tuple[int, ...] = ()
    data: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Label:
    """What a node is, for people: text, unit, and the place in the coefficient file ("" if derived)."""

    text: str
    unit: str = ""
    path: str = ""


UNLABELLED = Label("")


@lru_cache(maxsize=256)
def exponential_factors(a: Decimal, b: Decimal) -> tuple[tuple[Decimal, ...], tuple[Decimal, ...]]:
    """Factors of a e^(b x) for the upper and lower four bits of x; a is in the second, 16 each."""
    with localcontext(EXACT):
        return tuple((b * 16 * i).exp() for i in range(16)), tuple(a * (b * i).exp() for i in range(16))


class Graph:
    """Builds nodes; every method returns the number of a node.

    Parameters
    ----------
    rows
        |PWM| of the domain, in ascending order.
    """

    def __init__(self, rows: IntArray) -> None:
        self.rows = rows
        self.nodes: list[Node] = []
        self.values: list[FloatArray] = []
        self.labels: dict[int, Label] = {}
        self._known: dict[Node, int] = {}

    def label(self, node: int, text: str, unit: str = "", path: str = "") -> int:
        """Say what a node is; the first label stays."""
        self.labels.setdefault(node, Label(text, unit, path))
        return node

    # ---- leaves ----

    def constant(self, value: Decimal | Fraction | int) -> int:
        """A constant."""
        if isinstance(value, Fraction):
            with localcontext(EXACT):
                value = Decimal(value.numerator) / value.denominator
        value = Decimal(value)
        return self._node(Node("constant", (), (value,)), np.full(len(self.rows), float(value)))

    def input(self, lo: int = 0, hi: int = MAX_PWM) -> int:
        """|PWM|, held to lo..hi."""
        lo, hi = max(lo, 0), min(hi, MAX_PWM)
        return self._node(Node("input", (), (lo, hi)), np.clip(self.rows, lo, hi).astype(np.float64))

    def place(self, x: int, knots: tuple[int, ...]) -> tuple[int, int]:
        """Which interval of a table the whole number x is in, and how far from its start."""
        values = self.values[x]
        segment = np.clip(np.searchsorted(np.array(knots), values, side="right") - 1, 0, len(knots) - 2)
        held = np.clip(values, knots[0], knots[-1])
        index = self._node(Node("segment", (x,), knots), segment.astype(np.float64))
        return index, self._node(Node("local", (x, index), knots), held - np.array(knots)[segment])

    def row(self, segment: int, values: tuple[Decimal, ...]) -> int:
        """One of several constants, by the interval of a table."""
        if len(set(values)) == 1:
            return self.constant(values[0])
        chosen = np.array([float(v) for v in values])[self.values[segment].astype(np.int64)]
        return self._node(Node("row", (segment,), values), chosen)

    def exponential(self, x: int, a: Decimal, b: Decimal) -> int:
        """a e^(b x) of the whole number x."""
        if a == 0 or b == 0:
            return self.constant(a)
        high, low = (np.array([float(v) for v in part]) for part in exponential_factors(a, b))
        index = self.values[x].astype(np.int64)
        return self._node(Node("exponential", (x,), (a, b)), high[index >> 4] * low[index & 15])

    def power_series(self, x: int, series: PowerSeries) -> int:
        """A polynomial of the whole number x."""
        if len(series.coefficients) == 1:
            return self.constant(series.coefficients[0])
        with localcontext(EXACT):
            values = [float(series.sums(Decimal(int(v)))[-1]) for v in self.values[x]]
        return self._node(Node("power_series", (x,), (series,)), np.array(values))

    # ---- operations ----

    def times(self, a: int, integer: int) -> int:
        """A real by a whole number."""
        if self._constant(a) == 0:
            return a
        positive = self._positive(a)
        if positive is not None:
            return self.neg(self.times(positive, integer))
        return self._node(Node("times", (a, integer)), self.values[a] * self.values[integer])

    def neg(self, a: int) -> int:
        """-a."""
        value = self._constant(a)
        if value is not None:
            return self.constant(-value)
        positive = self._positive(a)
        return positive if positive is not None else self._node(Node("neg", (a,)), -self.values[a])

    def add(self, a: int, b: int) -> int:
        """a + b."""
        left, right = self._constant(a), self._constant(b)
        if left is not None and right is not None:
            return self.constant(left + right)
        if left == 0:
            return b
        if right == 0:
            return a
        first, second = self._positive(a), self._positive(b)
        if first is not None and second is not None:
            return self.neg(self.add(first, second))
        if second is not None:
            return self.sub(a, second)
        if first is not None:
            return self.sub(b, first)
        a, b = sorted((a, b))
        if a == b:
            return self.scale(a, 1)
        return self._node(Node("add", (a, b)), self.values[a] + self.values[b])

    def sub(self, a: int, b: int) -> int:
        """a - b."""
        if a == b:
            return self.constant(0)
        if self._constant(b) is not None or self._positive(b) is not None:
            return self.add(a, self.neg(b))
        if self._constant(a) == 0:
            return self.neg(b)
        first = self._positive(a)
        if first is not None:
            return self.neg(self.add(first, b))
        return self._node(Node("sub", (a, b)), self.values[a] - self.values[b])

    def mul(self, a: int, b: int) -> int:
        """a b."""
        for this, other in ((a, b), (b, a)):
            value = self._constant(this)
            if value is None:
                positive = self._positive(this)
                if positive is not None:
                    return self.neg(self.mul(positive, other))
                continue
            if value == 0:
                return this
            second = self._constant(other)
            if second is not None:
                return self.constant(EXACT.multiply(value, second))
            if value < 0:
                return self.neg(self.mul(self.constant(-value), other))
            power = Fraction(value)
            if power.numerator & (power.numerator - 1) == 0 == power.denominator & (power.denominator - 1):
                return self.scale(other, power.numerator.bit_length() - power.denominator.bit_length())
        for this, other in ((a, b), (b, a)):
            if self.nodes[this].op == "scale":
                return self.scale(self.mul(self.nodes[this].args[0], other), int(self.nodes[this].data[0]))
        a, b = sorted((a, b))
        return self._node(Node("mul", (a, b)), self.values[a] * self.values[b])

    def div(self, a: int, b: int) -> int:
        """a / b."""
        value = self._constant(b)
        if value is not None:
            return self.mul(a, self.constant(EXACT.divide(Decimal(1), value)))
        if self._constant(a) == 0:
            return a
        first, second = self._positive(a), self._positive(b)
        if first is not None:
            return self.neg(self.div(first, b))
        if second is not None:
            return self.neg(self.div(a, second))
        return self._node(Node("div", (a, b)), self.values[a] / self.values[b])

    def scale(self, a: int, k: int) -> int:
        """a 2^k."""
        if k == 0:
            return a
        node = self.nodes[a]
        if node.op == "constant":
            return self.constant(EXACT.multiply(node.data[0], EXACT.power(Decimal(2), Decimal(k))))
        if node.op == "neg":
            return self.neg(self.scale(node.args[0], k))
        if node.op == "scale":
            return self.scale(node.args[0], k + int(node.data[0]))
        return self._node(Node("scale", (a,), (k,)), self.values[a] * 2.0**k)

    def positive_outside(self, a: int, x: int, lo: int, hi: int) -> int:
        """max(a, 0) where the whole number x is outside lo..hi, else a."""
        outside = (self.values[x] < lo) | (self.values[x] > hi)
        chosen = np.where(outside & (self.values[a] < 0.0), 0.0, self.values[a])
        if np.array_equal(chosen, self.values[a]):
            return a
        return self._node(Node("positive_outside", (a, x), (lo, hi)), chosen)

    def total(self, terms: list[int], tolerance: float) -> int:
        """Sum, the smallest first; what is below ``tolerance`` of the sum at every PWM is left out."""
        if not terms:
            return self.constant(0)
        whole = np.abs(np.sum([self.values[t] for t in terms], axis=0))
        kept = [t for t in terms if np.any(np.abs(self.values[t]) > tolerance * whole)] or terms[:1]
        kept.sort(key=lambda t: float(np.abs(self.values[t]).max()))
        result = kept[0]
        for term in kept[1:]:
            result = self.add(result, term)
        return result

    def terms(self, node: int, whole: Container[int]) -> list[int]:
        """The terms of a sum; sums in ``whole`` stay as they are."""
        op, args = self.nodes[node].op, self.nodes[node].args
        if node in whole or op not in ("add", "sub"):
            return [node]
        second = self.terms(args[1], whole)
        return [*self.terms(args[0], whole), *(second if op == "add" else map(self.neg, second))]

    # ---- inner workings ----

    def _constant(self, node: int) -> Decimal | None:
        return self.nodes[node].data[0] if self.nodes[node].op == "constant" else None

    def _positive(self, node: int) -> int | None:
        return self.nodes[node].args[0] if self.nodes[node].op == "neg" else None

    def _node(self, node: Node, values: FloatArray) -> int:
        if node not in self._known:
            self._known[node] = len(self.nodes)
            self.nodes.append(node)
            self.values.append(values)
        return self._known[node]
