"""A general model: structure parameters and steady rise of one component at every |PWM|, in chosen forms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray, IntArray
from gen.identification.parts.forms import Form
from gen.identification.parts.structure import Structure


@dataclass(frozen=True)
class Shape:
    """The forms of a general model and the speeds they rest on.

    Attributes
    ----------
    structure
        Of the transfer functions.
    time, gain
        How time constants and gain go over |PWM|.
    nodes
        Identified speeds above 0, increasing.
    standstill
        Whether the structure parameters at PWM 0 are known (from cooling).
    """

    structure: Structure
    time: Form
    gain: Form
    nodes: IntArray
    standstill: bool

    @property
    def x(self) -> FloatArray:
        """The nodes as floats."""
        return self.nodes.astype(np.float64)

    @property
    def time_size(self) -> int:
        """Parameters of one time constant's curve."""
        return self.time.size(len(self.nodes))

    @property
    def size(self) -> int:
        """Length of the parameter vector."""
        order = self.structure.order
        return order * (self.time_size + self.standstill) + self.gain.size(len(self.nodes))

    def start(self, theta: FloatArray, steady: FloatArray, theta_sd: FloatArray, steady_sd: FloatArray) -> FloatArray:
        """Fit the curves to values at the nodes.

        Parameters
        ----------
        theta, theta_sd
            Shape (nodes [+ 1 for standstill, first], order), and standard deviations.
        steady, steady_sd
            Steady rise, shape (nodes,), K.
        """
        return np.concatenate([self.start_time(theta, theta_sd), self.start_gain(theta, steady, steady_sd)])

    def start_time(self, theta: FloatArray, theta_sd: FloatArray) -> FloatArray:
        """Fit the time constants' part of the vector."""
        parts = []
        moving, moving_sd = theta[int(self.standstill) :], theta_sd[int(self.standstill) :]
        for k in range(self.structure.order):
            values, weights = _to_time(self.time.quantity, moving[:, k], moving_sd[:, k])
            parts.append(self.time.fit(self.x, values, weights))
        return np.concatenate([*parts, theta[0]] if self.standstill else parts)

    def start_gain(self, theta: FloatArray, steady: FloatArray, steady_sd: FloatArray) -> FloatArray:
        """Fit the gain's part of the vector."""
        values, weights = _to_gain(self.gain.quantity, self, theta[int(self.standstill) :], steady, steady_sd)
        return self.gain.fit(self.x, values, weights)

    def evaluate(self, vector: FloatArray, pwm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Evaluate.

        Beyond the identified speeds the parameters keep their values at the nearest one; at standstill they have their
        own, where known, and a straight line leads there.

        Parameters
        ----------
        vector
            Parameters, shape (P,).
        pwm
            |PWM|, shape (m,).

        Returns
        -------
        theta, steady
            Structure parameters, shape (m, order), and steady rise, shape (m,), K.
        """
        x = np.clip(pwm, self.x[0], self.x[-1])
        gain = self.gain.size(len(self.nodes))
        theta = self.time_at(vector[:-gain], x)
        steady = self.rise_at(vector[-gain:], theta, x) * (pwm / x)
        if self.standstill:
            still = vector[self.structure.order * self.time_size :][: self.structure.order]
            share = np.clip(pwm / self.x[0], 0.0, 1.0)[:, None]
            theta = np.where(share < 1.0, share * theta + (1.0 - share) * still, theta)
        return theta, steady

    def time_at(self, part: FloatArray, x: FloatArray) -> FloatArray:
        """Structure parameters at |PWM| x from their part of the vector, as the forms go on by themselves."""
        size = self.time_size
        columns = [
            _from_time(self.time.quantity, self.time.evaluate(part[k * size : (k + 1) * size], self.x, x))
            for k in range(self.structure.order)
        ]
        return np.stack(columns, axis=1)

    def rise_at(self, part: FloatArray, theta: FloatArray, x: FloatArray) -> FloatArray:
        """Steady rise at |PWM| x from its part of the vector and the structure parameters there."""
        points = self.x
        if self.gain.quantity == "rise":  # no rise without PWM
            part, points = np.append(0.0, part), np.append(0.0, points)
        return _from_gain(self.gain.quantity, self, theta, x, self.gain.evaluate(part, points, x))


def _to_time(quantity: str, theta: FloatArray, sd: FloatArray) -> tuple[FloatArray, FloatArray]:
    sd = np.clip(sd, 0.02, 3.0)
    if quantity == "log":
        return theta, 1.0 / sd
    rate = np.exp(-theta)
    return rate, 1.0 / (rate * sd)


def _from_time(quantity: str, drawn: FloatArray) -> FloatArray:
    if quantity == "log":
        return np.clip(drawn, -20.0, 25.0)
    # A rate that is not positive is no stable system; the guard finds the absurd time constant.
    return -np.log(np.maximum(drawn, 1e-10))


def _last(structure: Structure, theta: FloatArray) -> FloatArray:
    """A(0): the product of the poles' magnitudes, shape (n,)."""
    return np.asarray(np.abs(np.prod(structure.poles(theta), axis=-1)), dtype=np.float64)


def _to_gain(
    quantity: str, shape: Shape, theta: FloatArray, steady: FloatArray, sd: FloatArray
) -> tuple[FloatArray, FloatArray]:
    relative = np.clip(sd / np.maximum(np.abs(steady), 1e-9), 0.003, 3.0)
    per_count = steady / shape.x
    if quantity == "rise":
        return steady, 1.0 / (np.abs(steady) * relative + 1e-12)
    if quantity == "log":
        return np.log(np.maximum(per_count, 1e-12)), 1.0 / relative
    value = per_count if quantity == "per_count" else per_count * _last(shape.structure, theta)
    return value, 1.0 / (np.abs(value) * relative + 1e-30)


def _from_gain(quantity: str, shape: Shape, theta: FloatArray, x: FloatArray, drawn: FloatArray) -> FloatArray:
    if quantity == "rise":
        return drawn
    if quantity == "log":
        return np.asarray(np.exp(np.clip(drawn, -40.0, 20.0)) * x, dtype=np.float64)
    if quantity == "per_count":
        return drawn * x
    return np.asarray(drawn * x / np.maximum(_last(shape.structure, theta), 1e-60), dtype=np.float64)
