"""Which heat over time would explain what is left: a course that nothing in the file or the runs' columns holds.

Heat at one node, or all heat of the motor in the proportions of its file, is a random walk over blocks of five minutes.
It is fitted together with all that the file leaves open, by Gauss and Newton's steps from what was found; how fast it
may walk, and where it is, is what makes the readings most likely (Kitagawa and Gersch, Smoothness priors analysis of
time series, Springer 1996, ch. 3). Readings count by the sensors' noise here, and not by what is left: that is what is
asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from gen.identification.network.fitting.bins import FloatArray, IntArray
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.simulation import steps_of
from gen.identification.network.fitting.weights import independent
from gen.refinement.network.anchored import Anchored
from gen.refinement.network.data import Data
from gen.refinement.network.effects.base import WHOLE
from gen.refinement.network.fit import Bench, Fitted

BLOCK_S, MOST_BLOCKS = 300.0, 400
"""Length of a block, and how many all runs together may have: then blocks are longer."""
WALKS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)
"""How far heat may walk within `WALKED_S`, as shares of the motor's whole heat at full speed: standard deviations."""
WALKED_S = 600.0
ROUNDS, SAME, LIKELIEST = 8, 1.0, 3
"""Linearisations, the gain of evidence below which there is no further one, and how many places are worth more than
one: what was found was fitted without the heat, and is bent by it."""
FARTHEST = 0.7
"""By which no capacity, conductance or heat changes in one of them, as a logarithm."""
_TINY = 1e-9
"""On the diagonal of the normal equations, as a share of it."""


@dataclass(frozen=True, eq=False)
class RunHeat:
    """One run's course, block by block, shape (k,) each.

    Attributes
    ----------
    run
        Which of the later runs.
    time_s
        The middles of the blocks, from the run's first row.
    heat_W, deviation_W
        What is missing, and its standard deviation.
    turning
        The share of the block in which the motor turns.
    speed
        Mean |PWM| over full scale while it does.
    """

    run: int
    time_s: FloatArray
    heat_W: FloatArray
    deviation_W: FloatArray
    turning: FloatArray
    speed: FloatArray


