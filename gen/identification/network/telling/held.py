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
    turning = inputs.turns
    pwm = np.rint(inputs.speed[turning] * full_scale).astype(np.int64)
    left = np.bincount(pwm, inputs.width[turning], full_scale + 1)
    whole, beside = left.sum(), round(0.5 * ALIKE * full_scale)
    found: list[int] = []
    for _ in range(FEW + 1):
        near = np.convolve(left, np.ones(2 * beside + 1), "same")
        at = int(np.argmax(near))
        if near[at] <= A_SPEED * whole:
            break
        about = slice(max(at - beside, 0), at + beside + 1)
        found.append(round(float(np.average(np.arange(left.size)[about], weights=left[about]))))
        left[about] = 0.0
    return sorted(found) if len(found) <= FEW and left.sum() <= (1.0 - MOST_OF_IT) * whole else []
