"""Which speeds a motor was held at: what others do is then taken from what is usual, and not from the runs."""

from __future__ import annotations

import numpy as np

from gen.identification.network.fitting.inputs import Inputs

ALIKE = 0.05
"""Speeds within this share of the full scale are one."""
MOST_OF_IT = 0.7
"""Share of the time that turns at a few speeds; ramps and starts are the rest."""
A_SPEED = 0.15
"""Share from which a further speed was held, too."""
FEW = 2
"""Curves of heats and conductances over speed have more numbers than so many speeds can tell."""


def only_speeds(inputs: Inputs, full_scale: int) -> list[int]:
    """Give the |PWM| at which a motor spent most of the time that it turned, where these are few.

    Parameters
    ----------
    inputs
        Bins of the runs.
    full_scale
        The count that is 100 %.

    Returns
    -------
    list of int
        One or two |PWM|, increasing, each the mean of those about it; none where there are more.
    """
    turning = inputs.rest < 0.5
    speed, left = inputs.speed[turning], inputs.width[turning].copy()
    whole = left.sum()
    found = []
    for _ in range(FEW + 1):
        near = np.abs(speed[:, None] - speed) <= 0.5 * ALIKE
        at = near[int(np.argmax(near @ left))]
        if left[at].sum() < A_SPEED * whole:
            break
        found.append(round(float(np.average(speed[at], weights=left[at])) * full_scale))
        left[at] = 0.0
    return sorted(found) if len(found) <= FEW and left.sum() <= (1.0 - MOST_OF_IT) * whole else []
