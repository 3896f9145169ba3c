"""Schedules of the coefficient file as graphs, with a constant factor folded into their constants."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext

import numpy as np

from gen.arrays import FloatArray
from gen.lowering.onboard.graph import Graph
from gen.lowering.onboard.interpolate import PowerSeries, power_series
from gen.model import ExponentialSum, Polynomial, Schedule, Table
from gen.model.schedules import EXACT


def schedule_node(
    graph: Graph, schedule: Schedule, x: int, factor: Decimal, path: str, text: str, *, tolerance: float | None
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
    tolerance
        Relative error up to which a sum of exponentials becomes one power series; None keeps its terms, and those of a
        polynomial.
    """
    values = schedule(graph.values[x]) * float(factor)
    if values[np.argmax(np.abs(values))] < 0.0:
        return graph.neg(_build(graph, schedule, x, -factor, path, f"-({text})", tolerance=tolerance))
    return _build(graph, schedule, x, factor, path, text, tolerance=tolerance)


def _build(
    graph: Graph, schedule: Schedule, x: int, factor: Decimal, path: str, text: str, *, tolerance: float | None
) -> int:
    if isinstance(schedule, Polynomial):
        coefficients = [Decimal(c) * factor for c in schedule.coefficients]
        if tolerance is None or not _has_both_signs(schedule, graph.values[x]):
            # As sums of their own: the last may use a word without a sign.
            node = _horner(graph, coefficients, x, f"{path}.poly", text)
        else:
            node = graph.power_series(x, PowerSeries.of_powers(coefficients))
            graph.label(node, text, "times the sample's power", f"{path}.poly[0..{len(coefficients) - 1}]")
    elif isinstance(schedule, ExponentialSum):
        key = f"{path}.exp{len(schedule.terms)}"
        if tolerance is not None:
            with localcontext(EXACT):
                terms = [(Decimal(a) * factor, Decimal(b)) for a, b in schedule.terms]
            inputs = graph.values[x].astype(int).tolist()
            node = graph.power_series(x, power_series(lambda v: _sum(terms, v), inputs, tolerance))
            graph.label(node, f"{text}: as a polynomial", "times the sample's power", f"{key}[0..{2 * len(terms) - 1}]")
        else:
            parts = []
            for k, (a, b) in enumerate(schedule.terms):
                part = graph.exponential(x, Decimal(a) * factor, Decimal(b))
                place = f"{key}[{2 * k}..{2 * k + 1}]"
                parts.append(graph.label(part, f"{text}: term {k + 1}", "per sample, as the whole", place))
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


def _has_both_signs(schedule: Schedule, x: FloatArray) -> bool:
    values = schedule(x)
    return bool(np.any(values < 0.0) and np.any(values > 0.0))


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


def _sum(terms: Sequence[tuple[Decimal, Decimal]], x: Decimal) -> Decimal:
    return sum((a * (b * x).exp() for a, b in terms), Decimal(0))
