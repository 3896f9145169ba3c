"""Which course over time would explain what is left: one that nothing in the file or the runs' columns holds.

Heat at one node, or all heat of the motor in the proportions of its file; or conductance to the ambient at one node, or
at all, in the proportions of the file's. It is a random walk over blocks of five minutes, fitted together with all that
the file leaves open, by Gauss and Newton's steps from what was found; how fast it may walk, what it is, and where, is
what makes the readings most likely. Readings count by the sensors' noise here, and not by what is left: that is what
is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from gen.arrays import FloatArray
from gen.identification.network.fitting.problem import Problem
from gen.identification.network.fitting.weights import independent
from gen.refinement.network.effects.base import WHOLE
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data
from gen.refinement.network.fitting.fit import Bench, Fitted
from gen.refinement.network.over_time.courses import Blocks, Course, along, blocks_of
from gen.refinement.network.over_time.moving import Moving, MovingCooling, MovingHeat, given, with_course
from gen.refinement.network.over_time.walk import walked

ROUNDS, SAME, LIKELIEST = 8, 1.0, 3
"""Linearisations, the gain of evidence below which there is no further one, and how many places are worth more than
one: what was found was fitted without the course, and is bent by it."""
FARTHEST = 0.7
"""By which no capacity, conductance or heat changes in one of them, as a logarithm."""
_TINY = 1e-9
"""On the diagonal of the normal equations, as a share of it."""


@dataclass(frozen=True, eq=False)
class _Asked:
    """What may be missing.

    Attributes
    ----------
    term
        It, in the network.
    typical
        What it may be at the start: W, or what the network has of conductance itself where it is None.
    """

    term: Moving
    typical: float | None = None


@dataclass(frozen=True, eq=False)
class _Stage:
    """One linearised fit of a course: it, and where the next one begins.

    Attributes
    ----------
    course
        The course.
    vector
        All other numbers beside it.
    value
        Of each block, in the unit of its typical one, shape (K,).
    """

    course: Course
    vector: FloatArray
    value: FloatArray


def fitted_courses(bench: Bench, fitted: Fitted, shape: Anchored) -> list[Course]:
    """Give the course of each quantity at each place, the likeliest first.

    Those behind the first few of each quantity are of one linear step.

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
    blocks = blocks_of(problem.inputs, bench.data.later)
    begun = _Unknown(problem, vector, blocks)
    made: list[Course] = []
    for offered in (_heats(shape), _coolings(shape)):
        none = np.zeros(sum(one.count for one in blocks))
        first = [(begun.course(one, none, begun.cost), one) for one in offered]
        first.sort(key=lambda pair: -pair[0].course.evidence)
        made += [_converged(problem, blocks, stage, one, begun.cost) for stage, one in first[:LIKELIEST]]
        # One linear step promises too much: the others stand behind those that were fitted to the end.
        least = min((one.evidence for one in made), default=0.0)
        made += [_no_more(stage.course, least) for stage, _ in first[LIKELIEST:]]
    return sorted(made, key=lambda one: -one.evidence)


def _no_more(course: Course, least: float) -> Course:
    over = max(course.evidence - least, 0.0)
    return replace(course, evidence=course.evidence - over, likelihood=course.likelihood - over)


def _heats(shape: Anchored) -> list[_Asked]:
    terms = [MovingHeat(shape.names[node], node) for node in range(shape.base_nodes)] + [MovingHeat(WHOLE, None)]
    typical = shape.motor().typical_W
    return [_Asked(term, typical) for term in terms]


def _coolings(shape: Anchored) -> list[_Asked]:
    outer = shape.motor().outer
    terms = [MovingCooling(shape.names[shape.base_paths[q][0]], [q], [outer]) for q in outer]
    if len(outer) > 1:
        terms.append(MovingCooling(WHOLE, outer, [[q] for q in outer]))
    return [_Asked(term) for term in terms]


def _converged(
    problem: Problem[Anchored], blocks: Sequence[Blocks], stage: _Stage, asked: _Asked, none: float
) -> Course:
    """Fit the course of one place from where the fit before it ended, until the readings get no likelier."""
    for _ in range(ROUNDS - 1):
        last = stage.course
        stage = _at(problem, stage, blocks, asked).course(asked, stage.value, none)
        if abs(stage.course.evidence - last.evidence) < SAME:
            break
    return stage.course


def _at(problem: Problem[Anchored], stage: _Stage, blocks: Sequence[Blocks], asked: _Asked) -> _Unknown:
    """Linearise at what was found, the course included: all other numbers act on temperatures as they are with it."""
    inputs = with_course(problem.inputs, along(blocks, stage.value, problem.inputs.level.size))
    shape = problem.structure.with_effects(*problem.structure.effects, asked.term)
    return _Unknown(replace(problem, structure=shape, inputs=inputs), stage.vector, blocks)


def _weights(data: Data) -> FloatArray:
    """What each reading counts by the noise of its sensor alone, shape (N, S); what the file stands for, as ever."""
    inputs = data.inputs
    noise = np.array([independent(run) for run in inputs.runs])[inputs.run]
    density = np.where(data.is_later[:, None], noise, data.declared)
    return np.where(inputs.covered > 0.0, inputs.covered / np.where(density > 0.0, density, np.inf), 0.0)


