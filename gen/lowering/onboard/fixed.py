"""Static formats for a graph: every node becomes an int32 whose largest magnitude in the domain uses 31 bits.

A sum needs both terms in its own format.  A term that nothing else uses is computed in that format in the first
place; a shared one is shifted.
"""

from __future__ import annotations

from dataclasses import replace
from decimal import ROUND_HALF_EVEN, Decimal, localcontext

import numpy as np

from gen.lowering.fixed.formats import RESIDUE_BITS, Format
from gen.lowering.onboard.discretise import Discretised
from gen.lowering.onboard.graph import INTEGERS, Graph, Label, Node
from gen.lowering.onboard.interpolate import largest_sum
from gen.lowering.onboard.tape import DIVIDE_SHIFT, GUARD_BITS, Step
from gen.model.schedules import EXACT

#: Rounding may carry a value past the real one's: a little room at the top.
_LARGEST = 2.0**31 - 256.0
#: By how many bits a product can be shifted up.
_WRAP_BITS = 7
_SUMS = ("add", "sub")


class FixedTape:
    """Turns the graph into steps.

    Parameters
    ----------
    source
        The graph and its results.
    layout
        Formats of the results.
    """

    def __init__(self, source: Discretised, layout: Format) -> None:
        self._graph: Graph = source.graph
        self.steps: list[Step] = []
        self._known: dict[Step, int] = {}
        self._placed: dict[int, tuple[int, int]] = {}
        self._needed = source.needed()
        self._users = dict.fromkeys(self._needed, 0)
        for node in self._needed:
            for arg in self._graph.nodes[node].args:
                self._users[arg] += 1
        self._wide = self._unsigned_sums(source)
        for node in (*source.rates, source.steady):
            self._users[node] += 1
        self._own: dict[int, int] = {}  # the most bits that a node's values leave room for
        self._cap: dict[int, int] = {}
        for node in self._needed:
            self._cap[node] = self._capacity(node)
        self._wanted: dict[int, int] = {}
        steady_bits = layout.fraction_bits[0] - RESIDUE_BITS
        if self._users[source.steady] == 1 and self._graph.nodes[source.steady].op == "div":
            self._wanted[source.steady] = steady_bits
        for node in reversed(self._needed):
            self._demand(node)
        for node in self._needed:
            self._emit(node, floor=node == source.steady)
        self.steady = self._result(source.steady, steady_bits, "floor")
        self.rates = tuple(
            self._result(node, bits, "rate") for node, bits in zip(source.rates, layout.rate_fraction_bits, strict=True)
        )

    # ---- analysis ----

    def _unsigned_sums(self, source: Discretised) -> set[int]:
        """Sums that may use all 32 bits: never negative, and no user needs a sign."""
        nodes, values = self._graph.nodes, self._graph.values
        wide = {n for n in self._needed if nodes[n].op in _SUMS and not np.any(values[n] < 0.0)}
        wide.discard(source.steady)
        for number in self._needed:
            if nodes[number].op not in ("add", "sub", "mul", "div", "scale"):
                for arg in nodes[number].args:
                    wide.difference_update((arg, *(nodes[arg].args if nodes[arg].op == "scale" else ())))
        return wide

    def _largest(self, number: int) -> float:
        node = self._graph.nodes[number]
        if node.op == "power_series":  # a coefficient may be larger than every sum that it enters
            series, inputs = node.data[0], self._graph.values[node.args[0]].astype(int).tolist()
            return float(max(largest_sum(series, inputs), *(abs(c) for c in series.coefficients)))
        return float(np.abs(self._graph.values[number]).max())

    def _capacity(self, number: int) -> int:
        """The most bits after the binary point that a node can have."""
        node = self._graph.nodes[number]
        if node.op in INTEGERS:
            return 0
        largest = self._largest(number)
        room = _LARGEST * 2.0 if number in self._wide else _LARGEST
        own = int(np.floor(np.log2(room / largest))) if largest else 31
        of = [self._cap[a] for a in node.args]
        self._own[number] = own
        limit = {
            "add": lambda: min(self._finest(a) for a in node.args),
            "sub": lambda: min(self._finest(a) for a in node.args),
            "mul": lambda: self._product_bits(node) + _WRAP_BITS,
            "times": lambda: of[0],
            "neg": lambda: of[0],
            "positive_outside": lambda: of[0],
            "scale": lambda: of[0] - int(node.data[0]),
        }.get(node.op)
        return min(own, limit()) if limit else own

    def _finest(self, number: int) -> int:
        """The most bits with which a node can enter a sum; products that nothing else uses may wrap round."""
        node = self._graph.nodes[number]
        if self._users[number] > 1 or node.op != "mul":
            return self._cap[number]
        return self._product_bits(node) + _WRAP_BITS

    def _product_bits(self, node: Node) -> int:
        """Bits of a product's upper word as it is."""
        return sum(self._cap[a] for a in node.args) - 1 - 32

    def _demand(self, number: int) -> None:
        """Hand a node's format on to operands that nothing else uses."""
        node = self._graph.nodes[number]
        bits = self._bits(number)
        wanted = {
            "add": bits,
            "sub": bits,
            "neg": bits,
            "positive_outside": bits,
            "times": bits + 8,
            "scale": bits + (int(node.data[0]) if node.op == "scale" else 0),
        }.get(node.op)
        if wanted is None:
            return
        for arg in node.args:
            if self._graph.nodes[arg].op not in INTEGERS and self._users[arg] == 1:
                if node.op in _SUMS and self._graph.nodes[arg].op in _SUMS and self._cap[arg] > bits + 1:
                    continue  # a sum of small terms keeps its digits, and is rounded once
                self._wanted[arg] = wanted
                if node.op in ("add", "sub"):
                    self._cap[arg] = max(self._cap[arg], min(wanted, self._finest(arg)))

    def _bits(self, number: int) -> int:
        return min(self._wanted.get(number, self._cap[number]), self._cap[number])

    # ---- steps ----

    def _emit(self, number: int, *, floor: bool) -> None:
        node, bits = self._graph.nodes[number], self._bits(number)
        label = self._graph.labels.get(number, Label(""))
        if node.op == "constant":
            return  # printed in the format of each use
        if node.op in INTEGERS:
            args = tuple(self._placed[a][0] for a in node.args)
            placed = self._step(Step(node.op, args, table=node.data, label=label)), 0
        elif node.op == "scale":
            step, q = self._operand(node.args[0], None)
            placed = step, q - int(node.data[0])
        elif node.op == "row":
            placed = self._row(node, bits, label), bits
        elif node.op == "power_series":
            placed = self._power_series(node, bits, label), bits
        elif node.op in ("add", "sub", "neg", "positive_outside"):
            placed = self._in_one_format(number, bits, label), bits
        elif node.op == "times":
            placed = self._times(node, bits, label), bits
        elif node.op == "mul":
            op = "mul_modulo" if bits > self._own[number] else "mul"
            placed = self._product(node, bits, label, op), bits
        else:
            placed = self._quotient(node, bits, label, rounded=not floor), bits
        self._placed[number] = placed

    def _row(self, node: Node, bits: int, label: Label) -> int:
        """A table's entry; those that nothing asks for are 0."""
        used = set(self._graph.values[node.args[0]].astype(np.int64).tolist())
        table = tuple(_whole(v, bits) if i in used else 0 for i, v in enumerate(node.data))
        return self._step(Step("row", (self._placed[node.args[0]][0],), bits, table=table, label=label))

    def _in_one_format(self, number: int, bits: int, label: Label) -> int:
        """An operation whose operands have its own format."""
        graph, node = self._graph, self._graph.nodes[number]
        args = tuple(
            self._placed[a][0] if graph.nodes[a].op in INTEGERS else self._operand(a, bits)[0] for a in node.args
        )
        table = node.data if node.op == "positive_outside" else ()
        wraps = node.op in _SUMS and any(bits > self._own.get(a, bits) for a in node.args)
        op = f"{node.op}_modulo" if wraps else node.op
        # Unsigned only where the top bit is in use.
        unsigned = number in self._wide and self._largest(number) * 2.0**bits > _LARGEST
        return self._step(Step(op, args, bits, table=table, unsigned=unsigned, label=label))

    def _times(self, node: Node, bits: int, label: Label) -> int:
        """A value times a whole number."""
        own = self._cap[node.args[0]]
        operand, q = self._operand(node.args[0], min(own, bits + 8) if own > bits + 8 else None)
        return self._step(Step("times", (operand, self._placed[node.args[1]][0]), bits, 8 + bits - q, label=label))

    def _quotient(self, node: Node, bits: int, label: Label, *, rounded: bool) -> int:
        (a, qa), (b, qb) = self._operand(node.args[0], None), self._operand(node.args[1], None)
        shift = bits - qa + qb
        if shift < DIVIDE_SHIFT:  # what the board's division starts from: a numerator with bits to spare
            a, shift = self._shifted(a, qa, qa - (DIVIDE_SHIFT - shift), "shr"), DIVIDE_SHIFT
        values = self._graph.values[node.args[0]]
        # What is not exactly 0 could be rounded below it.
        never = self.steps[a].unsigned or not np.any((values != 0.0) & (values < 2.0 ** (8 - qa)))
        return self._step(Step("div" if never else "div_signed", (a, b), bits, shift, round=rounded, label=label))

    def _power_series(self, node: Node, bits: int, label: Label) -> int:
        series = node.data[0]
        args = (self._placed[node.args[0]][0],)
        table = tuple(_whole(c, bits + GUARD_BITS) for c in series.coefficients)
        return self._step(Step("power_series", args, bits, int(series.reflected), table=table, label=label))

    def _product(self, node: Node, bits: int, label: Label, op: str) -> int:
        first, second = node.args
        if (first in self._wide and second not in self._wide) or np.any(self._graph.values[second] < 0.0):
            first, second = second, first
        if np.any(self._graph.values[second] < 0.0):
            op = op.replace("mul", "mul_signed")
        (a, qa), (b, qb) = self._operand(first, None), self._operand(second, None)
        if self.steps[a].unsigned:
            if self.steps[b].unsigned:
                a, qa = self._shifted(a, qa, qa - 1, "shr"), qa - 1  # one of the two has a sign bit
            else:
                a, qa, b, qb = b, qb, a, qa
        shift = bits - qa - qb + 32
        if shift >= 0:
            return self._step(Step(op, (a, b), bits, shift, label=label))
        full = self._step(Step(op, (a, b), bits - shift, 0, label=label))
        return self._step(Step("shr", (full,), bits, -shift, label=_again(label)))

    def _operand(self, number: int, bits: int | None) -> tuple[int, int]:
        """A node in a format (None: its own)."""
        node = self._graph.nodes[number]
        if node.op == "constant":
            q = self._cap[number] if bits is None else bits
            label = self._graph.labels.get(number, Label("constant"))
            return self._step(Step("constant", (), q, table=(_whole(node.data[0], q),), label=label)), q
        step, q = self._placed[number]
        if bits is None or bits == q:
            return step, q
        return self._shifted(step, q, bits, "shr"), bits

    def _shifted(self, step: int, q: int, bits: int, op: str) -> int:
        label = _again(self.steps[step].label)
        if bits > q:
            unsigned = op == "rate"
            return self._step(Step("shl", (step,), bits, bits - q, unsigned=unsigned, label=label))
        op = "floor" if op == "floor" else "shr"
        return self._step(Step(op, (step,), bits, q - bits, label=label))

    def _result(self, number: int, bits: int, op: str) -> int:
        node = self._graph.nodes[number]
        if node.op == "constant":
            label = self._graph.labels.get(number, Label("constant"))
            table = (_whole(node.data[0], bits),)
            return self._step(Step("constant", (), bits, table=table, unsigned=op == "rate", label=label))
        step, q = self._placed[number]
        return step if q == bits else self._shifted(step, q, bits, op)

    def _step(self, step: Step) -> int:
        key = replace(step, label=Label(""))
        if key not in self._known:
            self._known[key] = len(self.steps)
            self.steps.append(step)
        return self._known[key]


def _again(label: Label) -> Label:
    return replace(label, text=f"{label.text}, in the format of its use") if label.text else label


def _whole(value: Decimal, bits: int) -> int:
    with localcontext(EXACT):
        return int((value * Decimal(2) ** bits).to_integral_value(ROUND_HALF_EVEN))
