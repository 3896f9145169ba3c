"""Damped Gauss-Newton, twice.

Far from the minimum `approach` damps each parameter by its own curvature and cuts each step (Levenberg, Marquardt).
Near it `settle` works in a trust region in units of the prior's standard deviations: directions that the runs do not
determine are damped first, those that they determine well take their whole step (Nocedal and Wright, Numerical
Optimization, 4.3).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.optimize import brentq

from gen.arrays import FloatArray
from gen.identification.network.fitting.physics import Shape
from gen.identification.network.fitting.problem import Evaluated, Normal, Problem

FIRST_RADIUS, LARGEST_RADIUS = 0.5, 4.0
"""How far one iteration may go, in standard deviations of the prior, for every single parameter."""
FIRST_DAMPING = 1e-2
TOLERANCE = 1e-4
"""Relative decrease of the cost below which the search ends."""
LEAST_DAMPING, MOST_DAMPING = -6.0, 16.0
"""Logarithms (base 10) of what is added to the curvature in a trust region, in units of the prior's precision."""
TINY = 1e-300
TRIALS = 8
WORTH = 1e-3
"""Least share of the expected decrease with which a step is taken."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A minimum.

    Attributes
    ----------
    vector
        Parameters, shape (P,).
    cost
        With the priors.
    evaluated, normal
        There.
    """

    vector: FloatArray
    cost: float
    evaluated: Evaluated
    normal: Normal


def approach(problem: Problem[Shape], start: FloatArray, most: int, tolerance: float = TOLERANCE) -> Fit:
    """Go down from afar, each parameter by at most its prior's standard deviation at once.

    Parameters
    ----------
    start
        Shape (P,).
    most
        Linearisations.
    tolerance
        Relative decrease of the cost at which to end.
    """
    unit = problem.prior.deviation
    vector = start
    evaluated, normal = problem.linearised(vector)
    cost = evaluated.cost + problem.penalty(vector)
    damping, growth = FIRST_DAMPING, 2.0
    iteration = 1
    while iteration < most:
        matrix, right = problem.assembled(normal, vector)
        improved, new, ratio, trial = False, cost, 0.0, vector
        for _ in range(TRIALS):
            factor = cho_factor(matrix + np.diag(damping * np.diag(matrix)), check_finite=False)
            step = np.clip(cho_solve(factor, right, check_finite=False), -unit, unit)
            trial = problem.prior.within(vector + step)
            passage = problem.passage(trial)
            new = problem.compared(passage).cost + problem.penalty(trial)
            expected = float(step @ (2.0 * right - matrix @ step))
            ratio = (cost - new) / expected if expected > 0.0 else -1.0
            improved = bool(new < cost and ratio > WORTH)
            if improved:
                break
            damping, growth = damping * growth, growth * 2.0
        if not improved:
            break
        # Nielsen's rule.
        damping, growth = max(damping * max(0.2, 1.0 - (2.0 * ratio - 1.0) ** 3), 1e-8), 2.0
        small = cost - new < tolerance * cost
        vector, cost = trial, new
        evaluated, normal = problem.linearised_along(passage)
        iteration += 1
        if small:
            break
    return Fit(vector, cost, evaluated, normal)


def settle(
    problem: Problem[Shape],
    start: FloatArray,
    most: int,
    tolerance: float = TOLERANCE,
    begun: tuple[Evaluated, Normal] | None = None,
) -> Fit:
    """Go to the minimum.

    Parameters
    ----------
    problem, start, most, tolerance
        As for :func:`approach`.
    begun
        What `linearised` gives at the start, where that is known.
    """
    vector = start
    evaluated, normal = begun or problem.linearised(vector)
    cost = evaluated.cost + problem.penalty(vector)
    radius = FIRST_RADIUS
    deviation = problem.prior.deviation
    small = 0
    iteration = 1
    while iteration < most:
        matrix, right = problem.assembled(normal, vector)
        trust = Trust(matrix, right, deviation)
        improved = False
        for _ in range(TRIALS):
            step = trust.step(radius)
            trial = problem.prior.within(vector + step)
            step = trial - vector
            passage = problem.passage(trial)
            new = problem.compared(passage).cost + problem.penalty(trial)
            expected = float(step @ (2.0 * right - matrix @ step))
            ratio = (cost - new) / expected if expected > 0.0 and np.isfinite(new) else -1.0
            length = float(np.max(np.abs(step) / deviation))
            if ratio < 0.25:
                radius = 0.3 * min(radius, length)
            elif ratio > 0.75:
                radius = min(max(radius, 2.0 * length), LARGEST_RADIUS)
            if ratio > WORTH:
                improved = True
                break
        if not improved:
            break
        small = small + 1 if cost - new < tolerance * cost else 0
        vector, cost = trial, new
        evaluated, normal = problem.linearised_along(passage)
        iteration += 1
        if small >= 2:
            break
    return Fit(vector, cost, evaluated, normal)


class Trust:
    """The minimum of the linearised problem within a radius.

    Parameters
    ----------
    matrix, right
        Normal equations, shapes (P, P) and (P,).
    deviation
        Unit of each parameter, shape (P,).
    """

    def __init__(self, matrix: FloatArray, right: FloatArray, deviation: FloatArray) -> None:
        self._deviation, self._plain = deviation, right * deviation
        self._matrix = matrix * deviation * deviation[:, None]

    def step(self, radius: float) -> FloatArray:
        """Give the step, no entry longer than `radius` units; shape (P,)."""
        whole = self._whole
        if whole is not None and np.max(np.abs(whole)) <= radius:
            return whole * self._deviation
        damping = LEAST_DAMPING
        if self._longer(MOST_DAMPING, radius) >= 0.0:
            damping = MOST_DAMPING  # nothing is so short
        elif self._longer(LEAST_DAMPING, radius) > 0.0:
            damping = brentq(self._longer, LEAST_DAMPING, MOST_DAMPING, args=(radius,), xtol=1e-3)
        return self._damped(10.0**damping) * self._deviation

    def _longer(self, damping: float, radius: float) -> float:
        """Logarithm of the step's longest entry over the radius, which falls as damping (its logarithm) grows."""
        longest = float(np.max(np.abs(self._damped(10.0**damping))))
        return float(np.log(max(longest, TINY)) - np.log(max(radius, TINY)))

    @cached_property
    def _whole(self) -> FloatArray | None:
        """The step to the minimum without a radius; None where there is none."""
        try:
            factor = cho_factor(self._matrix, check_finite=False)
        except LinAlgError:
            return None
        return np.asarray(cho_solve(factor, self._plain, check_finite=False))

    @cached_property
    def _modes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Eigenvalues, eigenvectors as columns, and the right-hand side along them."""
        values, vectors = np.linalg.eigh(self._matrix)  # divide and conquer
        return np.maximum(values, 1e-9), vectors, vectors.T @ self._plain

    def _damped(self, damping: float) -> FloatArray:
        values, vectors, along = self._modes
        return np.asarray(vectors @ (along / (values + damping)))
