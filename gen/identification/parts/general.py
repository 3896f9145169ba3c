"""The general model of one component: forms chosen by leave-one-speed-out error in kelvin of predicted temperature."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.parts.curves import Shape
from gen.identification.parts.forms import GAIN_FORMS, TIME_FORMS, Form
from gen.identification.parts.output_error import OutputErrorFit, OutputErrorProblem
from gen.identification.parts.uncertainty import Uncertainty
from gen.model.dynamics import PWM_LEVELS

NEAR_K = 0.3
"""A form may miss the identified speeds themselves by this, or by three standard deviations, to be considered."""
MARGIN = 1.05
"""Among forms whose leave-one-out errors differ by less than this, the one with the fewest parameters is taken."""
WIGGLE = 0.1
"""How far the rise may go beyond both neighbours, as a share of the largest, before it counts as a wiggle."""


@dataclass(frozen=True, eq=False)
class Error:
    """Error of a model at the identified speeds, model minus measured.

    Attributes
    ----------
    rms_K, largest_K, steady_K
        By node above 0: root mean square over time, largest magnitude, and error of the steady rise, K.
    """

    rms_K: FloatArray
    largest_K: FloatArray
    steady_K: FloatArray

    @property
    def total(self) -> float:
        """Root mean square over the speeds, K."""
        return float(np.sqrt(np.mean(self.rms_K**2)))


@dataclass(frozen=True, eq=False)
class Option:
    """One pair of forms.

    Attributes
    ----------
    shape, vector
        The forms and their parameters, from the values at the identified speeds.
    own
        Error at the identified speeds.
    left_out
        Error at each speed of the forms that were fitted without it; None with fewer than three speeds.
    rejected
        Why it is not considered; empty when it is.
    """

    shape: Shape
    vector: FloatArray
    own: Error
    left_out: Error | None
    rejected: str = ""

    @property
    def name(self) -> str:
        """For people."""
        return f"time constants {self.shape.time.name}, gain {self.shape.gain.name}"

    @property
    def score(self) -> float:
        """What is compared, K."""
        return self.left_out.total if self.left_out is not None else self.own.total


@dataclass(frozen=True, eq=False)
class General:
    """All options of a component, the best first, rejected ones last."""

    options: tuple[Option, ...]

    @property
    def chosen(self) -> Option:
        """The chosen one."""
        return self.options[0]


class Judge:
    """Computes errors in kelvin of models given by structure parameters and rise at the nodes."""

    def __init__(self, problem: OutputErrorProblem, fit: OutputErrorFit) -> None:
        self.problem, self.fit = problem, fit
        self.layout = fit.layout
        self.nodes = fit.layout.positive
        self._at = [[_rows_at(problem, r, int(node)) for r in range(len(problem.records))] for node in self.nodes]

    def error_at(self, i: int, theta: FloatArray, steady: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Error at node i of B sets of values for that node, shapes (B, order) and (B,): rms, largest, steady."""
        vectors = np.repeat(self.fit.vector[None, :], len(theta), axis=0)
        first = (len(self.layout.nodes) - len(self.nodes) + i) * self.layout.order
        vectors[:, first : first + self.layout.order] = theta
        vectors[:, self.layout.thetas + i] = steady
        return self.error_of(i, vectors)

    def errors(self, theta: FloatArray, steady: FloatArray) -> list[Error]:
        """Judge values at the nodes, shapes (options, nodes, order) and (options, nodes)."""
        columns = [
            self.error_at(i, np.clip(theta[:, i], -15.0, 25.0), np.clip(steady[:, i], -1e4, 1e4))
            for i in range(theta.shape[1])
        ]
        rms, largest, final = (np.stack([c[k] for c in columns], axis=1) for k in range(3))
        return [Error(rms[s], largest[s], final[s]) for s in range(len(theta))]

    def base(self) -> Error:
        """Error of the transfer functions themselves, which were fitted speed by speed."""
        found = [self.error_of(i, self.fit.vector[None, :]) for i in range(len(self.nodes))]
        rms, largest, steady = (np.array([f[k][0] for f in found]) for k in range(3))
        return Error(rms, largest, steady)

    def error_of(self, i: int, vectors: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the same for whole vectors, shape (B, P)."""
        square = np.zeros(len(vectors))
        largest = np.zeros(len(vectors))
        count = 0.0
        for r, record in enumerate(self.problem.records):
            rows = self._at[i][r]
            if rows.size:
                error = self.problem.model(self.layout, vectors, r)[:, rows] - record.rise[rows]
                square += (error**2) @ record.count[rows]
                largest = np.maximum(largest, np.abs(error).max(axis=1))
                count += float(record.count[rows].sum())
        steady = vectors[:, self.layout.thetas + i] - self.fit.steady[i]
        return np.sqrt(square / max(count, 1.0)), largest, steady


def _rows_at(problem: OutputErrorProblem, r: int, node: int) -> IntArray:
    """Blocks at a node; where it was never held, those whose PWM is nearest to it."""
    level = problem.records[r].segments.pwm[problem.records[r].segment]
    if node in problem.levels and any(node in record.segments.pwm for record in problem.records):
        return np.flatnonzero(level == node)
    return np.flatnonzero(problem.nodes[np.argmin(np.abs(level[:, None] - problem.nodes[None, :]), axis=1)] == node)


def choose_forms(problem: OutputErrorProblem, fit: OutputErrorFit, spread: Uncertainty) -> General:
    """Try all pairs of forms.

    Parameters
    ----------
    problem, fit, spread
        The component's records, transfer functions at the identified speeds, and their uncertainty.
    """
    judge = Judge(problem, fit)
    layout = fit.layout
    standstill = bool(layout.nodes[0] == 0)
    nodes = layout.positive
    theta_sd = spread.deviation[: layout.thetas].reshape(-1, layout.order)
    steady_sd = spread.deviation[layout.thetas : layout.thetas + len(nodes)]
    shapes = [
        Shape(layout.structure, time, gain, nodes, standstill)
        for time in TIME_FORMS
        for gain in GAIN_FORMS
        if _fits(time, gain, len(nodes))
    ]
    data = (fit.theta, fit.steady, theta_sd, steady_sd)
    with np.errstate(over="ignore", invalid="ignore"):
        own = _own(judge, shapes, data)
        left: Sequence[Error | None] = _left_out(judge, shapes, data) if len(nodes) >= 3 else [None] * len(shapes)
    base = judge.base()
    options = []
    for shape, (vector, error), out in zip(shapes, own, left, strict=True):
        reason = guard(shape, vector, fit) or misses(error, base, steady_sd)
        options.append(Option(shape, vector, error, out, reason))
    return General(tuple(_ranked(options)))


def _fits(time: Form, gain: Form, points: int) -> bool:
    """Whether the points, less one to leave out, determine the forms."""
    if points == 1:
        return bool(time.name == "log poly0" and gain.name == "log poly0")
    left = points - 1 if points >= 3 else points
    return bool(time.least_points() <= left and gain.least_points() <= left)


_Data = tuple[FloatArray, FloatArray, FloatArray, FloatArray]


def _own(judge: Judge, shapes: list[Shape], data: _Data) -> list[tuple[FloatArray, Error]]:
    x = judge.nodes.astype(np.float64)
    drawn = _drawn(shapes, data, x)
    theta, steady = np.stack([d[1] for d in drawn]), np.stack([d[2] for d in drawn])
    return [(d[0], error) for d, error in zip(drawn, judge.errors(theta, steady), strict=True)]


def _left_out(judge: Judge, shapes: list[Shape], data: _Data) -> list[Error]:
    x = judge.nodes.astype(np.float64)
    theta = np.empty((len(shapes), len(x), judge.layout.order))
    steady = np.empty((len(shapes), len(x)))
    first = len(judge.layout.nodes) - len(x)
    for i in range(len(x)):
        kept = np.delete(np.arange(len(x)), i)
        rows = np.concatenate([np.arange(first), kept + first])
        part: _Data = (data[0][rows], data[1][kept], data[2][rows], data[3][kept])
        reduced = [replace(shape, nodes=judge.nodes[kept]) for shape in shapes]
        for s, (_, t, h) in enumerate(_drawn(reduced, part, x[i : i + 1])):
            theta[s, i], steady[s, i] = t[0], h[0]
    return judge.errors(theta, steady)


def _drawn(shapes: list[Shape], data: _Data, x: FloatArray) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Fit every shape and evaluate it at x: vector, structure parameters, rise. What shapes share is done once."""
    times: dict[str, tuple[FloatArray, FloatArray]] = {}
    gains: dict[str, FloatArray] = {}
    result = []
    for shape in shapes:
        if shape.time.name not in times:
            part = shape.start_time(data[0], data[2])
            times[shape.time.name] = (part, shape.time_at(part, x))
        if shape.gain.name not in gains:
            gains[shape.gain.name] = shape.start_gain(data[0], data[1], data[3])
        part, theta = times[shape.time.name]
        gain = gains[shape.gain.name]
        result.append((np.concatenate([part, gain]), theta, shape.rise_at(gain, theta, x)))
    return result


def misses(own: Error, base: Error, steady_sd: FloatArray) -> str:
    """Say by how much a model misses the identified speeds, if by more than `NEAR_K` beyond the fits there."""
    steady = np.abs(own.steady_K) > np.maximum(NEAR_K, 3.0 * steady_sd)
    course = own.rms_K > np.hypot(base.rms_K, NEAR_K)
    if steady.any() or course.any():
        worst = float(max(np.max(np.abs(own.steady_K)), np.max(own.rms_K)))
        return f"misses the identified speeds themselves by up to {worst:.1f} K"
    return ""


def guard(shape: Shape, vector: FloatArray, fit: OutputErrorFit) -> str:
    """Look for what no motor does between (and beyond) the identified speeds.

    Returns
    -------
    str
        What is wrong, or nothing.
    """
    pwm = np.append(1e-3, np.arange(1.0, float(PWM_LEVELS)))
    theta, steady = shape.evaluate(vector, pwm)
    if not (np.isfinite(theta).all() and np.isfinite(steady).all()):
        return "is not finite"
    low, high = int(shape.x[0]), int(shape.x[-1])
    inside = (pwm >= low) & (pwm <= high)
    drawn = np.abs(shape.structure.poles(theta))
    known = np.abs(shape.structure.poles(fit.theta))
    if drawn.min() < known.min() / 3.0 or drawn.max() > known.max() * 3.0:
        return "time constants leave the identified ones by more than a factor of 3"
    if steady[inside].min() < 0.0 <= fit.steady.min():
        return f"the gain changes sign at PWM {int(pwm[inside][np.argmin(steady[inside])])}"
    return _wiggle(shape, steady[inside], pwm[inside], fit.steady)


def _wiggle(shape: Shape, steady: FloatArray, pwm: FloatArray, known: FloatArray) -> str:
    allowed = WIGGLE * float(np.max(np.abs(known)))
    for a, b in zip(shape.x[:-1], shape.x[1:], strict=True):
        part = steady[(pwm >= a) & (pwm <= b)]
        top, bottom = max(part[0], part[-1]), min(part[0], part[-1])
        if part.max() > top + allowed or part.min() < bottom - allowed:
            return f"wiggles by more than {allowed:.1f} K between PWM {a:.0f} and {b:.0f}"
    return ""


def _ranked(options: list[Option]) -> list[Option]:
    good = sorted((o for o in options if not o.rejected), key=lambda o: o.score)
    bad = sorted((o for o in options if o.rejected), key=lambda o: o.score)
    if not good:  # every form is faulty: take what goes through the points
        through = [o for o in bad if o.shape.time.interpolates and o.shape.gain.interpolates]
        first = through[0] if through else bad[0]
        return [first, *(o for o in bad if o is not first)]
    near = [o for o in good if o.score <= good[0].score * MARGIN + 1e-3]
    first = min(near, key=lambda o: (o.shape.size, o.score))
    return [first, *(o for o in good if o is not first), *bad]
