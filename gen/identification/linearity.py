"""One linear system or not: the scatter of the poles over speed, and the averaged-pole model's error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gen.identification.output_error import OutputErrorFit
from gen.identification.structure import FloatArray

LIMIT = 0.10
"""Coefficient of variation up to which one linear time-invariant system is accepted."""


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
    linear
        Whether every coefficient of variation is within the limit; None with one speed.
    averaged_K
        Steady error of the averaged-pole model (mean poles, mean gain) by speed, K.
    """

    speeds: NDArray[np.int64]
    poles: NDArray[np.complex128]
    mean: NDArray[np.complex128]
    variance: FloatArray
    cv: FloatArray
    linear: bool | None
    averaged_K: FloatArray


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
        bool(np.all(cv <= LIMIT)) if count > 1 else None,
        np.asarray(steady - fit.steady, dtype=np.float64),
    )
