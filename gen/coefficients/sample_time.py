"""The sample time as the board's clock counts it."""

from __future__ import annotations

import math

from gen.errors import InputError

_ROUNDING = 1e-9
"""Of the time: 0.29 s are 289.99999999999997 ms in floating point."""


def milliseconds(sample_time: float, place: str = "$.sample_time_s") -> int:
    """Give the milliseconds from one sample to the next.

    The board counts milliseconds: with any other time its samples would last longer or shorter than the model's, and
    what is proven would be proven of another board.

    Parameters
    ----------
    sample_time
        In s, above 0.
    place
        Where it was said.

    Raises
    ------
    InputError
        Without a file name: it is no whole number of milliseconds.
    """
    exact = sample_time * 1000.0
    count = round(exact)
    if count < 1 or abs(exact - count) > _ROUNDING * exact:
        near = " or ".join(f"{n / 1000.0:g}" for n in (math.floor(exact), math.floor(exact) + 1) if n)
        raise InputError(
            f"found {sample_time:g} s, expected a whole number of milliseconds, which the board's clock counts: {near}",
            place=place,
        )
    return count
