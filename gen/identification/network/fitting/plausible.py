"""What a node that nobody sees may be: as warm as the sensed ones, within a factor of e^0.5.

Without this a hidden node can stand for a source of current: a thousand kelvin behind a thousandth of a watt per
kelvin, which fits each step alone and nothing else.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.inputs import held
from gen.identification.network.fitting.physics import Shape
from gen.identification.network.fitting.steady import settled

WITHIN = 0.5
"""Standard deviation of the logarithm of a hidden node's steady rise over the mean of the sensed ones."""
SPEEDS = held(np.array([0.25, 0.5, 0.75, 1.0]), 1)


def off(structure: Shape, vector: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far hidden nodes are from that, in standard deviations.

    Returns
    -------
    residual, slopes
        Shapes (k,) and (k, p): by the parameters that all runs share.
    """
    if structure.nodes == structure.sensors:
        return np.zeros(0), np.zeros((0, structure.size))
    return _off(structure, vector[: structure.size].tobytes())


@lru_cache(maxsize=4)
def _off(structure: Shape, shared: bytes) -> tuple[FloatArray, FloatArray]:
    """The same where there are some, kept: a search asks when it tries a vector, and when it goes on from there."""
    vector, sensors = np.frombuffer(shared), structure.sensors
    found = settled(structure, SPEEDS, vector)
    rise = np.maximum(found.rise, 1e-6)
    logs, slopes = np.log(rise), found.slopes / rise[:, :, None]
    # The four speeds say the same thing: together they count once.
    unit = WITHIN * np.sqrt(SPEEDS.count)
    residual = (logs[:, sensors:] - logs[:, :sensors].mean(axis=1, keepdims=True)) / unit
    slope = (slopes[:, sensors:] - slopes[:, :sensors].mean(axis=1, keepdims=True)) / unit
    return residual.ravel(), slope.reshape(-1, structure.size)
