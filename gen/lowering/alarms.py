"""Alarm rules as the board evaluates them: whole counts, samples and thousandths of a kelvin.

Every rule has segments, ranges of |PWM| with a threshold each; where no segment holds the rule is not evaluated.
Usually there is one.  A threshold that is counted from the declared error band has as many as the band has steps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, groupby, islice, repeat

import numpy as np
from scipy.linalg import expm

from gen.arrays import FloatArray, IntArray
from gen.coefficients import Coefficients
from gen.coefficients.alarms import (
    MOST_SAMPLES,
    AlarmRule,
    Cusum,
    MissingHeat,
    ModelRule,
    OverTemperature,
    window_counts,
)
from gen.coefficients.checks.alarm_checks import healthy_end_K, quantity
from gen.coefficients.document import Document
from gen.lowering.heat import LoweredHeat, lower_heat
from gen.lowering.samples import samples
from gen.model import Component, ThermalModel

#: A start from measured temperatures alone knows no slopes: rules wait until what that can do has fallen below this.
START_MARGIN_K = 0.5
#: A part that is within so much of ambient at the start is cold, in thousandths of a kelvin.
COLD_mK = 2000
#: A limit that looks ahead adds so many times what the part rose by over two readings: what it does in the next four.
AHEAD_TIMES = 2
#: With each of these over its limit a sample of it counts for one more of its persistence, in thousandths of a kelvin.
HASTE_mK = 1000
_START_STEP_S = 30.0
_START_LEVELS = 9
_START_TIMES = 12
_START_BLOCK = 32
_MOST_HULL, _FEW_CASES = 4, 1000
#: Largest sum that a CUSUM may need, in thousandths of a kelvin times samples: far from the 32 bits' end.
MOST_SUM = 2**30


@dataclass(frozen=True)
class Segment:
    """A range of |PWM| in which a rule has one threshold.

    Attributes
    ----------
    low, high
        |PWM| in counts, both included.
    trip_mK, clear_mK
        The condition begins above trip and ends at or below clear, in thousandths of a kelvin (of a degree
        Celsius for an over-temperature). For a CUSUM both are the slack.
    """

    low: int
    high: int
    trip_mK: int
    clear_mK: int


@dataclass(frozen=True)
class LoweredRule:
    """One rule.

    Attributes
    ----------
    name, description
        From the coefficient file.
    quantity
        What is compared: "above" (measured minus model), "below" (model minus measured), "measured", or "heat" (a sum
        of what the model lacks).
    component
        Index of the component.
    relative_to
        Index of the component whose deviation from the model is subtracted from this one's, or None.
    segments
        Not overlapping, in the order of |PWM|.
    settle, start_wait, persistence
        In samples: since PWM entered the segments, within the segments since a start whose slopes are unknown, and
        before the alarm.
    requires, unless
        Index of the rule whose alarm must be raised, and of the one whose alarm must not be, or None.
    sum_limit
        A CUSUM's threshold in thousandths of a kelvin times samples, or None for other rules.
    heat
        Of a rule on missing heat, else None.
    looks_ahead
        A limit that counts what rises as what it will soon be, and waits the less the farther it is passed.
    """

    name: str
    description: str
    quantity: str
    component: int
    relative_to: int | None
    segments: tuple[Segment, ...]
    settle: int
    start_wait: int
    persistence: int
    requires: int | None
    unless: int | None
    sum_limit: int | None
    heat: LoweredHeat | None = None
    looks_ahead: bool = False

    @property
    def needs_model(self) -> bool:
        """Whether the model's temperature takes part."""
        return self.quantity != "measured"


