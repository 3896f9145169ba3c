"""What runs would tell: how far apart hypotheses are, and how much narrower their intervals become.

Two hypotheses differ by r in the readings of a run. What the free numbers of the second can take up of r is no
evidence, so the separation is T-optimality's (Atkinson and Fedorov, Biometrika 62, 1975): the least of

    (r - J d)^T W (r - J d) + d^T P d        over all changes d of the second one's numbers,

J its sensitivities, P what the runs so far say of its numbers, W the weights of readings, which are those of the fit:
by the density of errors that last. It is averaged over what the true one may be. Intervals are those of the information
matrix P + J^T W J.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.network.fitting.inputs import START_K
from gen.identification.network.fitting.problem import Problem
from gen.planning.hypotheses import Remaining
from gen.planning.march import March, Predicted, problem_of
from gen.planning.stage import Stage
from gen.refinement.network.fitting.anchored import Anchored

REFITS, ENOUGH = 8, 1e-3
"""Linearisations of a hypothesis that is fitted to another one's readings, and decrease of the cost that ends it."""
SHARES = (1.0, 0.5, 0.2, 0.05)
"""Of a step, that are tried."""


@dataclass(frozen=True, eq=False)
class Apart:
    """How far apart hypotheses are in a run.

    Attributes
    ----------
    squares
        Least weighed squares with which the one takes the other's readings, what is known of it before included, either
        way round, shape (pairs, 2).
    left_K
        What is then left of the difference, root mean square over sensors and time, shape (pairs,), K.
    """

    squares: FloatArray
    left_K: FloatArray

    @property
    def worth(self) -> float:
        """What is maximised."""
        return float(np.mean(np.log1p(self.squares)))


