"""Runs as sensors would have shown them whose gains are right and that do not drift: what a file says of that is taken
off beforehand.

All that is fitted is then linear in temperatures, and what is found of a sensor lies between the motor and its gain:
the file's writer (:mod:`gen.refinement.network.changing.writer`) passes it through the gain again.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from gen.arrays import FloatArray
from gen.model.network import Network
from gen.runs import Run


def gains(network: Network) -> FloatArray:
    """1 + g of each sensed node's sensor, shape (S,)."""
    return np.array([1.0 + node.sensor.gain_error for node in network.sensed if node.sensor is not None])


def freed(run: Run, network: Network, ambient: ArrayLike) -> Run:
    """Give a run whose readings hold their sensors' offsets and lags alone.

    Parameters
    ----------
    run
        As it was measured, or as the model shows it.
    network
        Whose sensors.
    ambient
        Along the run, degC, a number or shape (N,).
    """
    temps = dict(run.temps)
    for node in network.sensed:
        sensor = node.sensor
        if sensor is None or node.name not in temps:
            continue
        if sensor.drift:
            temps[node.name] = temps[node.name] - sensor.drifted(run.time_s - run.time_s[0])
        if sensor.gain_error != 0.0:
            temps[node.name] = sensor.temperature(temps[node.name], ambient) + sensor.offset
    return replace(run, temps=temps)
