"""Where a network settles while PWM is held, and what that depends on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.identification.network.bins import FloatArray
from gen.identification.network.inputs import Levels
from gen.identification.network.physics import Physical, Shape


@dataclass(frozen=True, eq=False)
class Settled:
    """Steady rises at L speeds.

    Attributes
    ----------
    rise
        Of all nodes, shape (L, n), K.
    slopes
        Derivatives by the parameters that all runs share, shape (L, n, p).
    laplacian
        Conductances as a matrix, shape (L, n, n), W/K.
    physics
        Conductances and heats.
    """

    rise: FloatArray
    slopes: FloatArray
    laplacian: FloatArray
    physics: Physical


def settled(structure: Shape, levels: Levels, vector: FloatArray) -> Settled:
    """Solve L x = P at each speed; a path's derivative takes out what flows through it."""
    physics = structure.physical(levels, vector)
    incidence, nodes = structure.incidence, structure.nodes
    laplacian = np.einsum("lq,qi,qj->lij", physics.conductance, incidence, incidence, optimize=True)
    inverse = np.linalg.inv(laplacian)
    rise = np.einsum("lij,lj->li", inverse, physics.heat)
    slopes = np.zeros((levels.count, nodes, structure.size))
    by_flow = -(inverse @ incidence.T) * (rise @ incidence.T)[:, None, :]
    physics.by_path.add_to(slopes, by_flow)
    physics.by_heat.add_to(slopes, inverse)
    return Settled(rise, slopes, laplacian, physics)
