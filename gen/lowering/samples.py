"""Times as the board counts them: in samples, in 16 bits."""

from __future__ import annotations

from math import ceil

from gen.coefficients.alarms import MOST_SAMPLES


def samples(seconds: float, sample_time: float) -> int:
    """Give how many samples are as long as a time, or longer.

    Parameters
    ----------
    seconds
        The time, s; beyond what the board can count it is the most that it can.
    sample_time
        In s.
    """
    return min(MOST_SAMPLES, ceil(seconds / sample_time - 1e-9))
