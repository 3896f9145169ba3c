"""Times as the board counts them: in samples."""

from __future__ import annotations

from math import ceil

from gen.coefficients.alarms import MOST_SAMPLES


def samples(seconds: float, sample_time: float, most: int = MOST_SAMPLES) -> int:
    """Give how many samples are as long as a time, or longer.

    Parameters
    ----------
    seconds
        The time, s.
    sample_time
        In s.
    most
        What the board can count to; without it in 16 bits. Longer times are so long.
    """
    return min(most, ceil(seconds / sample_time - 1e-9))