def lower_alarms(coefficients: Coefficients) -> tuple[LoweredRule, ...]:
    """Lower every rule of a coefficient file, in its order.

    Parameters
    ----------
    coefficients
        A checked coefficient file.
    """
    document, model = coefficients.document, coefficients.model
    names = [rule.name for rule in document.alarms]
    rules = []
    for rule in document.alarms:
        counts = window_counts(rule, document.input.full_scale)
        wait, other = 0, None
        if isinstance(rule, ModelRule):
            wait, other = start_wait(model, rule.component, counts), rule.relative_to
            if other is not None:
                wait = max(wait, start_wait(model, other, counts))
        sum_limit = None
        if isinstance(rule, Cusum):
            sum_limit = max(1, min(MOST_SUM, round(rule.threshold_K_s * 1000.0 / model.sample_time)))
        rules.append(
            LoweredRule(
                name=rule.name,
                description=rule.description,
                quantity=quantity(rule),
                component=model.component_names.index(rule.component),
                relative_to=None if other is None else model.component_names.index(other),
                segments=_segments(document, rule),
                settle=samples(rule.settle_s, model.sample_time),
                start_wait=wait,
                persistence=samples(rule.persistence_s, model.sample_time),
                requires=None if rule.requires is None else names.index(rule.requires),
                unless=None if rule.unless is None else names.index(rule.unless),
                sum_limit=sum_limit,
                heat=lower_heat(document, model, rule) if isinstance(rule, MissingHeat) else None,
                looks_ahead=isinstance(rule, OverTemperature) and rule.look_ahead,
            )
        )
    return tuple(rules)


def asks_heat(rules: Sequence[LoweredRule]) -> bool:
    """Whether any rule waits for one on missing heat to stay silent."""
    return any(rule.unless is not None and rules[rule.unless].heat is not None for rule in rules)


