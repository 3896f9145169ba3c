"""The last step: all parameters of the chosen schedules at once, on the runs themselves, by simulation error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from gen.arrays import FloatArray
from gen.identification.parts.curves import Shape
from gen.identification.parts.output_error import OutputErrorFit, OutputErrorProblem
from gen.identification.parts.structure import PoleArray
from gen.identification.parts.uncertainty import residual_noise


@dataclass(frozen=True, eq=False)
class Model:
    """The general model of one component, refined on its runs.

    Attributes
    ----------
    shape, vector
        Forms and parameters.
    covariance
        Of the parameters, with each run's own noise density, shape (P, P).
    offset_K
        What the sensor reads over the rise; not part of the model.
    residuals
        Measured minus model by record, at its blocks, K.
    """

    shape: Shape
    vector: FloatArray
    covariance: FloatArray
    offset_K: float
    residuals: tuple[FloatArray, ...]

    def evaluate(self, pwm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Structure parameters (m, order) and steady rise (m,) at |PWM|."""
        return self.shape.evaluate(self.vector, pwm)

    def poles(self, pwm: FloatArray) -> PoleArray:
        """Poles at |PWM|, shape (m, order), rad/s."""
        return self.shape.structure.poles(self.evaluate(pwm)[0])

    def steady_sd(self, pwm: FloatArray) -> FloatArray:
        """Standard deviation of the steady rise from the parameters' covariance, shape (m,), K."""
        return self._deviation(lambda vector: self.shape.evaluate(vector, pwm)[1])

    def theta_sd(self, pwm: FloatArray) -> FloatArray:
        """Standard deviation of the structure parameters, shape (m, order)."""
        return self._deviation(lambda vector: self.shape.evaluate(vector, pwm)[0])

    def _deviation(self, value: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Propagate the covariance to a function of the parameters by its gradient there.

        Parameters may differ by ten orders of magnitude and determine each other almost wholly, so the principal axes
        are those of the correlations, and steps are small against the parameters, not against their deviations.
        """
        deviation = np.sqrt(np.maximum(np.diag(self.covariance), 1e-300))
        step = 1e-6 * np.maximum(np.abs(self.vector), 1e-9)
        gradient = np.stack(
            [
                (value(self.vector + change) - value(self.vector - change)) * (deviation[k] / (2.0 * step[k]))
                for k, change in enumerate(np.diag(step))
            ],
            axis=-1,
        )
        values, axes = np.linalg.eigh(self.covariance / np.outer(deviation, deviation))
        along = (gradient @ axes) * np.sqrt(np.maximum(values, 0.0))
        return np.asarray(np.sqrt(np.sum(along**2, axis=-1)), dtype=np.float64)


def refine(problem: OutputErrorProblem, fit: OutputErrorFit, shape: Shape, vector: FloatArray, most: int = 15) -> Model:
    """Refine a general model.

    Parameters
    ----------
    problem, fit
        The records and the transfer functions at the identified speeds, which give the initial states.
    shape, vector
        The chosen forms and where to start.
    most
        Largest number of steps.
    """
    task = _Task(problem, fit, shape)
    begin = np.concatenate([vector, fit.vector[fit.layout.thetas + len(fit.layout.positive) :]])
    scale = np.maximum(np.abs(begin), 1e-12)

    # Where the runs say little a time constant stays near its start: one standard deviation is a factor of e.
    hold = _time_scales(shape, vector)
    prior = np.zeros((len(hold), len(begin)))
    prior[np.arange(len(hold)), np.arange(len(hold))] = scale[: len(hold)] * hold

    def value(z: FloatArray) -> FloatArray:
        return np.concatenate([task.weighted(begin + scale * z)[0], prior @ z])

    def slope(z: FloatArray) -> FloatArray:
        return np.concatenate([task.weighted(begin + scale * z)[1] * scale, prior])

    # .. and never leaves it by more than 0.6 of that.
    room = np.full(len(begin), np.inf)
    held = np.flatnonzero(hold)
    room[held] = 0.6 / (scale[held] * hold[held])
    found = least_squares(
        value,
        np.zeros(len(begin)),
        jac=slope,
        bounds=(-room, room),
        x_scale="jac",
        ftol=1e-7,
        xtol=1e-8,
        max_nfev=most,
    )
    full = begin + scale * np.asarray(found.x, dtype=np.float64)
    residuals, jacobian = task.evaluate(full)
    covariance = _covariance(problem, jacobian, residuals)
    size = shape.size
    return Model(
        shape,
        full[:size],
        covariance[:size, :size],
        float(full[-1]) if fit.layout.offset else 0.0,
        tuple(residuals),
    )


def _time_scales(shape: Shape, vector: FloatArray) -> FloatArray:
    """One over the prior standard deviation of each parameter of the time constants, which come first."""
    size = shape.structure.order * shape.time_size
    moving = np.zeros(size)
    if shape.time.interpolates:
        moving = np.ones(size) if shape.time.quantity == "log" else 1.0 / np.maximum(np.abs(vector[:size]), 1e-12)
    still = np.ones(shape.structure.order if shape.standstill else 0)
    return np.concatenate([moving, still])


class _Task:
    def __init__(self, problem: OutputErrorProblem, fit: OutputErrorFit, shape: Shape) -> None:
        self.problem, self.layout, self.shape = problem, fit.layout, shape
        self.first = fit.layout.thetas + len(fit.layout.positive)
        self.levels = problem.levels.astype(np.float64)
        self._key = b""
        self._value: tuple[FloatArray, FloatArray] | None = None

    def evaluate(self, full: FloatArray) -> tuple[list[FloatArray], FloatArray]:
        """Residuals by record and the weighted Jacobian."""
        size = self.shape.size
        count = len(full)
        # A parameter may be anything from 1e-12 (a gain) to 10 (a logarithm): steps are relative, yet never zero.
        step = np.maximum(np.abs(full), np.where(np.arange(count) < size, 1e-9, 1.0)) * 1e-6
        batch = np.repeat(full[None, :], count + 1, axis=0)
        batch[np.arange(count) + 1, np.arange(count)] += step
        levels = [self.shape.evaluate(v[:size], self.levels) for v in batch]
        poles = self.shape.structure.poles(np.stack([level[0] for level in levels]))
        steady = np.stack([level[1] for level in levels])
        vectors = np.zeros((count + 1, self.layout.size))
        vectors[:, self.first :] = batch[:, size:]
        jacobian = np.empty((int(self.problem.rows[-1]), count))
        residuals = []
        for r, record in enumerate(self.problem.records):
            start = self.problem.start_state(self.layout, vectors, r)
            simulated = self.problem.simulators[r](poles, steady, start)
            if self.layout.offset:
                simulated = simulated + vectors[:, -1:]
            rows = slice(int(self.problem.rows[r]), int(self.problem.rows[r + 1]))
            jacobian[rows] = -((simulated[1:] - simulated[0]) / step[:, None]).T * self.problem.weights[r][:, None]
            residuals.append(record.rise - simulated[0])
        return residuals, jacobian

    def weighted(self, full: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Weighted residuals and Jacobian, remembered for the last point."""
        key = full.tobytes()
        if self._value is None or key != self._key:
            residuals, jacobian = self.evaluate(full)
            weighted = np.concatenate([w * e for w, e in zip(self.problem.weights, residuals, strict=True)])
            self._key, self._value = key, (weighted, jacobian)
        return self._value


def _covariance(problem: OutputErrorProblem, jacobian: FloatArray, residuals: list[FloatArray]) -> FloatArray:
    scale = np.sqrt(np.sum(jacobian**2, axis=0)) + 1e-150
    normal = jacobian / scale
    meat = np.zeros((jacobian.shape[1],) * 2)
    for r, record in enumerate(problem.records):
        rows = normal[problem.rows[r] : problem.rows[r + 1]]
        noise = residual_noise(record, residuals[r], float(np.sum(np.abs(rows).max(axis=0) > 1e-12)) / 2.0)
        variance = noise.density / (record.count * record.sample_s)
        meat += (rows * (variance * record.weight)[:, None]).T @ rows
    values, vectors = np.linalg.eigh(normal.T @ normal)
    inverse = (vectors / np.maximum(values, 1e-10)) @ vectors.T
    return np.asarray(inverse @ meat @ inverse / np.outer(scale, scale), dtype=np.float64)
