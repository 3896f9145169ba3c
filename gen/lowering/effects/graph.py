"""Equations as expressions: an effect's own formula, given symbols instead of numbers, becomes a graph with ranges.

:meth:`Effect.heat` and its like are plain arithmetic, so they work on :class:`Node` as on arrays. What depends on |PWM|
alone (a rate, a share of full scale, a schedule) is a numpy array with an entry for each row of the domain and is
computed here once; the rest is left for the board.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from gen.arrays import FloatArray

Operand = tuple[str, int]
"""What the board knows at a sample: its kind and number."""
Op = Literal["operand", "constant", "row", "add", "sub", "mul", "neg"]
Value = "float | FloatArray | Node"


@dataclass(frozen=True)
class Entry:
    """One node of a graph.

    Attributes
    ----------
    op
        What it is; `row` is a table with an entry for each |PWM| of the domain.
    args
        Numbers of other nodes.
    low, high
        Range, in the unit of the formula.
    operand
        Of an operand.
    fraction_bits
        Of an operand: the board's whole number times 2^-fraction_bits is its value.
    table
        Of a constant (one entry) or a row.
    """

    op: Op
    args: tuple[int, ...]
    low: float
    high: float
    operand: Operand | None = None
    fraction_bits: int = 0
    table: tuple[float, ...] = ()

    @property
    def magnitude(self) -> float:
        """Largest absolute value."""
        return max(abs(self.low), abs(self.high))


class Node:
    """A value that the board will know: the result of an operation, with Python's operators."""

    __slots__ = ("graph", "number")
    __array_ufunc__ = None  # array * node asks the node, instead of making an array of nodes

    def __init__(self, graph: Graph, number: int) -> None:
        self.graph = graph
        self.number = number

    def __add__(self, other: object) -> Node:
        return self.graph.add(self, self.graph.node(other))

    def __radd__(self, other: object) -> Node:
        return self.graph.add(self.graph.node(other), self)

    def __sub__(self, other: object) -> Node:
        return self.graph.sub(self, self.graph.node(other))

    def __rsub__(self, other: object) -> Node:
        return self.graph.sub(self.graph.node(other), self)

    def __mul__(self, other: object) -> Node:
        return self.graph.mul(self, self.graph.node(other))

    def __rmul__(self, other: object) -> Node:
        return self.graph.mul(self.graph.node(other), self)

    def __truediv__(self, other: object) -> Node:
        if isinstance(other, Node):
            raise TypeError("the board does not divide by what it learns at a sample")
        return self * (1.0 / np.asarray(other, dtype=np.float64))

    def __neg__(self) -> Node:
        return self.graph.neg(self)

    def __pow__(self, exponent: int) -> Node:
        if exponent == 1:
            return self
        half = self ** (exponent // 2)
        return half * half if exponent % 2 == 0 else half * half * self

    @property
    def entry(self) -> Entry:
        """What stands in the graph."""
        return self.graph.entries[self.number]


@dataclass
class Graph:
    """Nodes, each distinct one once.

    Parameters
    ----------
    rows
        How many |PWM| the domain has.
    """

    rows: int
    entries: list[Entry] = field(default_factory=list)
    _known: dict[object, int] = field(default_factory=dict)

    def operand(self, kind: str, number: int, low: float, high: float, fraction_bits: int = 0) -> Node:
        """A whole number that the board has, times 2^-fraction_bits; its range is held before it is used."""
        return self._make(Entry("operand", (), low, high, (kind, number), fraction_bits))

    def node(self, value: object) -> Node:
        """A number, an array over |PWM| or a node, as a node."""
        if isinstance(value, Node):
            return value
        array = np.asarray(value, dtype=np.float64)
        if array.ndim and np.all(array == array[0]):
            array = array[0]
        if not array.ndim:
            return self._make(Entry("constant", (), float(array), float(array), table=(float(array),)))
        if array.shape != (self.rows,):
            raise ValueError(f"a table by |PWM| has {self.rows} entries, not {array.shape}")
        return self._make(Entry("row", (), float(array.min()), float(array.max()), table=tuple(array.tolist())))

    def add(self, a: Node, b: Node) -> Node:
        """a + b."""
        if _fixed(a) and _fixed(b):
            return self.node(_values(a) + _values(b))
        if _is(a, 0.0) or _is(b, 0.0):
            return b if _is(a, 0.0) else a
        for x, y in ((a, b), (b, a)):
            if x.entry.op == "sub" and x.entry.args[1] == y.number:
                return Node(self, x.entry.args[0])  # (u - y) + y
            if y.entry.op == "neg":
                return self.sub(x, Node(self, y.entry.args[0]))
        return self._make(Entry("add", _sorted(a, b), a.entry.low + b.entry.low, a.entry.high + b.entry.high))

    def sub(self, a: Node, b: Node) -> Node:
        """a - b."""
        if _fixed(a) and _fixed(b):
            return self.node(_values(a) - _values(b))
        if _is(b, 0.0):
            return a
        if _is(a, 0.0):
            return self.neg(b)
        if a.number == b.number:
            return self.node(0.0)
        if b.entry.op == "neg":
            return self.add(a, Node(self, b.entry.args[0]))
        if a.entry.op == "add" and b.number in a.entry.args:  # (u + b) - b
            first, second = a.entry.args
            return Node(self, second if first == b.number else first)
        return self._make(Entry("sub", (a.number, b.number), a.entry.low - b.entry.high, a.entry.high - b.entry.low))

    def mul(self, a: Node, b: Node) -> Node:
        """a b."""
        if _fixed(a) and _fixed(b):
            return self.node(_values(a) * _values(b))
        if _is(a, 0.0) or _is(b, 0.0):
            return self.node(0.0)
        if _is(a, 1.0) or _is(b, 1.0):
            return b if _is(a, 1.0) else a
        if _fixed(a):
            a, b = b, a
        merged = self._merged_factor(a, b) if _fixed(b) else None
        if merged is not None:
            return merged
        args = (a.number, b.number) if _fixed(b) else _sorted(a, b)
        return self._make(Entry("mul", args, *_product_range(a, b)))

    def _merged_factor(self, a: Node, b: Node) -> Node | None:
        """a b, with b, which depends on |PWM| alone, taken into a factor or a sign that a has; None without one."""
        if a.entry.op == "neg":
            return self.mul(Node(self, a.entry.args[0]), self.node(-_values(b)))
        if a.entry.op == "mul":  # (u c) b = u (c b) where c depends on |PWM| alone too
            u, c = (Node(self, number) for number in a.entry.args)
            if _fixed(c):
                return self.mul(u, self.node(_values(c) * _values(b)))
        return None

    def neg(self, a: Node) -> Node:
        """-a."""
        if _fixed(a):
            return self.node(-_values(a))
        if a.entry.op == "neg":
            return Node(self, a.entry.args[0])
        if a.entry.op == "sub":
            return self.sub(Node(self, a.entry.args[1]), Node(self, a.entry.args[0]))
        if a.entry.op == "mul" and _fixed(Node(self, a.entry.args[1])):
            factor = Node(self, a.entry.args[1])
            return self.mul(Node(self, a.entry.args[0]), self.node(-_values(factor)))
        return self._make(Entry("neg", (a.number,), -a.entry.high, -a.entry.low))

    def operands(self, outputs: list[Node]) -> set[Operand]:
        """Operands that the outputs depend on."""
        found: set[Operand] = set()
        seen: set[int] = set()
        stack = [node.number for node in outputs]
        while stack:
            number = stack.pop()
            if number in seen:
                continue
            seen.add(number)
            entry = self.entries[number]
            if entry.operand is not None:
                found.add(entry.operand)
            stack.extend(entry.args)
        return found

    def _make(self, entry: Entry) -> Node:
        key = (entry.op, entry.args, entry.operand, entry.table)
        if key not in self._known:
            self._known[key] = len(self.entries)
            self.entries.append(entry)
        return Node(self, self._known[key])


def _fixed(node: Node) -> bool:
    """Whether it depends on |PWM| at most."""
    return node.entry.op in ("constant", "row")


def _values(node: Node) -> FloatArray:
    table = np.asarray(node.entry.table)
    return table if node.entry.op == "row" else np.asarray(table[0])


def _is(node: Node, value: float) -> bool:
    return node.entry.op == "constant" and node.entry.table[0] == value


def _product_range(a: Node, b: Node) -> tuple[float, float]:
    """Range of a b; a square is never negative."""
    ends = [x * y for x in (a.entry.low, a.entry.high) for y in (b.entry.low, b.entry.high)]
    square_of_both_signs = a.number == b.number and a.entry.low <= 0.0 <= a.entry.high
    return 0.0 if square_of_both_signs else min(ends), max(ends)


def _sorted(a: Node, b: Node) -> tuple[int, int]:
    return (a.number, b.number) if a.number <= b.number else (b.number, a.number)
