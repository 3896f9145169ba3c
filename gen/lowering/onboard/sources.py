"""Schedules of the coefficient file as graphs, with a constant factor folded into their constants."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext

import numpy as np

from gen.lowering.onboard.graph import MIDDLE, Graph
from gen.model import ExponentialSum, Polynomial, Schedule, Table
from gen.model.schedules import EXACT


def schedule_node(
    graph: Graph, schedule: Schedule, x: int, factor: Decimal, path: str, text: str, *, refined: bool = False
) -> int:
    """The node of ``factor * schedule(x)``; schedules that differ in sign give the same node but for a ``neg``.

    Parameters
    ----------
    graph
        Where to build it.
    schedule
        The schedule.
    x
        The node of the whole number that it depends on.
    factor
        A constant.
    path, text
        Its JSON path, and what it is.
    refined
        Whether sums of exponentials spend another table on digits that would cancel.
    """
    values = schedule(graph.values[x]) * float(factor)
    if values[np.argmax(np.abs(values))] < 0.0:
        return graph.neg(_build(graph, schedule, x, -factor, path, f"-({text})", refined=refined))
    return _build(graph, schedule, x, factor, path, text, refined=refined)


def _build(graph: Graph, schedule: Schedule, x: int, factor: Decimal, path: str, text: str, *, refined: bool) -> int:
    if isinstance(schedule, Polynomial):
        node = _horner(graph, [Decimal(c) * factor for c in schedule.coefficients], x, f"{path}.poly", text)
    elif isinstance(schedule, ExponentialSum):
        key = f"exp{len(schedule.terms)}"
        parts = []
        if refined:
            # The terms cancel in part: the sum at the middle of every sixteen, and what each term is above it.
            with localcontext(EXACT):
                middles = tuple(
                    sum(
                        (Decimal(a) * factor * (Decimal(b) * (16 * i + MIDDLE)).exp() for a, b in schedule.terms),
                        Decimal(0),
                    )
                    for i in range(16)
                )
            upper = graph.label(graph.upper(x), "which sixteen |PWM| is in")
            middle = graph.row(upper, middles)
            parts.append(graph.label(middle, f"{text}: in the middle of sixteen", "", f"{path}.{key}"))
        for k, (a, b) in enumerate(schedule.terms):
            part = graph.exponential(x, Decimal(a) * factor, Decimal(b), centred=refined)
            parts.append(
                graph.label(
                    part,
                    f"{text}: term {k + 1}" + (", above that" if refined else ""),
                    "per sample, as the whole",
                    f"{path}.{key}[{2 * k}..{2 * k + 1}]",
                )
            )
        node = graph.total(parts, 0.0)
    elif isinstance(schedule, Table):
        segment, local = graph.place(x, schedule.pwm)
        graph.label(segment, "interval of the table", "", f"{path}.table.pwm")
        graph.label(local, "counts above its start", "", f"{path}.table.pwm")
        segments = schedule.segments()
        columns = []
        for k in range(len(segments[0].coefficients)):
            row = graph.row(segment, tuple(Decimal(s.coefficients[k]) * factor for s in segments))
            power = len(segments[0].coefficients) - 1 - k
            columns.append(graph.label(row, f"{text}: coefficient of power {power}", "", f"{path}.table.value"))
        node = _nested(graph, columns, local)
    else:
        raise TypeError(f"no lowering for a schedule of type {type(schedule).__name__}")
    return graph.label(node, text, "times the sample's power", path)


def _horner(graph: Graph, coefficients: Sequence[Decimal], x: int, path: str, text: str) -> int:
    nodes = []
    for k, value in enumerate(coefficients):
        node = graph.constant(value)
        if value:
            graph.label(node, f"{text}: coefficient {k}", "", f"{path}[{k}]")
        nodes.append(node)
    return _nested(graph, nodes, x)


def _nested(graph: Graph, coefficients: Sequence[int], x: int) -> int:
    node = coefficients[0]
    for following in coefficients[1:]:
        node = graph.add(graph.times(node, x), following)
    return node
