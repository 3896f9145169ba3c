"""The PWM profiles that all are judged by, each from a cold motor."""

from __future__ import annotations

import numpy as np

from gen.verification.profiles import Profile

NAMES = ("step", "staircase", "toggling")
LENGTH = 43_200
"""Samples of a run of 10 800 s."""
STEP_PWM = 153
STAIR_S = 600.0
TOGGLED = (51, 204)
TOGGLING_SAMPLES = 8
SAMPLE_S = 0.25


def profiles(length: int = LENGTH, seed: int = 18) -> Profile:
    """Give a lane for each of `NAMES`.

    Parameters
    ----------
    length
        Samples of each.
    seed
        Of the staircase's levels.

    Returns
    -------
    Profile
        A step to 60 %; a new random level 51..255 every 600 s; 20 % and 80 % in turn, 2 s each.
    """
    hold = round(STAIR_S / SAMPLE_S)
    levels = np.random.default_rng(seed).integers(51, 256, length // hold + 1)
    staircase = np.repeat(levels, hold)[:length]
    toggling = np.resize(np.repeat(TOGGLED, TOGGLING_SAMPLES), length)
    pwm = np.stack([np.full(length, STEP_PWM), staircase, toggling]).astype(np.int64)
    return Profile(pwm, np.zeros(len(NAMES), dtype=np.int64))
