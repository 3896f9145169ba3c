"""Where a network settles while PWM is held, and what that depends on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Levels
from gen.identification.network.fitting.physics import Physical, Shape

ROUNDS = 6
"""Of Newton's method, from where the network would settle without natural convection."""


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
        What flows out by each temperature there, less what heats grow by, shape (L, n, n), W/K.
    physics
        Conductances and heats.
    """

    rise: FloatArray
    slopes: FloatArray
    laplacian: FloatArray
    physics: Physical


def settled(structure: Shape, levels: Levels, vector: FloatArray) -> Settled:
    """Solve L x = P at each speed, with natural convection by Newton's method.

    A path's derivative takes out what flows through it.
    """
    physics = structure.physical(levels, vector)
    incidence, nodes = structure.incidence, structure.nodes
    laplacian = np.einsum("lq,qi,qj->lij", physics.conductance, incidence, incidence, optimize=True)
    natural, own, heat = physics.natural, np.arange(nodes), physics.heat_in_room
    if physics.growth is not None:
        laplacian[:, own, own] -= physics.growth
    slope, inverse = laplacian, np.linalg.inv(laplacian)
    rise = np.einsum("lij,lj->li", inverse, heat)
    if natural is not None:
        for _ in range(ROUNDS):
            lost = np.einsum("lij,lj->li", laplacian, rise) + natural.conductance * natural.excess(rise)
            slope = laplacian.copy()
            slope[:, own, own] += natural.conductance * natural.slope(rise)
            inverse = np.linalg.inv(slope)
            rise = rise + np.einsum("lij,lj->li", inverse, heat - lost)
    slopes = np.zeros((levels.count, nodes, structure.size))
    by_flow = -(inverse @ incidence.T) * (rise @ incidence.T)[:, None, :]
    physics.by_path.add_to(slopes, by_flow)
    physics.by_heat.add_to(slopes, inverse)
    if physics.by_growth is not None:
        physics.by_growth.add_to(slopes, inverse * (physics.room_degC + rise)[:, None, :])
    if natural is not None:
        natural.by_conductance.add_to(slopes, -inverse * natural.excess(rise)[:, None, :])
    return Settled(rise, slopes, slope, physics)
