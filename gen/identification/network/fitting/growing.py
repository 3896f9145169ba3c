"""Heat that grows with the temperature of where it arises, by the same share at every node.

Copper's resistance grows by 0.39 % for each kelvin; a warmer magnet is weaker (ferrite by 0.2 %), so that the same
torque asks for more current; warm grease rubs less. Runs do not tell which heat is of which kind, but what all of it
does together: P (1 + k (T - T_0)), k near what copper does of some of it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gen.arrays import FloatArray
from gen.identification.network.fitting.partial import Partial
from gen.identification.network.fitting.physics import Physical

USUAL_PER_K, UNSURE_PER_K = 0.002, 0.003
"""Mean and standard deviation of k before any run, 1/K: half of a motor's heat is copper's."""


def grown(found: Physical, place: int, vector: FloatArray, warmth: float) -> Physical:
    """Let all heats grow.

    Parameters
    ----------
    found
        With heats that do not.
    place, vector
        Of k among the parameters, shape (P,).
    warmth
        T_0: the temperature at which heats are told, degC.
    """
    share = float(vector[place])
    at_zero, power = 1.0 - share * warmth, found.heat
    heat, nodes = found.by_heat, np.arange(power.shape[1])
    of, by = np.concatenate([heat.of, nodes]), np.concatenate([heat.by, np.full(nodes.size, place)])
    return replace(
        found,
        heat=power * at_zero,
        by_heat=Partial(of, by, np.hstack([heat.value * at_zero, -warmth * power])),
        growth=power * share,
        by_growth=Partial(of, by, np.hstack([heat.value * share, power])),
        room_degC=warmth,
    )
