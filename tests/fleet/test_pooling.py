"""Mean and spread of a fleet against the maximum of the same posterior, found without EM."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import multivariate_normal

from gen.arrays import FloatArray
from gen.fleet.statistics import pooling
from gen.fleet.statistics.pooling import DEGREES, MEAN_SPREAD, USUAL_SPREAD, Pool, Told, pooled

FREE = np.zeros(2, dtype=np.bool_)


def told(seed: int, motors: int, *, blind: float = 0.0) -> tuple[Told, FloatArray]:
    """Two parameters; each motor's runs tell them with errors of its own; a share of motors says nothing of one."""
    rng = np.random.default_rng(seed)
    truth = rng.normal([1.0, -2.0], [0.2, 0.05], (motors, 2))
    matrices, vectors = [], []
    for theta in truth:
        root = rng.normal(0.0, 8.0, (3, 2))
        if rng.random() < blind:
            root[:, 1] = 0.0
        matrix = root.T @ root
        matrices.append(matrix)
        vectors.append(matrix @ theta + root.T @ rng.normal(0.0, 1.0, 3))
    return Told(np.array(matrices), np.array(vectors)), truth


def posterior(data: Told, mean: FloatArray, log_variance: FloatArray, first: FloatArray) -> float:
    """Logarithm of the posterior of mu and T, but for a constant, by the densities of the estimates themselves."""
    variance = np.exp(log_variance)
    total = 0.0
    for matrix, vector in zip(data.matrix, data.vector, strict=True):
        # b = N theta + e, e ~ N(0, N): so b ~ N(N mu, N T N + N).
        spread = matrix @ np.diag(variance) @ matrix + matrix
        total += float(multivariate_normal.logpdf(vector, matrix @ mean, spread))
    total -= float(np.sum((mean - first) ** 2)) / (2.0 * MEAN_SPREAD**2)
    return total - float(np.sum((DEGREES / 2.0 + 1.0) * log_variance + DEGREES * USUAL_SPREAD**2 / (2.0 * variance)))


@pytest.mark.parametrize("motors", [3, 8])
def test_em_finds_the_maximum_of_the_posterior(motors: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pooling, "TOLERANCE", 1e-7)
    monkeypatch.setattr(pooling, "TURNS", 5000)
    data, _ = told(motors, motors)
    first = np.array([0.9, -1.9])
    found = pooled(data, Pool(first, np.full(2, 0.01)), FREE)

    def negative(x: FloatArray) -> float:
        return -posterior(data, x[:2], x[2:], first)

    best = minimize(
        negative,
        np.concatenate([first, np.log([0.01, 0.01])]),
        method="Nelder-Mead",
        options={"xatol": 1e-5, "fatol": 1e-8, "maxiter": 1000},
    )
    assert np.allclose(found.mean, best.x[:2], atol=1e-4)
    assert np.allclose(np.log(found.variance), best.x[2:], atol=1e-3)


def deviations(told: Told, pool: Pool) -> tuple[FloatArray, FloatArray]:
    """Each motor's most probable parameters and their standard deviations, shape (M, p)."""
    covariance = np.linalg.inv(told.matrix + np.diag(1.0 / pool.variance))
    mean = np.einsum("mij,mj->mi", covariance, told.vector + pool.mean / pool.variance)
    return mean, np.sqrt(np.einsum("mii->mi", covariance))


def test_motors_that_say_nothing_get_the_fleets_mean_and_spread() -> None:
    data, _ = told(4, 60)
    silent = Told(np.concatenate([data.matrix, np.zeros((1, 2, 2))]), np.concatenate([data.vector, np.zeros((1, 2))]))
    pool = pooled(silent, Pool(np.array([0.9, -1.9]), np.full(2, 0.01)), FREE)
    mean, deviation = deviations(silent, pool)
    assert np.allclose(mean[-1], pool.mean)
    assert np.allclose(deviation[-1] ** 2, pool.variance)


def test_pooling_errs_less_than_each_motor_alone() -> None:
    data, truth = told(5, 200)
    pool = pooled(data, Pool(np.array([0.9, -1.9]), np.full(2, 0.01)), FREE)
    mean, _ = deviations(data, pool)
    alone = np.linalg.solve(data.matrix, data.vector[..., None])[..., 0]
    assert np.sqrt(np.mean((mean - truth) ** 2)) < 0.7 * np.sqrt(np.mean((alone - truth) ** 2))
    assert np.allclose(pool.mean, [1.0, -2.0], atol=0.05)
    assert np.sqrt(pool.variance[0]) == pytest.approx(0.2, rel=0.25)


def test_what_is_fixed_stays() -> None:
    data, _ = told(6, 20)
    first = Pool(np.array([0.9, 0.0]), np.array([0.01, 0.49]))
    pool = pooled(data, first, np.array([False, True]))
    assert (pool.mean[1], pool.variance[1]) == (0.0, 0.49)


def test_the_order_of_the_motors_is_all_that_a_sum_depends_on() -> None:
    data, _ = told(7, 70)
    first = Pool(np.array([0.9, -1.9]), np.full(2, 0.01))
    one, other = pooled(data, first, FREE), pooled(data, first, FREE)
    assert one.mean.tobytes() == other.mean.tobytes()
    assert one.variance.tobytes() == other.variance.tobytes()
