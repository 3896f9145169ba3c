"""A run's alarms: those that the board recorded, and those that a file's rules raise on what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.drawing.section import Bar, shown
from gen.lowering.alarms import LoweredRule
from gen.model.dynamics import MAX_PWM
from gen.reference.run_alarms import raised_s
from gen.runs import Run

COLUMN = "alarms"
"""The board's: a bit for each rule, set while its alarm is raised."""
_MOST_BITS = 16
_MOST_BARS = 500


def recorded(run: Run, events: Sequence[tuple[float, str]], rules: Sequence[str]) -> list[Bar]:
    """Give the alarms that a run file's own column shows.

    Parameters
    ----------
    run
        The run.
    events
        What the board said: it names the rules.
    rules
        Names of the rules of the board's own coefficient file, where it is known.
    """
    if COLUMN not in run.extras:
        return []
    mask = np.nan_to_num(run.extras[COLUMN]).astype(np.int64)
    found: list[tuple[int, float, float]] = []
    for bit in range(_MOST_BITS):
        found += [(bit, start, end) for start, end in spans((mask >> bit & 1).astype(np.bool_), run.time_s)]
    names = dict(enumerate(rules)) or _named(found, events, run.time_s)
    return [Bar(shown(names.get(bit, f"alarm {bit + 1}")), "recorded", start, end) for bit, start, end in found]


def _named(
    found: Sequence[tuple[int, float, float]], events: Sequence[tuple[float, str]], time_s: FloatArray
) -> dict[int, str]:
    """Names of the rules by their bits, from the events in the row's interval in which only one bit was first set."""
    said = [(at, text.removeprefix("alarm ")) for at, text in events if text.startswith("alarm ")]
    names: dict[int, str] = {}
    for bit, start, _ in found:
        row = int(np.searchsorted(time_s, start))
        since = time_s[row - 1] if row else -np.inf
        named = {name for at, name in said if since < at <= start}
        if len(named) == 1 and sum(other == start for _, other, _ in found) == 1:
            names.setdefault(bit, named.pop())
    return names


def spans(present: BoolArray, time_s: FloatArray) -> list[tuple[float, float]]:
    """First time of every stretch of True and the first after it, s; a distance too short to be seen is closed."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], present, [False])).astype(np.int8)))
    starts, ends = time_s[edges[::2]], time_s[np.minimum(edges[1::2], time_s.size - 1)]
    least = (time_s[-1] - time_s[0]) / _MOST_BARS
    apart = starts[1:] - ends[:-1] > least
    first, last = np.concatenate([[True], apart]), np.concatenate([apart, [True]])
    return list(zip(starts[first].tolist(), ends[last].tolist(), strict=True)) if starts.size else []


def derived(coefficients: Coefficients, run: Run, model_degC: Mapping[str, FloatArray]) -> list[Bar]:
    """Give the alarms that a coefficient file's rules raise on a run.

    Parameters
    ----------
    coefficients
        Model and rules.
    run
        What was measured.
    model_degC
        The model's temperatures at the run's rows by component, shape (N,) each.

    Returns
    -------
    list of Bar
        From when a rule's alarm is raised to the end, as nobody resets it; in the rules' order.
    """
    end = float(run.time_s[-1])
    return [Bar(shown(name), "derived", at, end) for name, at in raised_s(coefficients, run, model_degC).items()]


def band(rules: Sequence[LoweredRule], component: int, side: str, pwm: IntArray) -> FloatArray | None:
    """Give where the nearest rule on one side of the model begins at each row.

    Parameters
    ----------
    rules
        Of the coefficient file, lowered. Those that depend on another component or another rule, and sums, are no band.
    component
        Place of the component.
    side
        ``above`` or ``below``.
    pwm
        Of each row, shape (N,).

    Returns
    -------
    NDArray or None
        Measured minus model in K, shape (N,), NaN where no rule holds; None without any.
    """
    table = np.full(MAX_PWM + 1, np.inf)
    for rule in rules:
        alone = rule.relative_to is None and rule.requires is None and rule.sum_limit is None
        if rule.component == component and rule.quantity == side and alone:
            for segment in rule.segments:
                inside = table[segment.low : segment.high + 1]
                np.minimum(inside, segment.trip_mK / 1000.0, out=inside)
    if not np.isfinite(table).any():
        return None
    table[np.isinf(table)] = np.nan
    found = table[np.minimum(np.abs(pwm), MAX_PWM)]
    return found if side == "above" else -found
