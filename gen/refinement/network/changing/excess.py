"""What natural convection and radiation carry beyond a conductance, known along a run before anything is fitted.

A path with a law carries G law(T, T'), which is G (T - T') and G times an excess. The first is a conductance like any
other. The excess goes with how warm both ends are, and that is measured, or known well enough from the file as it is: a
tenth too warm changes an excess by a fifth, and that of radiation is a quarter of the whole at a rise of 60 K.
"""

from __future__ import annotations

import numpy as np

from gen.arrays import FloatArray
from gen.coefficients import Coefficients
from gen.model.laws import Radiation
from gen.model.network import Network
from gen.model.network_solution import NetworkSolution
from gen.replay import Inputs
from gen.runs import Run

REFERENCE = 25.0
"""degC, at which a radiation that is sought has its conductance."""


def sensed_first(network: Network) -> list[int]:
    """Give the nodes' places in the file, the sensed ones first."""
    numbers = range(len(network.nodes))
    return sorted(numbers, key=lambda k: network.nodes[k].sensor is None)


def count(network: Network) -> int:
    """How many excesses there are: of each law of the file, then of a radiation of each node."""
    return len(network.laws) + len(network.nodes)


def radiation_of(network: Network, node: int) -> int:
    """Which excess is that of a node's radiation to the ambient, the sensed nodes first."""
    return len(network.laws) + node


def excesses(coefficients: Coefficients, run: Run, inputs: Inputs) -> list[FloatArray]:
    """Give all excesses at each row of a run, shape (rows,) each, K.

    Parameters
    ----------
    coefficients
        The file.
    run, inputs
        The run, freed of wrong gains (:func:`~gen.refinement.network.changing.freed.freed`), and what drives the model
        along it.
    """
    network = coefficients.model.network
    assert network is not None
    ambient = np.broadcast_to(np.asarray(inputs.ambient, dtype=np.float64), run.time_s.shape)
    first = {name: value + float(ambient[0]) for name, value in inputs.first_rise.items()}
    solution = NetworkSolution(coefficients.model)
    states = solution.states_along(run.time_s, run.pwm, ambient, inputs.channels, first)
    warm = [_measured(run, network, k, states[:, k]) for k in range(len(network.nodes))]
    made = []
    for number, law in network.laws:
        path = network.paths[number]
        one = warm[network.index(path.first)]
        other = ambient if path.second is None else warm[network.index(path.second)]
        made.append(law.driving(one, other) - (one - other))
    radiation = Radiation(REFERENCE)
    return made + [radiation.driving(warm[k], ambient) - (warm[k] - ambient) for k in sensed_first(network)]


def _measured(run: Run, network: Network, number: int, otherwise: FloatArray) -> FloatArray:
    """How warm a node is, degC: as measured, straight lines across gaps; as the model has it where nothing was."""
    node = network.nodes[number]
    values = None if node.sensor is None else run.temps.get(node.name)
    if node.sensor is None or values is None or not np.isfinite(values).any():
        return otherwise
    seen = np.isfinite(values)
    return np.asarray(np.interp(run.time_s, run.time_s[seen], values[seen] - node.sensor.offset))
