"""The same graph in float32: one IEEE operation a step, constants rounded to float32."""

from __future__ import annotations

import numpy as np

from gen.lowering.onboard.discretise import Discretised
from gen.lowering.onboard.graph import INTEGERS, Label, exponential_factors
from gen.lowering.onboard.tape import Step


def float_tape(source: Discretised) -> tuple[list[Step], tuple[int, ...], int]:
    """Steps, the numbers of the rates, and that of the steady rise."""
    graph = source.graph
    placed: dict[int, int] = {}
    steps: list[Step] = []
    for number in source.needed():
        node = graph.nodes[number]
        table: tuple[int, ...] | tuple[float, ...] = ()
        if node.op in INTEGERS or node.op == "positive_outside":
            table = tuple(int(v) for v in node.data)
        elif node.op == "exponential":
            high, low = exponential_factors(*node.data)
            table = tuple(_rounded(float(v)) for v in high + low)
        elif node.op == "scale":
            table = (2.0 ** int(node.data[0]),)
        else:
            table = tuple(_rounded(float(v)) for v in node.data)
        label = graph.labels.get(number, Label("constant" if node.op == "constant" else ""))
        placed[number] = len(steps)
        steps.append(Step(node.op, tuple(placed[a] for a in node.args), table=table, label=label))
    return steps, tuple(placed[r] for r in source.rates), placed[source.steady]


def _rounded(value: float) -> float:
    return float(np.float32(value))