@dataclass(frozen=True, eq=False)
class HeatCourse:
    """Heat at one place, over all runs.

    Attributes
    ----------
    component
        A node, or the whole motor.
    likelihood
        Logarithm of the readings' likelihood with it, but for a constant that all courses of the same runs share.
    evidence
        By how much that is more than without any heat.
    left
        Weighed squares that are left with it, over those without.
    runs
        The later runs.
    """

    component: str
    likelihood: float
    evidence: float
    left: float
    runs: tuple[RunHeat, ...]


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Blocks of one run: its bins, the block of each, and where the first block stands among all."""

    rows: IntArray
    block: IntArray
    first: int
    count: int

    def mean(self, values: FloatArray, weight: FloatArray) -> FloatArray:
        """Average over each block, values and weights by bin; 0 where all weights are."""
        total = np.bincount(self.block, weight, self.count)
        return np.asarray(np.bincount(self.block, values * weight, self.count) / np.maximum(total, 1e-9))


def heat_courses(bench: Bench, fitted: Fitted, shape: Anchored) -> list[HeatCourse]:
    """Give the course at each place, the likeliest first; those behind the first few are of one linear step.

    Parameters
    ----------
    bench
        The runs.
    fitted
        What was found.
    shape
        The same, or what is left of it without effects that are no property of the motor.
    """
    problem, vector = bench.begin(shape, fitted)
    problem = problem.weighed(_weights(bench.data))
    unknown = _Unknown(problem, vector, _blocks(problem, bench.data.later))
    heat = np.maximum(unknown.heat, 0.0)
    patterns = {}
    for node in range(shape.base_nodes):
        patterns[shape.names[node]] = np.zeros_like(heat)
        patterns[shape.names[node]][:, node] = 1.0
    patterns[WHOLE] = heat / np.maximum(heat.sum(axis=1, keepdims=True), _TINY)
    typical = shape.motor().typical_W
    first = [(unknown.course(name, pattern, typical, unknown.cost), pattern) for name, pattern in patterns.items()]
    first.sort(key=lambda one: -one[0][0].evidence)
    made = [_converged(unknown, *begun, pattern, typical) for begun, pattern in first[:LIKELIEST]]
    # One linear step promises too much: the others stand behind those that were fitted to the end.
    return [*sorted(made, key=lambda one: -one.evidence), *(course for (course, _), _ in first[LIKELIEST:])]


def _converged(
    unknown: _Unknown, course: HeatCourse, vector: FloatArray, pattern: FloatArray, typical: float
) -> HeatCourse:
    """Fit the heat of one place from where the fit before it ended, until the readings get no likelier."""
    none = unknown.cost
    for _ in range(ROUNDS - 1):
        unknown, last = unknown.at(vector), course
        course, vector = unknown.course(course.component, pattern, typical, none)
        if abs(course.evidence - last.evidence) < SAME:
            break
    return course


def _weights(data: Data) -> FloatArray:
    """What each reading counts by the noise of its sensor alone, shape (N, S); what the file stands for, as ever."""
    inputs = data.inputs
    noise = np.array([independent(run) for run in inputs.runs])[inputs.run]
    density = np.where(data.is_later[:, None], noise, data.declared)
    return np.where(inputs.covered > 0.0, inputs.covered / np.where(density > 0.0, density, np.inf), 0.0)


def _blocks(problem: Problem[Anchored], later: int) -> list[_Blocks]:
    inputs = problem.inputs
    length = max(BLOCK_S, sum(run.duration for run in inputs.runs[:later]) / MOST_BLOCKS)
    made: list[_Blocks] = []
    first = 0
    for rows in inputs.rows[:later]:
        middle = inputs.begins[rows] + 0.5 * inputs.width[rows]
        distinct, block = np.unique((middle // length).astype(np.int64), return_inverse=True)
        made.append(_Blocks(rows, np.ravel(block), first, distinct.size))
        first += distinct.size
    return made


class _Unknown:
    """The normal equations of all numbers at once, to which the heat of one place is added.

    Parameters
    ----------
    problem, vector
        What was found, and its numbers.
    blocks
        Of the later runs.
    """

    def __init__(self, problem: Problem[Anchored], vector: FloatArray, blocks: Sequence[_Blocks]) -> None:
        self._problem, self._vector, self._blocks = problem, vector, blocks
        found = problem.structure.physical(problem.inputs.levels, vector)
        #: Of each node at each distinct input, W, shape (L, n).
        self.heat = found.heat
        self._steps = steps_of(problem.structure, problem.inputs.levels, found)
        evaluated, slopes = problem.slopes(vector)
        self._residual, self._slopes = evaluated.residual, slopes
        matrix, right = problem.assembled(problem.linearised(vector)[1], vector)
        self._numbers = cho_factor(matrix + _TINY * np.diag(np.diag(matrix)), check_finite=False)
        self._alone = cho_solve(self._numbers, right, check_finite=False)
        #: Weighed squares at the minimum without any heat.
        self.cost = evaluated.cost + problem.penalty(vector) - float(right @ self._alone)

    def at(self, vector: FloatArray) -> _Unknown:
        """The same, linearised elsewhere."""
        return _Unknown(self._problem, vector, self._blocks)

    def course(self, name: str, pattern: FloatArray, typical: float, none: float) -> tuple[HeatCourse, FloatArray]:
        """Fit the heat of one place.

        Parameters
        ----------
        name
            What to call it.
        pattern
            Heat at each node for one watt of it, at each distinct input, shape (L, n).
        typical
            The motor's whole heat at full speed, W: what heat may be at the start.
        none
            Weighed squares without any heat.

        Returns
        -------
        course, vector
            And all other numbers beside it.
        """
        size = sum(one.count for one in self._blocks)
        own, beside = np.zeros((size, size)), np.zeros((size, self._problem.size))
        right = np.zeros(size)
        answers = self._answers(pattern)
        for number, blocks in enumerate(self._blocks):
            at, weight = slice(blocks.first, blocks.first + blocks.count), self._problem.inputs.weight[blocks.rows]
            lines = answers[blocks.rows, :, : blocks.count]
            weighed = (lines * weight[:, :, None]).reshape(-1, blocks.count)
            slopes = self._slopes[blocks.rows].astype(np.float64)
            own[at, at] = weighed.T @ lines.reshape(-1, blocks.count)
            beside[at, self._problem.columns(number)] = weighed.T @ slopes.reshape(-1, slopes.shape[-1])
            right[at] = weighed.T @ self._residual[blocks.rows].ravel()
        # All other numbers at what is best for each course.
        by_heat = cho_solve(self._numbers, beside.T, check_finite=False)
        own -= beside @ by_heat
        right -= beside @ self._alone
        walked = [self._walked(own, right, share * typical, typical) for share in WALKS]
        likely, heat, variance, relief = max(walked, key=lambda one: one[0])
        deviation = np.sqrt(np.maximum(variance, 0.0))
        runs = tuple(self._of_run(number, blocks, heat, deviation) for number, blocks in enumerate(self._blocks))
        left = self.cost - relief
        likelihood = likely - 0.5 * self.cost
        course = HeatCourse(name, likelihood, likelihood + 0.5 * none, max(left, 0.0) / max(none, _TINY), runs)
        step = self._alone - by_heat @ heat
        most = float(np.abs(step[: self._problem.structure.offsets[0]]).max())
        return course, self._vector + step * min(1.0, FARTHEST / max(most, _TINY))

    def _answers(self, pattern: FloatArray) -> FloatArray:
        """What sensors show of one watt in each block of the bin's run, shape (N, S, k), K."""
        problem, steps = self._problem, self._steps
        structure, inputs = problem.structure, problem.inputs
        most = max(one.count for one in self._blocks)
        lagging = list(structure.lagging)
        made = np.zeros((inputs.level.size, structure.sensors, most))
        changes = np.zeros((inputs.level.size, len(lagging), most))
        for blocks in self._blocks:
            before = np.zeros((structure.nodes, most))
            for row, block in zip(blocks.rows, blocks.block, strict=True):
                level = inputs.level[row]
                after = steps.matrix[level] @ before
                after[:, block] += steps.gain[level] @ pattern[level]
                change = (after - before)[: structure.sensors]
                made[row] = before[: structure.sensors] + inputs.share[row][:, None] * change
                changes[row] = change[lagging] / inputs.width[row]
                before = after
        structure.through_sensors(inputs, self._vector, made, changes)
        return made

    def _walked(
        self, own: FloatArray, right: FloatArray, walks: float, typical: float
    ) -> tuple[float, FloatArray, FloatArray, float]:
        """Fit with one speed of the walk: evidence, heat (W), its variance (W^2), and decrease of the cost."""
        prior = np.zeros_like(own)
        logarithm = 0.0  # of the prior's determinant: that of a walk is the product over its steps
        inputs = self._problem.inputs
        for blocks in self._blocks:
            middle = blocks.mean(inputs.begins[blocks.rows], np.ones(blocks.rows.size))
            precision = WALKED_S / (walks**2 * np.maximum(np.diff(middle), 1.0))
            steps = np.diff(np.eye(blocks.count), axis=0)
            at = slice(blocks.first, blocks.first + blocks.count)
            prior[at, at] = steps.T @ (precision[:, None] * steps)
            prior[blocks.first, blocks.first] += typical**-2
            logarithm += float(np.log(precision).sum()) - 2.0 * np.log(typical)
        lower = np.linalg.cholesky(own + prior)
        half = solve_triangular(lower, right, lower=True, check_finite=False)
        relief = float(half @ half)
        evidence = 0.5 * (relief + logarithm) - float(np.log(np.diag(lower)).sum())
        heat = solve_triangular(lower.T, half, lower=False, check_finite=False)
        inverse = solve_triangular(lower, np.eye(right.size), lower=True, check_finite=False)
        return evidence, heat, np.sum(inverse**2, axis=0), relief

    def _of_run(self, number: int, blocks: _Blocks, heat: FloatArray, deviation: FloatArray) -> RunHeat:
        inputs, at = self._problem.inputs, slice(blocks.first, blocks.first + blocks.count)
        width, turns = inputs.width[blocks.rows], 1.0 - inputs.rest[blocks.rows]
        return RunHeat(
            number,
            blocks.mean(inputs.begins[blocks.rows] + 0.5 * width, width),
            heat[at],
            deviation[at],
            blocks.mean(turns, width),
            blocks.mean(inputs.speed[blocks.rows], turns * width),
        )
