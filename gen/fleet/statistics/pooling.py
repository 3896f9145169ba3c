"""A fleet's mean and spread from what each motor's runs say of its own parameters: empirical Bayes, all Gaussian.

Motor m has parameters theta_m ~ N(mu, diag T), and its runs say of them N_m theta_m = b_m, N_m the normal matrix of its
fit (Gauss-Newton), singular where the runs say nothing. With V_m = (N_m + T^-1)^-1, given mu and T,

    theta_m ~ N(V_m (b_m + T^-1 mu), V_m)

and with W = T^-1 the marginal of b_m says of mu the precision W - W V_m W and the vector W V_m b_m. So mu has a closed
form given T, and T is found by EM (Dempster, Laird, Rubin, JRSS B 39, 1977; with mu maximised exactly in each turn:
ECME, Liu and Rubin, Biometrika 81, 1994). Few motors say little of T: it has a scaled inverse chi-squared prior, mu a
normal one, and the maximum of the posterior is taken (Gelman et al., Bayesian Data Analysis, 3rd ed., 5.4 and 13.6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import BoolArray, FloatArray, IntArray

USUAL_SPREAD, DEGREES = 0.1, 4.0
"""What motors of one series are taken to differ by, as standard deviation of a logarithm, and as how many motors that
counts."""
MEAN_SPREAD = 1.0
"""Standard deviation of the prior of mu about where it begins."""
TURNS, TOLERANCE = 200, 1e-3
"""Turns at most, and the largest relative change of a variance at which to end."""
_AT_ONCE = 32
"""Motors whose matrices are inverted in one call: memory does not grow with the fleet's."""


@dataclass(frozen=True, eq=False)
class Told:
    """What runs say of M motors' p parameters.

    Attributes
    ----------
    matrix
        N_m, shape (M, p, p).
    vector
        b_m, shape (M, p).
    """

    matrix: FloatArray
    vector: FloatArray


@dataclass(frozen=True, eq=False)
class Pool:
    """A fleet.

    Attributes
    ----------
    mean, variance
        mu and T, shape (p,).
    """

    mean: FloatArray
    variance: FloatArray


@dataclass(frozen=True, eq=False)
class Sums:
    """What one pass over the motors gives.

    Attributes
    ----------
    precision, vector
        Of mu, shapes (p, p) and (p,).
    square
        Sum of the expected (theta_m - mu)^2, shape (p,), at the mu that was given.
    """

    precision: FloatArray
    vector: FloatArray
    square: FloatArray


def integrated_out(matrix: FloatArray, right: FloatArray, kept: IntArray) -> tuple[FloatArray, FloatArray]:
    """Take all but some parameters out of normal equations, with what the equations say of them.

    With blocks k and o, N = N_kk - N_ko N_oo^-1 N_ok, and the right-hand side likewise.

    Parameters
    ----------
    matrix, right
        Shapes (P, P) and (P,).
    kept
        Which parameters stay, shape (p,).

    Returns
    -------
    matrix, right
        Shapes (p, p) and (p,).
    """
    others = np.setdiff1d(np.arange(right.size), kept)
    gain = np.linalg.solve(matrix[np.ix_(others, others)], matrix[np.ix_(others, kept)])
    told = matrix[np.ix_(kept, kept)] - matrix[np.ix_(kept, others)] @ gain
    return 0.5 * (told + told.T), right[kept] - gain.T @ right[others]


def pooled(told: Told, first: Pool, fixed: BoolArray) -> Pool:
    """Find the fleet's mean and spread.

    Parameters
    ----------
    told
        What runs say.
    first
        Where to begin; the mean of mu's prior. Of fixed parameters what they stay at.
    fixed
        Parameters whose mean and variance are known, shape (p,).
    """
    count = told.matrix.shape[0]
    mean, variance = first.mean.copy(), first.variance.copy()
    for _ in range(TURNS):
        mean = np.where(fixed, first.mean, mean_of(told, Pool(mean, variance), first.mean, fixed))
        square = passed(told, Pool(mean, variance)).square
        new = (DEGREES * USUAL_SPREAD**2 + square) / (DEGREES + 2.0 + count)
        new = np.where(fixed, variance, new)
        change = float(np.max(np.abs(new / variance - 1.0)))
        variance = new
        if change < TOLERANCE:
            break
    return Pool(np.where(fixed, first.mean, mean_of(told, Pool(mean, variance), first.mean, fixed)), variance)


def mean_of(told: Told, at: Pool, prior: FloatArray, fixed: BoolArray) -> FloatArray:
    """Give the most probable mu for a T, shape (p,); what is fixed stays as in the prior."""
    sums = passed(told, at)
    free = ~fixed
    precision = sums.precision[np.ix_(free, free)] + np.eye(int(free.sum())) / MEAN_SPREAD**2
    right = sums.vector - sums.precision[:, fixed] @ prior[fixed]
    found = prior.copy()
    found[free] = np.linalg.solve(precision, right[free] + prior[free] / MEAN_SPREAD**2)
    return found


def passed(told: Told, at: Pool) -> Sums:
    """Go over all motors once."""
    weight = 1.0 / at.variance
    size = weight.size
    precision, vector, square = np.zeros((size, size)), np.zeros(size), np.zeros(size)
    for first in range(0, told.matrix.shape[0], _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        inverse = np.linalg.inv(told.matrix[part] + np.diag(weight))
        away = told.vector[part] - told.matrix[part] @ at.mean
        mean = np.einsum("mij,mj->mi", inverse, away)
        precision += (np.diag(weight) - weight[:, None] * inverse * weight).sum(axis=0)
        vector += (weight * np.einsum("mij,mj->mi", inverse, told.vector[part])).sum(axis=0)
        square += (mean**2 + np.einsum("mii->mi", inverse)).sum(axis=0)
    return Sums(precision, vector, square)
