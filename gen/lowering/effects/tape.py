"""A graph as the board computes it: a straight line of steps on int32 or float32 values.

=========  ==========================================================================================
step       in fixed point (q: bits after the binary point of the result)
=========  ==========================================================================================
operand    a whole number of the board's; shift 0
constant   table[0]
row        table[row of |PWM|]
add, sub   round(a 2^-shifts[0]) +- round(b 2^-shifts[1])
mul        round(a b 2^-shifts[0]), the product in 64 bits
neg        -a
=========  ==========================================================================================

round is to the nearest, halves upwards. In float32 every step is one operation, and an operand is converted and then
multiplied by 2^-q. Ranges come from the graph, and a value fills at most 30 bits, which leaves one for rounding: no
operation can overflow, whatever the operands within their ranges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, log2

import numpy as np

from gen.lowering.effects.graph import Entry, Graph, Node, Op, Operand
from gen.lowering.kinds import Arithmetic

#: Bits of a value's magnitude; the 31st is room for rounding.
VALUE_BITS = 30
#: More bits after the binary point than this carry nothing: what they resolve is far below all that is added to it.
_MOST_FRACTION_BITS = 60
_MOST_SHIFT = 31


@dataclass(frozen=True)
class Step:
    """One operation on earlier steps' results, see the module's table."""

    op: Op
    args: tuple[int, ...] = ()
    q: int = 0
    shifts: tuple[int, ...] = ()
    operand: Operand | None = None
    table: tuple[int, ...] | tuple[float, ...] = ()


@dataclass(frozen=True)
class Tape:
    """What computes some outputs.

    Attributes
    ----------
    arithmetic
        Which.
    steps
        In order.
    outputs
        Numbers of the steps with the results.
    """

    arithmetic: Arithmetic
    steps: tuple[Step, ...]
    outputs: tuple[int, ...]

    @property
    def operands(self) -> frozenset[Operand]:
        """What it needs."""
        return frozenset(step.operand for step in self.steps if step.operand is not None)

    def output_bits(self, number: int) -> int:
        """Bits after the binary point of an output (fixed point)."""
        return self.steps[self.outputs[number]].q


def record(graph: Graph, outputs: Sequence[Node], arithmetic: Arithmetic) -> Tape:
    """Put the nodes that the outputs need in order, with formats.

    Parameters
    ----------
    graph, outputs
        What to compute.
    arithmetic
        In which arithmetic.
    """
    needed: set[int] = set()
    stack = [node.number for node in outputs]
    while stack:
        number = stack.pop()
        if number not in needed:
            needed.add(number)
            stack.extend(graph.entries[number].args)
    steps: list[Step] = []
    placed: dict[int, int] = {}
    for number in sorted(needed):  # a node's arguments were made before it
        entry = graph.entries[number]
        args = tuple(placed[a] for a in entry.args)
        placed[number] = len(steps)
        steps.append(_fixed(entry, args, steps) if arithmetic == "fixed" else _single(entry, args))
    return Tape(arithmetic, tuple(steps), tuple(placed[node.number] for node in outputs))


def _single(entry: Entry, args: tuple[int, ...]) -> Step:
    table = tuple(float(np.float32(v)) for v in entry.table)
    return Step(entry.op, args, q=entry.fraction_bits, operand=entry.operand, table=table)


def _fixed(entry: Entry, args: tuple[int, ...], steps: list[Step]) -> Step:
    if entry.op == "operand":
        return Step("operand", q=entry.fraction_bits, operand=entry.operand)
    fit = _fit(entry.magnitude)
    if entry.op in ("constant", "row"):
        return Step(entry.op, q=fit, table=tuple(round(v * 2.0**fit) for v in entry.table))
    given = [steps[a].q for a in args]
    if entry.op == "neg":
        return Step("neg", args, q=given[0])
    if entry.op == "mul":
        shift = max(0, sum(given) - fit)
        return Step("mul", args, q=sum(given) - shift, shifts=(shift,))
    q = min(*given, fit)
    return Step(entry.op, args, q=q, shifts=tuple(min(g - q, _MOST_SHIFT) for g in given))


def _fit(magnitude: float) -> int:
    """Bits after the binary point with which a magnitude fills at most :data:`VALUE_BITS`."""
    if magnitude < 2.0**-_MOST_FRACTION_BITS:
        return _MOST_FRACTION_BITS
    return min(_MOST_FRACTION_BITS, VALUE_BITS - ceil(log2(magnitude * (1.0 + 1e-9))))
