"""One linear system or not: the scatter of the poles over speed, and the averaged-pole model's error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.arrays import FloatArray, IntArray
from gen.identification.parts.output_error import OutputErrorFit

LIMIT = 0.10
"""Coefficient of variation of a pole, and error of the averaged-pole model's steady rise as a share of the rise, up to
which one linear time-invariant system is accepted."""


@dataclass(frozen=True, eq=False)
class Linearity:
    """Poles over speed.

    Attributes
    ----------
    speeds
        Identified |PWM| above 0, shape (n,).
    poles
        Shape (n, order), rad/s.
    mean, variance, cv
        By pole: mean, sample variance E|p - mean|^2, and sqrt(variance) / |Re mean|, shape (order,).
    averaged_K
        Steady error of the averaged-pole model (mean poles, mean gain) by speed, K.
    steady_K
        Identified steady rise by speed, K.
    """

    speeds: IntArray
    poles: NDArray[np.complex128]
    mean: NDArray[np.complex128]
    variance: FloatArray
    cv: FloatArray
    averaged_K: FloatArray
    steady_K: FloatArray

    @property
    def averaged_share(self) -> float:
        """Largest error of the averaged-pole model's steady rise, as a share of the identified rise."""
        return float(np.max(np.abs(self.averaged_K) / np.maximum(np.abs(self.steady_K), 1e-9)))

    @property
    def linear(self) -> bool | None:
        """Whether poles and steady rises both stay within the limit; None with one speed."""
        if len(self.speeds) < 2:
            return None
        return bool(np.all(self.cv <= LIMIT)) and self.averaged_share <= LIMIT

    @property
    def verdict(self) -> str:
        """The answer in words, with what speaks against one linear system."""
        if self.linear is None:
            return "one speed: whether one linear system would do is not known"
        if self.linear:
            return f"one linear system would do: its steady rise is off by up to {self.averaged_share:.0%}"
        scattered = f"poles vary by up to {np.max(self.cv):.0%}" if np.any(self.cv > LIMIT) else "poles are alike"
        rise = f"the averaged poles' steady rise is off by up to {self.averaged_share:.0%}"
        return f"not one linear system: {scattered}, {rise}"


def linearity(fit: OutputErrorFit) -> Linearity:
    """Compute the figures of a fit."""
    nodes = fit.layout.positive
    structure = fit.layout.structure
    theta = fit.theta[len(fit.layout.nodes) - len(nodes) :]
    poles = np.asarray(structure.poles(structure.sorted(theta)), dtype=np.complex128)
    mean = poles.mean(axis=0)
    count = len(nodes)
    variance = np.sum(np.abs(poles - mean) ** 2, axis=0) / max(count - 1, 1)
    cv = np.sqrt(variance) / np.abs(mean.real)
    gain = np.mean(fit.steady / nodes * np.abs(np.prod(poles, axis=1)))
    steady = gain * nodes / np.abs(np.real(np.prod(mean)))
    return Linearity(
        nodes,
        poles,
        mean,
        np.asarray(variance, dtype=np.float64),
        np.asarray(cv, dtype=np.float64),
        np.asarray(steady - fit.steady, dtype=np.float64),
        np.asarray(fit.steady, dtype=np.float64),
    )