def start_wait(model: ThermalModel, name: str, counts: range) -> int:
    """Samples at some |PWM| after which what is unknown at a start no longer matters.

    A motor on its way from rest to a steady state, or back, has slopes (in a network: hidden nodes) that a start from
    its measured temperatures does not know. The error that this causes then develops at any one level for any time, and
    decays at the given levels; the wait is the time after which it stays below :data:`START_MARGIN_K` in every case
    tried.

    Parameters
    ----------
    model, name
        The component in question; where nothing is unknown there is nothing to wait for.
    counts
        The levels at which time is counted.
    """
    low, high = model.domain_pwm
    levels = np.unique(np.linspace(low, high, _START_LEVELS).round().astype(np.int64))
    inner = np.array([counts[0], counts[len(counts) // 2], counts[-1]])
    if model.network is not None:
        if not model.network.hidden:
            return 0
        read = model.network.index(name)
        sensor = model.network.nodes[read].sensor
        times = 1.0 if sensor is None else 1.0 + sensor.gain_error
        matrices, inside, errors = *(model.network.matrices(at)[0] for at in (levels, inner)), _hidden(model, levels)
    else:
        component, read, times = model.component(name), 0, 1.0
        if component.order == 1:
            return 0
        (matrices, _), (inside, _) = component.state_matrices(levels), component.state_matrices(inner)
        errors = _slopes(component, levels, matrices)
    later = np.concatenate([np.hstack(list(_responses(matrix) @ errors)) for matrix in matrices], axis=1)
    outermost = _outermost(times * later)
    return max(_fading_time(matrix, outermost, model, read) for matrix in inside)


def _outermost(errors: FloatArray) -> FloatArray:
    """Those of errors, shape (n, cases), that decide any linear bound: corners of the hull of all of them.

    What is read after any time is linear in the error, so that the largest of all cases is that of a corner. In many
    dimensions a hull costs more than it saves.
    """
    if not 1 < errors.shape[0] <= _MOST_HULL or errors.shape[1] <= _FEW_CASES:
        return errors
    from scipy.spatial import ConvexHull, QhullError  # not worth loading for what no rule asks

    try:
        return np.asarray(errors[:, ConvexHull(errors.T).vertices])
    except QhullError:  # all in one plane
        return errors


def _slopes(component: Component, levels: IntArray, matrices: FloatArray) -> FloatArray:
    """What a start takes as zero, shape (n, cases): slopes on the way down from each steady state; up is its mirror."""
    cases = []
    for matrix, steady in zip(matrices, component.steady_rise(levels), strict=True):
        rest = np.zeros(component.order)
        rest[0] = steady
        unknown = _responses(matrix) @ rest
        unknown[:, 0] = 0.0
        cases.append(unknown)
    return np.concatenate(cases).T


def _hidden(model: ThermalModel, levels: IntArray) -> FloatArray:
    """Hidden nodes less where a start puts them, shape (nodes, cases): on the way up to each steady state, and down."""
    network = model.network
    assert network is not None
    room = model.ambient_fixed if model.ambient_fixed is not None else 25.0
    matrices, ambient, heat = network.matrices(levels)
    at_rest = network.matrices(np.zeros(1, dtype=np.int64))[0][0]
    driving = (matrices.sum(axis=2) + ambient) * room + heat
    sensed = [network.index(node.name) for node in network.sensed]
    hidden = [network.index(node.name) for node in network.hidden]
    cases = []
    for matrix, drive in zip(matrices, driving, strict=True):
        steady = np.linalg.solve(-matrix, drive)
        for rises in (steady - _responses(matrix) @ steady, _responses(at_rest) @ steady):
            unknown = np.zeros_like(rises)
            unknown[:, hidden] = rises[:, hidden] - rises[:, sensed] @ network.hidden_at_start[:, :-1].T
            cases.append(unknown)
    return np.concatenate(cases).T


def _responses(matrix: FloatArray) -> FloatArray:
    """Transition matrices over times that span the way to rest, shape (times, n, n)."""
    slowest = 1.0 / np.abs(np.linalg.eigvals(matrix).real).min()
    times = np.concatenate([[0.0], np.geomspace(slowest / 100.0, slowest * 3.0, _START_TIMES)])
    return np.asarray(expm(matrix * times[:, None, None]))


def _fading_time(matrix: FloatArray, errors: FloatArray, model: ThermalModel, read: int) -> int:
    """Samples after which every error, shape (n, cases), stays below the margin."""
    most = int(MOST_SAMPLES * model.sample_time / _START_STEP_S)
    last, below = 0, 0
    for number, largest in enumerate(islice(_largest(expm(matrix * _START_STEP_S), errors, read), most - 1), 1):
        if largest > START_MARGIN_K:
            last, below = number, 0
        else:
            below += 1
        if below > max(20, last):
            break
    return min(MOST_SAMPLES, int(np.ceil((last + 1) * _START_STEP_S / model.sample_time)))


def _largest(step: FloatArray, errors: FloatArray, read: int) -> Iterator[float]:
    """The largest of the errors read, by step; a block of the matrix's powers is one product."""
    rows = list(accumulate(repeat(step, _START_BLOCK - 1), np.matmul, initial=step[read]))
    onward = np.linalg.matrix_power(step, _START_BLOCK)
    while True:
        yield from np.abs(np.array(rows) @ errors).max(axis=1)
        errors = onward @ errors


def _segments(document: Document, rule: AlarmRule) -> tuple[Segment, ...]:
    counts = window_counts(rule, document.input.full_scale)
    if isinstance(rule, OverTemperature):
        base, clear = rule.limit_degC, rule.hysteresis_K
    elif isinstance(rule, Cusum):
        base, clear = rule.slack_K, 0.0
    elif isinstance(rule, MissingHeat):
        base, clear = rule.threshold_K, 0.0
    else:
        base, clear = rule.threshold_K, rule.hysteresis_K
    extra = dict.fromkeys(counts, 0.0)
    if isinstance(rule, ModelRule) and rule.beyond == "error_band":
        extra = healthy_end_K(document, rule, counts)
    segments = []
    for value, group in groupby(counts, key=lambda pwm: extra[pwm]):
        members = list(group)
        trip = round((base + value) * 1000.0)
        segments.append(Segment(members[0], members[-1], trip, trip - round(clear * 1000.0)))
    return tuple(segments)
