"""What the residuals say: noise that averages out slowly, intervals, information criteria, whiteness, independence.

Residuals of a thermal run are correlated (quantiser, drift, what the model lacks), so formulas for white noise would
give intervals that are far too narrow. Here the spectral density of the residual at low frequency replaces
the variance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, stdtrit

from gen.arrays import FloatArray
from gen.identification.logs.records import Record, quantiser_bias
from gen.identification.parts.output_error import OutputErrorFit, OutputErrorProblem, Simulator

BLOCKS = 200
"""Residuals are looked at in this many equal blocks of a run."""
LAGS = 20


@dataclass(frozen=True)
class Noise:
    """The residual of one record.

    Attributes
    ----------
    density
        Spectral density at low frequency, K^2 s: the variance of a mean over a long time D is density / D.
    effective
        Number of independent samples that are worth as much as the record's.
    blocks
        Means of the residual over equal blocks, K; NaN where a block is empty.
    block_s
        Their length, s.
    """

    density: float
    effective: float
    blocks: FloatArray
    block_s: float


def residual_noise(record: Record, residual: FloatArray, parameters: float) -> Noise:
    """Estimate a residual's noise.

    Parameters
    ----------
    record
        Its record.
    residual
        Measured minus model at the record's blocks, shape (m,), K.
    parameters
        How many parameters the record has paid for.
    """
    width = record.duration / min(BLOCKS, len(record.time))
    index = np.minimum((record.time / width).astype(np.int64), BLOCKS - 1)
    count = np.bincount(index, record.count, minlength=index.max() + 1)
    with np.errstate(invalid="ignore"):
        means = np.bincount(index, record.count * residual, minlength=len(count)) / np.where(count, count, np.nan)
    present = means[np.isfinite(means)]
    freedom = max(len(present) - parameters, 1.0)
    variance = float(np.sum(present**2)) / freedom
    factor = 1.0 + 2.0 * float(np.sum(positive_sequence(autocorrelation(present, min(LAGS * 2, len(present) // 4)))))
    floor = record.noise_K**2 * record.sample_s
    density = max(variance * factor * width, floor, 1e-12)
    total = float(np.sum(record.count * residual**2) / np.sum(record.count)) + record.noise_K**2
    effective = min(total * record.duration / density, float(record.count.sum()))
    return Noise(density, max(effective, 2.0), means, width)


def autocorrelation(values: FloatArray, lags: int) -> FloatArray:
    """Give the autocorrelation at lags 1 .. lags (biased estimate, about zero mean)."""
    square = float(np.sum(values**2))
    if square <= 0.0 or lags < 1:
        return np.zeros(max(lags, 0))
    return np.array([np.sum(values[k:] * values[:-k]) / square for k in range(1, lags + 1)])


def positive_sequence(correlation: FloatArray) -> FloatArray:
    """Cut at the first pair of lags whose sum is not positive (Geyer's initial positive sequence)."""
    pairs = correlation[: len(correlation) // 2 * 2].reshape(-1, 2).sum(axis=1)
    stop = np.flatnonzero(pairs <= 0.0)
    return correlation[: 2 * (int(stop[0]) if stop.size else len(pairs))]


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Covariance of a fit's parameters.

    Attributes
    ----------
    covariance
        Shape (P, P).
    freedom
        Degrees of freedom for Student's distribution, by record the effective samples less parameters, summed.
    noises
        One per record.
    """

    covariance: FloatArray
    freedom: float
    noises: tuple[Noise, ...]

    @property
    def deviation(self) -> FloatArray:
        """Standard deviations, shape (P,)."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)), dtype=np.float64)

    @property
    def factor(self) -> float:
        """Half width of a 95 % interval in standard deviations."""
        return float(stdtrit(max(self.freedom, 1.0), 0.975))


def uncertainty(problem: OutputErrorProblem, fit: OutputErrorFit) -> Uncertainty:
    """Estimate the covariance by the sandwich formula with each record's own noise density.

    The quantiser's bias, which no amount of samples removes, is added to the steady rises.
    """
    layout = fit.layout
    noises = []
    meat = np.zeros((layout.size, layout.size))
    bread = np.zeros_like(meat)
    for r, record in enumerate(problem.records):
        rows = fit.jacobian[problem.rows[r] : problem.rows[r + 1]]
        share = float(np.sum(np.abs(rows).max(axis=0) > 0.0)) / 2.0
        noise = residual_noise(record, fit.residuals[r], share)
        noises.append(noise)
        bread += rows.T @ rows
        variance = noise.density / (record.count * record.sample_s)
        meat += (rows * (variance * record.weight)[:, None]).T @ rows
    inverse = _inverse(bread, layout.thetas)
    covariance = inverse @ meat @ inverse
    bias = max(quantiser_bias(record.noise_K, record.quantum_K) for record in problem.records)
    gains = np.arange(layout.thetas, layout.thetas + len(layout.positive))
    # An estimated offset is read off a quantised sensor as well.
    covariance[gains, gains] += bias**2 * (2.0 if layout.offset else 1.0)
    freedom = sum(noise.effective for noise in noises) / 4.0 - layout.size
    return Uncertainty(covariance, max(freedom, 3.0), tuple(noises))


def _inverse(matrix: FloatArray, thetas: int) -> FloatArray:
    """Invert; what the data do not determine keeps a wide, finite variance."""
    scale = np.sqrt(np.diag(matrix)) + 1e-12
    normal = matrix / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(normal)
    safe = np.maximum(values, 1e-10)
    inverse = (vectors / safe) @ vectors.T / np.outer(scale, scale)
    # A logarithm that no sample depends on: a factor of e^5 either way says "unknown".
    unknown = np.flatnonzero(np.sqrt(np.diag(matrix))[:thetas] < 1e-9)
    inverse[unknown, unknown] = 25.0
    return np.asarray(inverse, dtype=np.float64)


@dataclass(frozen=True)
class Criteria:
    """How well a transfer function fits the samples at one speed (or all).

    Attributes
    ----------
    mse_K2, fit_percent
        Mean square of measured minus simulated; 100 (1 - |e| / |y - mean y|).
    fpe_K2, aic, bic
        With the number of effective samples instead of samples.
    samples, effective
        How many.
    """

    mse_K2: float
    fit_percent: float
    fpe_K2: float
    aic: float
    bic: float
    samples: int
    effective: float


def criteria(error: FloatArray, measured: FloatArray, effective: float, parameters: float) -> Criteria:
    """Compute the criteria from raw residuals.

    Parameters
    ----------
    error, measured
        Measured minus simulated and the measured rise, shape (N,), K.
    effective
        Effective number of samples.
    parameters
        Number of fitted parameters that these samples paid for.
    """
    mse = float(np.mean(error**2))
    spread = float(np.sqrt(np.mean((measured - measured.mean()) ** 2)))
    fit = 100.0 * (1.0 - np.sqrt(mse) / spread) if spread > 0.0 else float("nan")
    n = max(effective, parameters + 2.0)
    log = n * np.log(max(mse, 1e-12))
    return Criteria(
        mse,
        float(fit),
        mse * (n + parameters) / (n - parameters),
        float(log + 2.0 * parameters),
        float(log + parameters * np.log(n)),
        len(error),
        float(effective),
    )


def raw_residual(problem: OutputErrorProblem, fit: OutputErrorFit, r: int) -> FloatArray:
    """Give measured minus simulated at every sample of record r, K."""
    record = problem.records[r]
    simulator = Simulator(record, problem.levels, raw=True)
    vectors = fit.vector[None, :]
    poles, steady = problem.by_level(fit.layout, vectors)
    model = simulator(poles, steady, problem.start_state(fit.layout, vectors, r))[0]
    return np.asarray(record.raw_rise - model - fit.offset, dtype=np.float64)


@dataclass(frozen=True)
class ResidualTests:
    """Is anything left in a residual?

    Attributes
    ----------
    whiteness_p
        Ljung-Box over block means: the chance of so much correlation in white noise.
    first_correlation
        Of neighbouring block means.
    independence
        Largest correlation of the residual with |PWM| at lags 0..20 over its 99 % bound; above 1 the model misses
        something that follows the input. None where PWM never changes.
    rms_K, largest_K
        Of the block means.
    """

    whiteness_p: float
    first_correlation: float
    independence: float | None
    rms_K: float
    largest_K: float


def residual_tests(record: Record, noise: Noise) -> ResidualTests:
    """Test a record's residual."""
    means = noise.blocks[np.isfinite(noise.blocks)]
    lags = min(LAGS, max(len(means) // 5, 1))
    rho = autocorrelation(means - means.mean(), lags)
    n = len(means)
    statistic = n * (n + 2.0) * float(np.sum(rho**2 / (n - np.arange(1, lags + 1)))) if n > lags + 1 else 0.0
    return ResidualTests(
        whiteness_p=float(chdtrc(lags, statistic)),
        first_correlation=float(rho[0]) if rho.size else 0.0,
        independence=_independence(record, noise),
        rms_K=float(np.sqrt(np.mean(means**2))),
        largest_K=float(np.max(np.abs(means))),
    )


def _independence(record: Record, noise: Noise) -> float | None:
    middle = (np.arange(len(noise.blocks)) + 0.5) * noise.block_s
    segments = record.segments
    at = np.clip(np.searchsorted(segments.start, middle, side="right") - 1, 0, len(segments.start) - 1)
    pwm = np.maximum(segments.pwm[at], 0).astype(np.float64)
    good = np.isfinite(noise.blocks)
    u, e = pwm[good], noise.blocks[good]
    if u.std() == 0.0 or e.std() == 0.0 or len(u) < 3 * LAGS:
        return None
    u, e = (u - u.mean()) / u.std(), (e - e.mean()) / e.std()
    # Bartlett: the variance of a cross-correlation is the sum of the product of both autocorrelations over n.
    ru, re = autocorrelation(u, LAGS), autocorrelation(e, LAGS)
    bound = 2.576 * np.sqrt(max(1.0 + 2.0 * float(np.sum(ru * re)), 0.1) / len(u))
    return float(max(abs(np.mean(u[: len(u) - k] * e[k:])) for k in range(LAGS + 1)) / bound)