class Expected:
    """What runs would tell of what remains.

    Parameters
    ----------
    remaining, stage
        The hypotheses, and where runs would be.
    levels
        PWM that they may have, counts. Runs are given by the levels' numbers.
    """

    def __init__(self, remaining: Remaining, stage: Stage, levels: tuple[int, ...]) -> None:
        self.remaining, self.stage, self.levels = remaining, stage, np.array(levels, dtype=np.int64)
        self._marches = [March(one, stage, levels) for one in remaining.hypotheses]
        self._priors = []
        for one in remaining.hypotheses:
            size, nodes = one.shape.size, one.shape.nodes
            prior = np.zeros((size + nodes, size + nodes))
            prior[:size, :size] = one.precision
            prior[np.arange(size, size + nodes), np.arange(size, size + nodes)] = START_K**-2
            self._priors.append(prior)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Hypotheses to be told apart, by number."""
        count = len(self.remaining.hypotheses)
        return [(i, j) for i in range(count) for j in range(i + 1, count)]

    def weight(self, bins: int) -> FloatArray:
        """Of each reading, shape (T S,), 1/K^2."""
        return np.tile(self.stage.bin_s / self.remaining.density, bins)

    def worth(self, index: IntArray) -> FloatArray:
        """Give what is maximised, of each of K runs, shape (K,).

        Of several hypotheses the mean over all pairs, either way round, of log(1 + separation): what can hardly be told
        apart and what is told apart anyway both count little. Of one alone the logarithm of the information
        matrix's determinant (D-optimality).

        Parameters
        ----------
        index
            Shape (K, T).
        """
        weight = self.weight(index.shape[1])
        each = [march.predicted(index) for march in self._marches]
        matrices = [self._information(k, found, weight) for k, found in enumerate(each)]
        if len(each) == 1:
            return np.asarray(np.linalg.slogdet(matrices[0])[1])
        squares = [
            self._least(true, other, each, matrices[other], weight)
            for pair in self.pairs
            for true, other in _ways(pair)
        ]
        return np.asarray(np.mean(np.log1p(np.maximum(squares, 0.0)), axis=0))

    def _information(self, number: int, found: Predicted, weight: FloatArray) -> FloatArray:
        """P + J^T W J, shape (K, p, p)."""
        weighed = found.slopes * weight[:, None]
        return np.asarray(np.swapaxes(found.slopes, 1, 2) @ weighed + self._priors[number])

    def _least(
        self, true: int, other: int, each: Sequence[Predicted], matrix: FloatArray, weight: FloatArray
    ) -> FloatArray:
        """Mean over what may be true of the least squares that the other one leaves, shape (K,)."""
        moved = self.remaining.hypotheses[true].truths.T
        away = (each[true].reading - each[other].reading)[:, :, None] + each[true].slopes[:, :, : len(moved)] @ moved
        by = np.swapaxes(each[other].slopes, 1, 2) @ (weight[:, None] * away)
        taken = np.sum(by * np.linalg.solve(matrix, by), axis=1)
        return np.asarray(np.mean(np.sum(weight[:, None] * away**2, axis=1) - taken, axis=1))

    def whole(self, index: IntArray) -> Apart:
        """Give how far apart the hypotheses are in one run, by whole fits and not by their linear part.

        Parameters
        ----------
        index
            Shape (T,).
        """
        pwm = self.levels[index]
        both = [[self._refitted(true, other, pwm) for true, other in _ways(pair)] for pair in self.pairs]
        found = np.array(both).reshape(len(both), 2, 2)
        return Apart(found[..., 0], np.sqrt(np.mean(found[..., 1] ** 2, axis=1)))

    def _refitted(self, true: int, other: int, pwm: IntArray) -> tuple[float, float]:
        """One hypothesis fitted to what another may be: mean of the least squares, and what is left, K."""
        density, hypotheses = self.remaining.density, self.remaining.hypotheses
        source = problem_of(hypotheses[true], self.stage, pwm[None], density)
        problem = problem_of(hypotheses[other], self.stage, pwm[None], density)
        found = []
        for moved in hypotheses[true].truths:
            vector = source.prior.mean.copy()
            vector[: moved.size] += moved
            reading = -source.evaluate(vector).residual
            found.append(_refit(replace(problem, inputs=replace(problem.inputs, target=reading))))
        squares, left = np.array(found).T
        return float(np.mean(squares)), float(np.sqrt(np.mean(left**2)))

    def deviations(self, index: IntArray) -> tuple[FloatArray, FloatArray]:
        """Standard deviations of the first hypothesis's numbers, before a run and after it, shape (size,) each.

        Parameters
        ----------
        index
            Shape (T,).
        """
        _, both = self._before_and_after(index)
        made = [np.sqrt(np.maximum(np.diag(np.linalg.inv(one)), 0.0)) for one in both]
        size = self.remaining.hypotheses[0].shape.size
        return made[0][:size], made[1][:size]

    def readings_95_K(self, index: IntArray) -> tuple[float, float]:
        """Half of the widest 95 % interval of a predicted reading along a run, before it and after it, K.

        Parameters
        ----------
        index
            Shape (T,).
        """
        slopes, both = self._before_and_after(index)
        variance = [np.einsum("ap,pa->a", slopes, np.linalg.solve(one, slopes.T)) for one in both]
        before_K, after_K = (1.96 * float(np.sqrt(max(float(v.max()), 0.0))) for v in variance)
        return before_K, after_K

    def _before_and_after(self, index: IntArray) -> tuple[FloatArray, tuple[FloatArray, FloatArray]]:
        """Sensitivities of the first hypothesis along a run, and its information matrices before and after it."""
        found = self._marches[0].predicted(index[None])
        return found.slopes[0], (self._priors[0], self._information(0, found, self.weight(index.size))[0])

    def hottest(self, index: IntArray) -> FloatArray:
        """Give the hottest temperature of each of the file's nodes by any hypothesis, shape (K, n), degC.

        Parameters
        ----------
        index
            Shape (K, T).
        """
        return np.asarray(np.max([march.hottest(index) for march in self._marches], axis=0))


def _ways(pair: tuple[int, int]) -> tuple[tuple[int, int], tuple[int, int]]:
    """What is true, and what is fitted to it."""
    return pair, pair[::-1]


def _refit(problem: Problem[Anchored]) -> tuple[float, float]:
    """Gauss-Newton from what is known before, steps cut where they lead up: cost, and what is left, K.

    One long run may move numbers by many of their standard deviations, so steps are not held to these.
    """
    vector = problem.prior.mean
    evaluated, normal = problem.linearised(vector)
    cost = evaluated.cost
    for _ in range(REFITS):
        matrix, right = problem.assembled(normal, vector)
        step, before = np.linalg.solve(matrix, right), cost
        for share in SHARES:
            trial = vector + share * step
            passage = problem.passage(trial)
            new = problem.compared(passage).cost + problem.penalty(trial)
            if new < cost:
                vector, cost = trial, new
                break
        if cost > (1.0 - ENOUGH) * before:
            break
        _, normal = problem.linearised_along(passage)
    left = problem.evaluate(vector).residual
    return cost, float(np.sqrt(np.mean(left**2)))
