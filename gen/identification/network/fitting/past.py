"""Where hidden nodes probably are at the start of a run, as the network's own likely pasts let expect it."""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import Inputs, held, joined, turning
from gen.identification.network.fitting.structure import Structure
from gen.model.network_past import SPEEDS, Dynamics, speeds_of_pasts, start_weights

WHOLE = 1
"""Full scale of speeds that are shares of it."""


def past_weights(structure: Structure, vector: FloatArray, inputs: Inputs) -> FloatArray | None:
    """Give the share of each sensed node's rise that each hidden one has (:mod:`gen.model.network_past`).

    Parameters
    ----------
    structure, vector
        The network, and its parameters, shape (P,).
    inputs
        The runs, for the speeds that they hold.

    Returns
    -------
    FloatArray or None
        Shape (h, S); None where the input heats nothing.
    """
    levels = inputs.levels
    turned = levels.speed[levels.turns]
    if not structure.hidden or not turned.size:
        return None
    speeds = speeds_of_pasts(float(turned.min()), float(turned.max()))
    physics = structure.physical(joined(held(np.zeros(1), WHOLE), turning(speeds, WHOLE)), vector)
    count = physics.capacity.size
    each = []
    for at in range(1 + SPEEDS):
        flows = (structure.incidence.T * physics.conductance[at]) @ structure.incidence
        growth = np.zeros(count) if physics.growth is None else physics.growth[at]
        matrix = (np.diag(growth) - flows) / physics.capacity[:, None]
        each.append(Dynamics(matrix, physics.heat_in_room[at] / physics.capacity))
    resting = Dynamics(each[0].matrix, np.zeros(count))
    return start_weights(resting, each[1:], range(structure.sensors))
