"""The file's network with effects, fitted to later runs and to what the file stands for, all together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from gen.arrays import BoolArray, FloatArray, SingleArray
from gen.identification.network.fitting.fit import Fit, settle
from gen.identification.network.fitting.inputs import Inputs
from gen.identification.network.fitting.priors import Prior
from gen.identification.network.fitting.problem import Evaluated, Problem
from gen.identification.network.fitting.rooms import share_level
from gen.identification.network.fitting.weights import density
from gen.refinement.network.effects.base import Seen
from gen.refinement.network.fitting.anchored import Anchored
from gen.refinement.network.fitting.data import Data
from gen.refinement.network.fitting.folds import folds_of
from gen.side_by_side import side_by_side

AT_FIRST, AT_EACH, AT_LAST, AT_LEFT_OUT, AT_TRIAL = 20, 16, 40, 4, 6
"""Linearisations: of the file alone, of an effect beside it, of one that is compared with others by its cost, of a
fold, of a trial. A fit of six runs is at its minimum after some 25; after ten its cost may be twice that."""
SAME = 0.25
ROUNDS = 3
ROOM_K = 0.7
"""Standard deviation of what a file's fixed ambient may be off by, where later runs measure theirs, K: it comes of cold
starts, or of somebody's note."""
GOOD = 0.25**2 * 600.0
"""Density of the errors of a good model: a quarter of a kelvin that lasts for ten minutes, K^2 s."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """One hypothesis at its best.

    Attributes
    ----------
    problem
        With its weights.
    fit
        The minimum.
    """

    problem: Problem[Anchored]
    fit: Fit

    @property
    def shape(self) -> Anchored:
        """What was fitted."""
        return self.problem.structure

    @property
    def vector(self) -> FloatArray:
        """Parameters, shape (P,)."""
        return self.fit.vector


class Bench:
    """Runs, and what to fit to them.

    Parameters
    ----------
    data
        The runs.
    """

    def __init__(self, data: Data) -> None:
        self.data = data
        self.folds = folds_of(data)
        self._weight = np.zeros_like(data.inputs.covered)

    def weigh(self, of: FloatArray) -> None:
        """Weigh the later runs by a density of errors, shape (S,), K^2 s."""
        later = self.data.is_later[:, None]
        self._weight = self.data.inputs.covered / np.where(later, of, self.data.declared)

    def weigh_as(self, fitted: Fitted) -> None:
        """Weigh the later runs as they were in a fit."""
        self._weight = fitted.problem.inputs.weight

    def problem(self, shape: Anchored) -> Problem[Anchored]:
        """Give the problem of a hypothesis, with the present weights."""
        inputs = self.data.inputs
        own = shape.nodes + inputs.room.shape[-1]
        size = shape.size + len(inputs.runs) * own
        mean, precision = np.zeros(size), np.zeros((size, size))
        mean[: shape.size], precision[: shape.size, : shape.size] = shape.prior()
        deviation = np.full(own, 1e-3)
        for r in range(len(inputs.runs)):
            first = shape.size + r * own
            deviation[: shape.sensors], deviation[shape.sensors : shape.nodes] = inputs.loose[r]
            if r >= self.data.later:
                deviation[: shape.nodes] = 1e-3
            at = np.arange(first, first + own)
            precision[at, at] = deviation**-2
        self._start_from_readings(shape, precision)
        if inputs.room.shape[-1]:
            rooms = shape.size + np.arange(self.data.later, len(inputs.runs)) * own + shape.nodes
            share_level(precision, rooms, ROOM_K)
        problem = Problem(shape, inputs, Prior(mean, precision))
        return problem.weighed(self._weight)

    def _start_from_readings(self, shape: Anchored, precision: FloatArray) -> None:
        """A start that was read is as wrong as its sensor: what is loose is the start less what an effect reads.

        Parameters
        ----------
        shape
            The hypothesis.
        precision
            Of the prior, shape (P, P), changed in place.
        """
        inputs, later = self.data.inputs, self.data.later
        own = shape.nodes + inputs.room.shape[-1]
        read_K = np.array([run.begin for run in inputs.runs[:later]])
        ambient = np.array([run.ambient[0] for run in inputs.runs[:later]])
        seen = Seen(inputs.begin[:later, : shape.sensors], ambient, np.zeros(later))
        wrong: dict[int, list[tuple[int, FloatArray]]] = {}
        for effect, place in zip(shape.effects, shape.places, strict=True):
            # At the beginning what is added goes with each number, whatever it is.
            for read in effect.read(seen, np.array([number.fitted(number.start) for number in effect.numbers])):
                by_number = zip(place.columns, read.slopes, strict=True)
                wrong.setdefault(read.sensor, []).extend((int(column), slope) for column, slope in by_number)
        for sensor, effects in wrong.items():
            columns = [column for column, _ in effects]
            for r in np.flatnonzero(inputs.begin[:later, sensor] == read_K[:, sensor]).tolist():
                at = np.array([shape.size + r * own + sensor, *columns])
                loose = np.array([1.0, *[float(unit[r]) for _, unit in effects]])
                together = np.outer(loose, loose)
                together[0, 0] = 0.0  # is there already
                precision[np.ix_(at, at)] += together / inputs.loose[r][0] ** 2

    def first(self, shape: Anchored) -> Fitted:
        """Fit the file alone until the weights agree with what is left."""
        problem = self.problem(shape)
        return self.tightened(shape, self._start(shape, problem), AT_FIRST)

    def tightened(self, shape: Anchored, start: FloatArray, most: int = AT_EACH) -> Fitted:
        """Fit until the weights agree with what is left, or with what a good model leaves where that is more.

        An error that an effect is to explain must not make the runs count for less.
        """
        of = np.full(shape.sensors, GOOD)
        for _ in range(ROUNDS):
            self.weigh(of)
            problem = self.problem(shape)
            fit = settle(problem, start, most)
            start = fit.vector
            own = np.minimum(self.density(fit), GOOD)
            if np.all(np.abs(np.log(own / of)) < SAME):
                break
            of = own
        return Fitted(problem, fit)

    def density(self, fit: Fit) -> FloatArray:
        """Density of what a fit leaves of the later runs, shape (S,), K^2 s."""
        inputs = self.data.inputs
        residual = np.where(self.data.is_later[:, None], fit.evaluated.residual, 0.0)
        return density(_masked(inputs, self.data), residual)

    def begin(self, shape: Anchored, base: Fitted) -> tuple[Problem[Anchored], FloatArray]:
        """Give the problem of a hypothesis, and where its search begins: at what was fitted without it."""
        problem = self.problem(shape)
        start = self._start(shape, problem)
        old = base.shape
        count = old.base_nodes
        start[:count] = base.vector[:count]
        between = shape.offsets[-1] + 1 - shape.nodes
        start[shape.nodes : shape.nodes + between] = base.vector[old.nodes : old.nodes + between]
        for effect, place in zip(shape.effects, shape.places, strict=True):
            for known, its in zip(old.effects, old.places, strict=True):
                if known is effect:
                    start[place.columns] = base.vector[its.columns]
        mine, theirs = problem.per_run(start), base.problem.per_run(base.vector)
        shared = min(shape.nodes, old.nodes)
        mine[:, :shared] = theirs[:, :shared]
        start[shape.size :] = mine.ravel()
        return problem, start

    def fit(self, shape: Anchored, base: Fitted, most: int = AT_EACH) -> Fitted:
        """Fit a hypothesis from where the fit without it ended."""
        problem, start = self.begin(shape, base)
        return Fitted(problem, settle(problem, start, most))

    def fits(self, shapes: Sequence[Anchored], base: Fitted) -> list[Fitted]:
        """Fit several hypotheses, side by side."""
        begun = [self.begin(shape, base) for shape in shapes]
        found = side_by_side([partial(settle, problem, start, AT_EACH) for problem, start in begun])
        return [Fitted(problem, fit) for (problem, _), fit in zip(begun, found, strict=True)]

    def finished(self, fitted: Fitted) -> Fitted:
        """Go on to the minimum."""
        return Fitted(fitted.problem, settle(fitted.problem, fitted.vector, AT_LAST))

    def all_finished(self, fitted: Sequence[Fitted]) -> list[tuple[Fitted, FloatArray]]:
        """Go on to the minimum with several, and give also what is left out of each, side by side."""
        found = side_by_side([partial(self._finished, one) for one in fitted])
        return [(Fitted(one.problem, fit), error) for one, (fit, error) in zip(fitted, found, strict=True)]

    def _finished(self, fitted: Fitted) -> tuple[Fit, FloatArray]:
        made = self.finished(fitted)
        return made.fit, self.left_out(made)

    def promises(self, shapes: Sequence[Anchored], base: Fitted) -> list[float]:
        """Give what :meth:`promise` says of several, side by side; those that take a search come first."""
        order = sorted(range(len(shapes)), key=lambda k: not shapes[k].effects[-1].paths)
        found = side_by_side([partial(self.promise, shapes[k], base) for k in order])
        by_place = dict(zip(order, found, strict=True))
        return [by_place[k] for k in range(len(shapes))]

    def promise(self, shape: Anchored, base: Fitted) -> float:
        """Give the decrease of the cost that an effect promises, the last of the shape's.

        By one linear step; by a short search where it has paths of its own, which start far from nothing.
        """
        problem, start = self.begin(shape, base)
        if shape.effects[-1].paths:
            return base.fit.cost - settle(problem, start, AT_TRIAL).cost
        evaluated, normal = problem.linearised(start)
        matrix, right = problem.assembled(normal, start)
        factor = cho_factor(matrix + np.diag(1e-9 * np.diag(matrix)), check_finite=False)
        step = cho_solve(factor, right, check_finite=False)
        begun = evaluated.cost + problem.penalty(start)
        expected = float(step @ (2.0 * right - matrix @ step))
        return base.fit.cost - begun + expected

    def left_out(self, fitted: Fitted) -> FloatArray:
        """Fit without each fold and predict it: errors, shape (N, S), K; NaN where nothing was predicted.

        Of a run that is left out whole nothing is known but where it begins, as of any run that comes later: hidden
        starts that were fitted to it would tell of it.
        """
        covered = self.data.inputs.covered
        error = np.full(covered.shape, np.nan)
        known = fitted.problem.slopes(fitted.vector)  # folds differ by their weights alone
        predicted = side_by_side([partial(self._predicted, fitted, known, mask) for mask in self.folds])
        for mask, residual in zip(self.folds, predicted, strict=True):
            seen = mask[:, None] & (covered > 0.0)
            error[seen] = residual[seen]
        return error

    def _predicted(self, fitted: Fitted, known: tuple[Evaluated, SingleArray], mask: BoolArray) -> FloatArray:
        """What is left of all readings, shape (N, S), K, where one fold took no part in the fit."""
        problem = fitted.problem
        without = problem.weighed(np.where(mask[:, None], 0.0, problem.inputs.weight))
        begun = without.weighed_up(*known)
        start = fitted.vector.copy()
        for r, row in enumerate(problem.inputs.rows[: self.data.later]):
            if mask[row].all():
                forget(without, start, r)
        return problem.evaluate(settle(without, start, AT_LEFT_OUT, begun=begun).vector).residual

    def bent(self, fitted: Fitted) -> float:
        """Give how far the file had to be bent: weighed squares of what it stands for, and of its numbers."""
        earlier = ~self.data.is_later
        weight, residual = fitted.problem.inputs.weight[earlier], fitted.fit.evaluated.residual[earlier]
        return float(np.sum(weight * residual**2)) + fitted.problem.penalty(fitted.vector)

    def as_it_is(self, shape: Anchored) -> FloatArray:
        """Give the errors of the file as it is on the later runs, shape (N, S), K; NaN elsewhere."""
        problem = self.problem(shape)
        residual = problem.evaluate(self._start(shape, problem)).residual
        seen = self.data.is_later[:, None] & (self.data.inputs.covered > 0.0)
        return np.where(seen, residual, np.nan)

    def _start(self, shape: Anchored, problem: Problem[Anchored]) -> FloatArray:
        start = problem.prior.mean.copy()
        start[: shape.size] = shape.start()
        return start


def forget(problem: Problem[Anchored], vector: FloatArray, run: int) -> None:
    """Put a run's own numbers where the prior expects them beside all others, in place."""
    prior = problem.prior
    own = problem.columns(run)[problem.structure.size :]
    away = vector - prior.mean
    away[own] = 0.0
    vector[own] = prior.mean[own] - np.linalg.solve(prior.precision[np.ix_(own, own)], prior.precision[own] @ away)


def _masked(inputs: Inputs, data: Data) -> Inputs:
    """The later runs alone, as far as densities go."""
    return replace(inputs, covered=np.where(data.is_later[:, None], inputs.covered, 0.0))
