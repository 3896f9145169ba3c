"""What the runs determine, and how well: parameters, and where the parts settle.

The covariance is that of the last linearised problem. Its weights are those of errors that last (see `weights`), so
correlated residuals do not make it too small; the prior is in it, so what the runs do not say stays as wide as that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gen.arrays import FloatArray
from gen.identification.network.fitting.bends import BEND
from gen.identification.network.fitting.inputs import Levels, held
from gen.identification.network.fitting.speed_laws import HEAT
from gen.identification.network.fitting.steady import settled
from gen.identification.network.search import Found

SENSOR_K, FORM = 0.15, 0.01
"""What the covariance does not hold, as standard deviations: a sensor's own error over its range, K; and, as a share of
the rise, what a network lacks whose conductances do not depend on temperature (natural convection, radiation)."""
UNREACHED, ALIKE = 0.04, 0.05
"""The same as a share of the rise that no run reached at a speed, by about as much as natural convection and copper
loss change on the way there; and the share of full speed within which speeds are alike."""
UNDETERMINED = 0.7
"""A parameter whose standard deviation is still this share of its prior's is not determined by the runs."""


@dataclass(frozen=True, eq=False)
class Spread:
    """Uncertainty of the parameters.

    Attributes
    ----------
    covariance
        Shape (P, P).
    share
        Standard deviation over that of the prior alone, shape (P,).
    """

    covariance: FloatArray
    share: FloatArray

    @property
    def deviation(self) -> FloatArray:
        """Standard deviations, shape (P,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


@dataclass(frozen=True, eq=False)
class Steady:
    """Where the parts settle, PWM held, L speeds.

    Attributes
    ----------
    rise
        Of all nodes, shape (L, n), K.
    deviation
        Standard deviation of the sensed nodes' rises, shape (L, S), K.
    slowest
        Slowest time constant, shape (L,), s.
    """

    rise: FloatArray
    deviation: FloatArray
    slowest: FloatArray


def spread_of(found: Found) -> Spread:
    """Give the uncertainty of a network's parameters.

    Curves over speed that hardly bend are as uncertain as if they might: that few runs ask for none that bends does not
    mean that there is none.
    """
    problem = found.problem
    matrix, _ = problem.assembled(found.fit.normal, found.vector)
    for law, at in found.structure.curves:
        matrix[at, at] += law.bending(BEND) - law.bending(found.structure.bend)
    covariance = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return Spread(covariance, np.asarray(deviation / problem.prior.deviation, dtype=np.float64))


def steady_of(found: Found, spread: Spread, pwm: ArrayLike, full_scale: int) -> Steady:
    """Give the rises at which PWM that is held settles, by the derivatives of L x = P.

    Parameters
    ----------
    pwm
        Shape (L,), counts.
    """
    structure = found.structure
    levels = held(np.asarray(pwm, dtype=np.float64), full_scale)
    at = settled(structure, levels, found.vector)
    sensors = len(structure.sensed)
    slopes, rise = at.slopes[:, :sensors], at.rise[:, :sensors]
    shared = spread.covariance[: structure.size, : structure.size]
    variance = np.einsum("lsp,pq,lsq->ls", slopes, shared, slopes, optimize=True)
    root = np.sqrt(at.physics.capacity)
    rates = np.linalg.eigvalsh(at.laplacian / (root * root[:, None]))
    beyond = np.maximum(rise - _reached(found, levels), 0.0)
    whole = np.maximum(variance, 0.0) + SENSOR_K**2 + (FORM * rise) ** 2 + (UNREACHED * beyond) ** 2
    return Steady(at.rise, np.sqrt(whole), 1.0 / np.maximum(rates[:, 0], 1e-12))


def _reached(found: Found, levels: Levels) -> FloatArray:
    """Give the highest rise of each sensed node in the runs at about each speed, shape (L, S), K; 0 where none was."""
    inputs = found.problem.inputs
    rise = found.fit.evaluated.after[:, : len(found.structure.sensed)] - found.problem.ambient(found.vector)[:, None]
    turning = inputs.turns
    made = np.zeros((levels.count, rise.shape[1]))
    for k, speed in enumerate(levels.speed):
        near = turning & (np.abs(inputs.speed - speed) <= ALIKE)
        made[k] = np.max(rise[near], axis=0, initial=0.0)
    return made


def undetermined(found: Found, spread: Spread, columns: Sequence[str] = ()) -> list[str]:
    """Name what the runs do not determine: capacities, conductances, heats, those by measured columns too."""
    structure = found.structure
    names = (*structure.names, "ambient")
    open_ = spread.share > UNDETERMINED
    said = [f"capacity of {names[i]}" for i in range(structure.nodes) if open_[structure.capacities[i]]]
    for (i, j), law, at in zip(structure.paths, structure.laws, structure.conductances, strict=True):
        if open_[at.start + law.level]:
            said.append(f"path {names[i]} - {names[j]}")
    for node, at in zip(structure.heated, structure.heats, strict=True):
        if open_[at.start + HEAT.level]:
            said.append(f"heat of {names[node]}")
    said += [
        f"heat of {names[node]} by {columns[c]}"
        for (c, node), at in zip(structure.fed, structure.feeds, strict=True)
        if open_[at]
    ]
    return said
