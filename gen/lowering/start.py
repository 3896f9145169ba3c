"""What a start can be off by: thousandths of a kelvin, as the board turns them into a word of x1."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gen.arrays import IntArray

#: Largest |rise| that a start can have, in thousandths of a kelvin: all steps then fit 32 bits.
LARGEST_MK = (1 << 23) - 1
#: How many starts are compared at once.
_TOGETHER = 1 << 19


def worst_start(word: Callable[[IntArray], IntArray], bits: int, range_mK: tuple[int, int]) -> float:
    """The most that a start can be off, in K: of every one in the range, in whole numbers.

    Parameters
    ----------
    word
        Gives the words for rises in thousandths of a kelvin.
    bits
        Of a word after the binary point, at most 39.
    range_mK
        Lowest and highest rise to start from, in thousandths of a kelvin.
    """
    low, high = range_mK
    worst = 0
    for first in range(low, high + 1, _TOGETHER):
        rises = np.arange(first, min(first + _TOGETHER, high + 1), dtype=np.int64)
        worst = max(worst, int(np.abs(word(rises) * 1000 - (rises << bits)).max()))
    return float(np.nextafter(worst / 1000.0 * 2.0**-bits, np.inf)) if worst else 0.0
