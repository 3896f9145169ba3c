"""What a rest would tell of a motor whose runs have none: the same forecast, less uncertain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gen.identification.network.fitting.weights import weights
from gen.identification.network.search import Found
from gen.identification.network.telling.foresight import ROW_S, along, foresight
from gen.identification.network.telling.uncertainty import Spread
from gen.runs import Run

REST_S, BEFORE_S = 1200.0, 10_800.0
"""The rest, and the run before it from cold."""


@dataclass(frozen=True)
class Rested:
    """Uncertainty of what is forecast while the motor rests, without and with a rest among the runs.

    Attributes
    ----------
    now_K, then_K
        Root mean square over the sensed nodes and the stops of the profile of `foresight`, K.
    pwm
        |PWM| before the rest.
    """

    now_K: float
    then_K: float
    pwm: int


def rested(found: Found, spread: Spread, turned: tuple[int, int], full_scale: int) -> Rested:
    """Say what `REST_S` at PWM 0, after a run at the highest |PWM|, would tell.

    The readings would count as those of the runs do; the run before the rest is taken for known already.

    Parameters
    ----------
    found, spread
        The network and its parameters' covariance.
    turned
        Lowest and highest |PWM| that turned in the runs.
    full_scale
        The count that is 100 %.
    """
    time = np.arange(0.0, BEFORE_S + REST_S, ROW_S)
    inputs, _, slopes = along(found, Run(time, np.where(time < BEFORE_S, turned[1], 0)), full_scale)
    rests = ~inputs.turns
    lines = slopes[rests] * np.sqrt(weights(inputs, found.density))[rests][:, :, None]
    lines = lines.reshape(-1, found.structure.size)
    size = found.structure.size
    covariance = spread.covariance[:size, :size]
    # Of rows J with unit noise: P - P J' (J P J' + 1)^-1 J P.
    carried = lines @ covariance
    less = carried.T @ np.linalg.solve(carried @ lines.T + np.eye(len(lines)), carried)

    def at_rest_K(of: Spread) -> float:
        return float(np.sqrt(np.mean(foresight(found, of, turned, full_scale).within(0, 0) ** 2)))

    return Rested(at_rest_K(spread), at_rest_K(Spread(covariance - less, spread.share)), turned[1])