class _Unknown:
    """The normal equations of all numbers at once, to which the course of one place is added.

    Parameters
    ----------
    problem, vector
        What was found, and its numbers.
    blocks
        Of the later runs.
    """

    def __init__(self, problem: Problem[Anchored], vector: FloatArray, blocks: Sequence[Blocks]) -> None:
        self._problem, self._vector, self._blocks = problem, vector, blocks
        passage = problem.passage(vector)
        evaluated, slopes = problem.compared(passage), problem.slopes_along(passage)
        self._steps, self._residual, self._slopes, self._after = (
            passage.steps,
            evaluated.residual,
            slopes,
            evaluated.after,
        )
        matrix, self._right = problem.assembled(problem.weighed_up(evaluated, slopes)[1], vector)
        self._numbers = cho_factor(matrix + _TINY * np.diag(np.diag(matrix)), check_finite=False)
        self._begun = evaluated.cost + problem.penalty(vector)
        alone = cho_solve(self._numbers, self._right, check_finite=False)
        #: Weighed squares at the minimum without a further course.
        self.cost = self._begun - float(self._right @ alone)

    def course(self, asked: _Asked, value: FloatArray, none: float) -> _Stage:
        """Fit the course of one place.

        Parameters
        ----------
        asked
            What, and where.
        value
            Its values in the present model, shape (K,), units of the term.
        none
            Weighed squares without any course.
        """
        own, beside = np.zeros((value.size, value.size)), np.zeros((value.size, self._problem.size))
        right = np.zeros(value.size)
        unit, pattern = self._unit_and_pattern(asked.term)
        answers = self._answers(pattern)
        for number, blocks in enumerate(self._blocks):
            at, weight = blocks.at, self._problem.inputs.weight[blocks.rows]
            lines = answers[blocks.rows, :, : blocks.count]
            weighed = (lines * weight[:, :, None]).reshape(-1, blocks.count)
            slopes = self._slopes[blocks.rows].astype(np.float64)
            own[at, at] = weighed.T @ lines.reshape(-1, blocks.count)
            beside[at, self._problem.columns(number)] = weighed.T @ slopes.reshape(-1, slopes.shape[-1])
            right[at] = weighed.T @ self._residual[blocks.rows].ravel()
        # What would be left, to first order, without what the model already has of it.
        begun = self._begun + float(value @ (2.0 * right + own @ value))
        right = right + own @ value
        numbers = self._right + value @ beside
        # All other numbers at what is best for each course.
        by_course = cho_solve(self._numbers, beside.T, check_finite=False)
        alone = cho_solve(self._numbers, numbers, check_finite=False)
        own = own - beside @ by_course
        right = right - beside @ alone
        cost = begun - float(numbers @ alone)
        typical = 1.0 if asked.typical is None else asked.typical / max(unit, _TINY)
        found = walked(own, right, self._problem.inputs, self._blocks, typical)
        deviation = unit * np.sqrt(np.maximum(found.variance, 0.0))
        inputs = self._problem.inputs
        runs = tuple(b.course(number, inputs, unit * found.value, deviation) for number, b in enumerate(self._blocks))
        likelihood = found.evidence - 0.5 * cost
        left = max(cost - found.relief, 0.0) / max(none, _TINY)
        term = asked.term
        course = Course(term.quantity, term.component, likelihood, likelihood + 0.5 * none, left, runs, usual=unit)
        step = alone - by_course @ found.value
        most = float(np.abs(step[: self._problem.structure.offsets[0]]).max())
        step *= min(1.0, FARTHEST / max(most, _TINY))
        return _Stage(course, self._vector + step, found.value)

    def _unit_and_pattern(self, term: Moving) -> tuple[float, FloatArray]:
        """What one unit of a course is, W or W/K, and its heat at each node in each bin, shape (N, n), W."""
        problem, inputs = self._problem, self._problem.inputs
        shape, levels = problem.structure, inputs.levels
        if term not in shape.effects:
            shape = shape.with_effects(*shape.effects, term)
            levels = replace(levels, further=np.column_stack([levels.further, np.zeros(levels.count)]))
        none, one = (shape.physical(given(levels, value), self._vector) for value in (0.0, 1.0))
        heat, conductance = one.heat - none.heat, one.conductance - none.conductance
        made = heat[inputs.level]
        # A conductance takes heat by the node's excess over the ambient: by its mean over the bin.
        before = self._after.copy()
        for rows in inputs.rows:
            before[rows[1:]] = self._after[rows[:-1]]
        excess = 0.5 * (before + self._after) - problem.ambient(self._vector)[:, None]
        for q in term.acts_on:
            node = shape.base_paths[q][0]
            made[:, node] -= conductance[inputs.level, q] * excess[:, node]
        each = heat if term.quantity == "heat" else conductance
        return float(each.sum(axis=1).max()), made

    def _answers(self, pattern: FloatArray) -> FloatArray:
        """What sensors show of a heat at each node in each bin, by the block of the bin's run, shape (N, S, k), K."""
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
                after[:, block] += steps.gain[level] @ pattern[row]
                change = (after - before)[: structure.sensors]
                made[row] = before[: structure.sensors] + inputs.share[row][:, None] * change
                changes[row] = change[lagging] / inputs.width[row]
                before = after
        structure.through_sensors(inputs, self._vector, made, changes)
        return made
